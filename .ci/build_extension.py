"""Build the extension zips for Blender, with the wheels of what they need inside.

    python3 run.py build                             the zip for this machine, in dist/
    python3 run.py build --platform windows-x64      for another platform
    python3 run.py build --all                       for every platform of the manifest
    python3 run.py build --all --update-manifest     after a change of the lock: list its wheels

The wheels are fetched into dist/wheels/ at the versions, and checked against the hashes, of the lock.
What Blender has itself (numpy, and bpy of course) is left out. Blender's own tool makes and checks the zips.
"""

from __future__ import annotations

import argparse
import hashlib
import importlib.metadata
import importlib.util
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterable
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[1]
MANIFEST = ROOT / "blender_manifest.toml"
LOCK = ROOT / "requirements.lock"
# Not in ROOT/wheels: Blender would unpack them, for 9 s, when a linked checkout is enabled.
WHEELS = ROOT / "dist" / "wheels"

BLENDERS_OWN = ("bpy", "numpy")  # and with bpy what it needs; Blender brings them
PYTHONS = ("3.13", "3.14")
LARGEST_ZIP_BYTES = 200_000_000

# The newest systems whose wheels are taken: Blender's official builds need glibc 2.28; opencv needs macOS 13.
MANYLINUX = (
    "manylinux_2_28",
    "manylinux_2_27",
    "manylinux_2_24",
    "manylinux_2_17",
    "manylinux2014",
    "manylinux_2_5",
)
PLATFORM_TAGS = {
    "linux-x64": [f"{tag}_x86_64" for tag in MANYLINUX],
    "linux-arm64": [f"{tag}_aarch64" for tag in MANYLINUX],
    "windows-x64": ["win_amd64"],
    "macos-arm64": ["macosx_13_0_arm64"],
}
WHEEL_PLATFORMS = {  # the platform part of the wheels' file names
    "linux-x64": r"manylinux.*_x86_64",
    "linux-arm64": r"manylinux.*_aarch64",
    "windows-x64": r"win_amd64",
    "macos-arm64": r"macosx_.*_(arm64|universal2)",
}


class BuildError(Exception):
    """The zip cannot be built; the message says what to do."""


# ---------------------------------------------------------------- what goes in


def bundled_packages() -> list[str]:
    """The project's dependencies and theirs, at run time, without what Blender brings."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    found: set[str] = set()
    waiting = [Requirement(text) for text in project["dependencies"]]
    while waiting:
        requirement = waiting.pop()
        name = canonicalize_name(requirement.name)
        wanted = requirement.marker is None or requirement.marker.evaluate({"extra": ""})
        if name in BLENDERS_OWN or name in found or not wanted:
            continue
        found.add(name)
        waiting += [Requirement(text) for text in importlib.metadata.requires(name) or []]
    return sorted(found)


def locked_blocks(lock: str) -> dict[str, str]:
    """The lines of the lock by package name: its version and hashes."""
    blocks = re.findall(r"^([a-z0-9-]+)(==.*(?:\n[ ]+--hash.*)*)", lock, re.MULTILINE)
    return {name: name + rest + "\n" for name, rest in blocks}


def wheel_package(file_name: str) -> tuple[str, str]:
    """Name and version of a wheel's package, out of its file name."""
    name, version = file_name.split("-")[:2]
    return canonicalize_name(name), version


def suits_platform(file_name: str, blender_platform: str) -> bool:
    """Whether a wheel is for the platform: by its tags, or because it is for any."""
    tag = file_name.removesuffix(".whl").split("-")[-1]
    return re.fullmatch(f"any|{WHEEL_PLATFORMS[blender_platform]}", tag) is not None


def manifest_wheels() -> list[str]:
    """The file names of the manifest's list of wheels."""
    manifest = tomllib.loads(MANIFEST.read_text("utf-8"))
    return [Path(wheel).name for wheel in manifest["wheels"]]


# ---------------------------------------------------------------- fetching


def fetch(blender_platform: str, lock: str) -> list[str]:
    """Fetch a platform's wheels for every Python into `WHEELS`, hashes checked, and return their names."""
    blocks = locked_blocks(lock)
    names: set[str] = set()
    with tempfile.TemporaryDirectory() as folder:
        requirements = Path(folder) / "requirements.txt"
        requirements.write_text("".join(blocks[name] for name in bundled_packages()), "utf-8")
        for python in PYTHONS:
            target = Path(folder) / python
            say(f"Fetching the wheels for {blender_platform}, Python {python}")
            download(requirements, target, blender_platform, python)
            for wheel in sorted(target.glob("*.whl")):
                names.add(wheel.name)
                shutil.move(wheel, WHEELS / wheel.name)
    return sorted(names)


def download(requirements: Path, target: Path, blender_platform: str, python: str) -> None:
    """Let pip choose and fetch the wheels for one platform and Python."""
    tags = [word for tag in PLATFORM_TAGS[blender_platform] for word in ("--platform", tag)]
    command = ["download", "--quiet", "--disable-pip-version-check", "--no-deps", "--only-binary=:all:"]
    command += ["--require-hashes", "--requirement", str(requirements), "--dest", str(target)]
    command += ["--implementation", "cp", "--python-version", python, *tags]
    if subprocess.run([sys.executable, "-m", "pip", *command], check=False).returncode != 0:
        raise BuildError(
            f"The wheels for {blender_platform}, Python {python} could not be fetched; pip's reason is above."
        )


def is_fetched(file_name: str, lock: str) -> bool:
    """Whether the wheel lies in `WHEELS` with a hash that the lock names."""
    path = WHEELS / file_name
    if not path.is_file():
        return False
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    return f"sha256:{digest}" in locked_blocks(lock).get(wheel_package(file_name)[0], "")


def wheels_for(blender_platform: str, lock: str) -> list[str]:
    """The wheels of a platform as the manifest lists them, fetched where they are not here yet."""
    listed = sorted(name for name in manifest_wheels() if suits_platform(name, blender_platform))
    if listed and all(is_fetched(name, lock) for name in listed) and agree_with_lock(listed, lock):
        return listed
    fetched = fetch(blender_platform, lock)
    if fetched != listed:
        difference = sorted(set(fetched) ^ set(listed))
        raise BuildError(
            f"blender_manifest.toml does not list the wheels of requirements.lock ({', '.join(difference)})."
            " Rewrite its list: python3 run.py build --all --update-manifest"
        )
    return fetched


def agree_with_lock(names: Iterable[str], lock: str) -> bool:
    """Whether the wheels are those of the bundled packages at the lock's versions."""
    blocks = locked_blocks(lock)
    listed = {f"{name}=={version}" for name, version in map(wheel_package, names)}
    return listed == {re.split(r"[ \\;]", blocks[name])[0] for name in bundled_packages()}


# ---------------------------------------------------------------- the manifest


def toml_list(name: str, values: Iterable[str]) -> str:
    """A list as it stands in the manifest, one value a line."""
    lines = "".join(f'    "{value}",\n' for value in values)
    return f"{name} = [\n{lines}]"


def with_list(manifest: str, name: str, values: Iterable[str]) -> str:
    """The manifest's text with one of its lists replaced."""
    replaced, count = re.subn(rf"^{name} = \[[^\]]*\]", toml_list(name, values), manifest, flags=re.MULTILINE)
    if count != 1:
        raise BuildError(f"blender_manifest.toml has no list `{name} = [...]` to write to.")
    return replaced


def update_manifest(lock: str) -> None:
    """Fetch the wheels of every platform and write their names into the manifest."""
    names = sorted({name for blender_platform in PLATFORM_TAGS for name in fetch(blender_platform, lock)})
    text = MANIFEST.read_text("utf-8")
    MANIFEST.write_text(with_list(text, "wheels", [f"./wheels/{name}" for name in names]), "utf-8")
    say(f"blender_manifest.toml lists {len(names)} wheels")


# ---------------------------------------------------------------- building


def blender_tool(*words: str | Path) -> None:
    """Run Blender's own extension tool, which needs no Blender."""
    bpy = importlib.util.find_spec("bpy")
    if bpy is None or bpy.origin is None:
        raise BuildError("bpy is not installed here. Build with: python3 run.py build")
    tool = next(Path(bpy.origin).parent.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py"))
    command = [sys.executable, str(tool), *[str(word) for word in words]]
    if subprocess.run(command, check=False).returncode != 0:
        raise BuildError("Blender's extension tool refused it, for the reason above.")


def valid_tags() -> Path:
    """Blender's own list of tags."""
    bpy = importlib.util.find_spec("bpy")
    assert bpy is not None  # noqa: S101 - blender_tool has used it
    assert bpy.origin is not None  # noqa: S101 - as above
    return next(Path(bpy.origin).parent.glob("*/scripts/modules/_bpy_internal/extensions/tags.py"))


def build(blender_platform: str, wheels: list[str], output: Path) -> Path:
    """Build and check the zip of one platform."""
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "source"
        skip = shutil.ignore_patterns(".*", "__pycache__", "wheels", "dist", "out")
        shutil.copytree(ROOT, source, ignore=skip)
        text = with_list(MANIFEST.read_text("utf-8"), "wheels", [f"./wheels/{name}" for name in wheels])
        (source / MANIFEST.name).write_text(with_list(text, "platforms", [blender_platform]), "utf-8")
        (source / "wheels").mkdir()
        for name in wheels:
            shutil.copy(WHEELS / name, source / "wheels" / name)
        blender_tool(
            "build",
            "--split-platforms",
            "--valid-tags",
            valid_tags(),
            "--source-dir",
            source,
            "--output-dir",
            folder,
        )
        (built,) = Path(folder).glob("*.zip")
        blender_tool("validate", "--valid-tags", valid_tags(), built)
        if built.stat().st_size > LARGEST_ZIP_BYTES:
            raise BuildError(
                f"{built.name} is {built.stat().st_size / 1e6:.0f} MB, over Blender's limit of 200 MB."
            )
        output.mkdir(parents=True, exist_ok=True)
        return Path(shutil.move(built, output / built.name))


def this_platform() -> str:
    """Blender's name for this machine, e.g. linux-x64."""
    system = {"Darwin": "macos"}.get(platform.system(), platform.system().lower())
    machine = {"x86_64": "x64", "amd64": "x64", "aarch64": "arm64"}.get(
        platform.machine().lower(), platform.machine().lower()
    )
    return f"{system}-{machine}"


def say(text: str) -> None:
    """Tell what is being done."""
    print(f"[spectral-probe] {text}", file=sys.stderr, flush=True)


def parse(words: list[str]) -> argparse.Namespace:
    """The options."""
    parser = argparse.ArgumentParser(
        prog="run.py build", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    which = parser.add_mutually_exclusive_group()
    which.add_argument(
        "--platform", choices=sorted(PLATFORM_TAGS), help="which platform; default: this machine's"
    )
    which.add_argument("--all", action="store_true", help="every platform")
    parser.add_argument(
        "--update-manifest", action="store_true", help="rewrite the manifest's list of wheels first"
    )
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "dist", help="the folder for the zips")
    return parser.parse_args(words)


def main(words: list[str]) -> int:
    """Build what is asked for."""
    options = parse(words)
    lock = LOCK.read_text("utf-8")
    WHEELS.mkdir(parents=True, exist_ok=True)
    try:
        if options.update_manifest:
            update_manifest(lock)
        platforms = list(PLATFORM_TAGS) if options.all else [options.platform or this_platform()]
        for blender_platform in platforms:
            if blender_platform not in PLATFORM_TAGS:
                raise BuildError(
                    f"There is no Blender 5.2 for {blender_platform}. Choose one with --platform."
                )
            built = build(blender_platform, wheels_for(blender_platform, lock), options.output)
            say(f"{built}: {built.stat().st_size / 1e6:.0f} MB")
    except BuildError as error:
        say(str(error))
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""The wheels of every platform's zip: named for it, and machine code for it inside."""

from __future__ import annotations

import struct
import zipfile
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

import pytest
from packaging import tags
from packaging.utils import parse_wheel_filename

# What Blender 5.2 itself asks of a system, and the newest tags of it that its Python takes.
MACOS = (13, 0)
GLIBC_MINOR = 28
PLATFORMS = {
    "linux-x64": [f"manylinux_2_{minor}_x86_64" for minor in range(5, GLIBC_MINOR + 1)],
    "linux-arm64": [f"manylinux_2_{minor}_aarch64" for minor in range(17, GLIBC_MINOR + 1)],
    "windows-x64": ["win_amd64"],
    "macos-arm64": list(tags.mac_platforms(MACOS, "arm64")),
}
PYTHONS = ((3, 13), (3, 14))
MACHINES = {
    "linux-x64": ("elf", 62),
    "linux-arm64": ("elf", 183),
    "windows-x64": ("pe", 0x8664),
    "macos-arm64": ("macho", 0x0100000C),
}


def accepted(platform: str, python: tuple[int, int]) -> set[tags.Tag]:
    """Every tag that the platform's Python installs."""
    names = PLATFORMS[platform]
    return {*tags.cpython_tags(python, platforms=names), *tags.compatible_tags(python, platforms=names)}


def machines(code: bytes) -> set[tuple[str, int]]:
    """For which machines a library is: several in a universal one of macOS; none where it is no machine code."""
    if code[:4] == b"\x7fELF":
        return {("elf", struct.unpack_from("<H", code, 18)[0])}
    if code[:2] == b"MZ":
        (header,) = struct.unpack_from("<I", code, 0x3C)
        return {("pe", struct.unpack_from("<H", code, header + 4)[0])}
    if code[:4] == b"\xcf\xfa\xed\xfe":
        return {("macho", struct.unpack_from("<I", code, 4)[0])}
    if code[:4] == b"\xca\xfe\xba\xbe":
        (count,) = struct.unpack_from(">I", code, 4)
        return {("macho", struct.unpack_from(">I", code, 8 + 20 * number)[0]) for number in range(count)}
    return set()


def libraries(wheel: zipfile.ZipFile) -> Iterator[str]:
    """The compiled modules and libraries in a wheel."""
    for name in wheel.namelist():
        path = PurePosixPath(name)
        if path.suffix in {".so", ".pyd", ".dll", ".dylib"} or ".so." in path.name:
            yield name


def wrong_libraries(wheel_file: zipfile.ZipFile, platform: str) -> list[str]:
    """The libraries of a wheel that are for another machine."""
    wrong = []
    for name in libraries(wheel_file):
        with wheel_file.open(name) as library:
            if MACHINES[platform] not in machines(library.read(4096)):
                wrong.append(name)
    return wrong


@pytest.fixture(scope="session")
def zips(project_root: Path, manifest) -> dict[str, Path]:
    """The zips that were built here, by platform: all of them after `run.py build --all`."""
    found = {}
    for platform in PLATFORMS:
        path = (
            project_root / "dist" / f"{manifest['id']}-{manifest['version']}-{platform.replace('-', '_')}.zip"
        )
        if path.is_file():
            found[platform] = path
    if not found:
        pytest.skip("no zip is built: python3 run.py build")
    return found


@pytest.mark.parametrize("platform", PLATFORMS)
def test_every_listed_wheel_installs_on_its_platform(builder, platform):
    names = [name for name in builder.manifest_wheels() if builder.suits_platform(name, platform)]
    fitting = set.union(*(accepted(platform, python) for python in PYTHONS))
    assert names
    for name in names:
        assert parse_wheel_filename(name)[3] & fitting, f"{name} installs on no Python of {platform}"


def test_no_listed_wheel_is_for_a_platform_that_is_not_built(builder):
    for name in builder.manifest_wheels():
        assert any(builder.suits_platform(name, platform) for platform in PLATFORMS), name


def test_a_wheel_of_a_newer_system_would_be_noticed():
    newer = (
        "rawpy-0.28.0-cp313-cp313-manylinux_2_39_x86_64.whl",
        "rawpy-0.28.0-cp313-cp313-macosx_15_0_arm64.whl",
    )
    for name, platform in zip(newer, ("linux-x64", "macos-arm64"), strict=True):
        assert not parse_wheel_filename(name)[3] & accepted(platform, (3, 13))


def test_the_zips_hold_their_platforms_machine_code_and_no_numpy(zips):
    for platform, path in zips.items():
        with zipfile.ZipFile(path) as archive:
            wheels = [name for name in archive.namelist() if name.endswith(".whl")]
            assert wheels
            for name in wheels:
                assert not PurePosixPath(name).name.startswith(("numpy-", "bpy-")), name
                with archive.open(name) as file, zipfile.ZipFile(file) as wheel:
                    assert wrong_libraries(wheel, platform) == [], f"{name} in {path.name}"
                    roots = {entry.split("/")[0] for entry in wheel.namelist()}
                    assert not roots & {"numpy", "bpy"}, name


def test_machine_code_for_another_machine_would_be_noticed(tmp_path):
    path = tmp_path / "x.whl"
    with zipfile.ZipFile(path, "w") as wheel:
        wheel.writestr("a.so", b"\x7fELF" + bytes(14) + struct.pack("<H", 183) + bytes(40))
    with zipfile.ZipFile(path) as wheel:
        assert wrong_libraries(wheel, "linux-x64") == ["a.so"]
        assert wrong_libraries(wheel, "linux-arm64") == []

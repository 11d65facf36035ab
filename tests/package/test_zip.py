"""The zip holds the product and nothing else."""

import re
import tomllib
import zipfile
from pathlib import PurePosixPath

import pytest

# What may be in it, as patterns of whole paths.
PRODUCT = re.compile(
    r"""
    blender_manifest\.toml | __init__\.py | properties\.py | preferences\.py
    | versions\.py | file_handlers\.py
    | README\.md | CHANGELOG\.md | LICENSE
    | (operators|panels|settings)/[\w/]+\.py
    | spectral_probe/[\w/]+\.py
    | spectral_probe/data/([\w-]+/)*[^./][^/]*\.(csv|toml|json|npz|txt)
    | translations/((__init__|in_window|po|templates)\.py | [a-z]{2,3}(_[A-Z]{2})?\.po)
    | assets/[^/]+\.(blend|cats\.txt)
    | sample_scenes/(?!.*/\.).*\.(dng|toml|csv|json|exr|tif|png|jpg|blend|md|txt)
    | presets/spectral_probe/(capture|lamps|render)/[\w,-]+\.toml
    | wheels/[^/]+\.whl
    """,
    re.VERBOSE,
)
LARGEST_ZIP_BYTES = 200_000_000  # the limit of Blender's extension platform


@pytest.fixture(scope="module")
def names(extension_zip) -> list[str]:
    with zipfile.ZipFile(extension_zip) as archive:
        assert archive.testzip() is None
        return archive.namelist()


def test_it_holds_nothing_but_the_product(names):
    assert [name for name in names if not PRODUCT.fullmatch(name)] == []


@pytest.mark.parametrize(
    "name",
    [
        "run.py",
        "tests/core/test_x.py",
        ".ci/run",
        "spectral_probe/x.pyc",
        "sample_scenes/a/.x.png",
        "docs/a.md",
    ],
)
def test_what_is_no_product_would_be_noticed(name):
    assert not PRODUCT.fullmatch(name)


def test_it_holds_all_of_the_code(names, project_root):
    code = {file.name for file in project_root.glob("*.py")} - {"run.py"}
    for folder in ("spectral_probe", "operators", "panels", "settings"):
        code |= {file.relative_to(project_root).as_posix() for file in (project_root / folder).rglob("*.py")}
    code |= {f"translations/{name}.py" for name in ("__init__", "in_window", "po", "templates")}
    assert {name for name in names if name.endswith(".py")} == code


def test_it_holds_the_licence_and_the_data(names, project_root):
    data = project_root / "spectral_probe" / "data"
    expected = {
        file.relative_to(project_root).as_posix()
        for file in data.rglob("*")
        if file.is_file() and file.suffix not in {".pyc"}
    }
    assert expected | {"LICENSE", "blender_manifest.toml"} <= set(names)


def test_its_wheels_are_the_manifests_for_its_platform(names, builder, extension_zip):
    wheels = {PurePosixPath(name).name for name in names if name.startswith("wheels/")}
    platform = builder.this_platform()
    assert wheels == {name for name in builder.manifest_wheels() if builder.suits_platform(name, platform)}
    with zipfile.ZipFile(extension_zip) as archive:
        inside = tomllib.loads(archive.read("blender_manifest.toml").decode())
    assert inside["platforms"] == [platform]
    assert {PurePosixPath(name).name for name in inside["wheels"]} == wheels


def test_it_is_small_enough(extension_zip):
    assert extension_zip.stat().st_size < LARGEST_ZIP_BYTES

"""The asset library: what is in it, and that it renders when it is appended."""

import importlib.util
from pathlib import Path

import bpy
import pytest

FOLDER = Path(__file__).resolve().parents[2] / "assets"
BLEND = FOLDER / "spectral_materials.blend"


@pytest.fixture(scope="module")
def build(in_extension):
    """What the library knows by name: what the .blend was built from."""
    spec = importlib.util.spec_from_file_location("assets_build", FOLDER / "build.py")
    build = importlib.util.module_from_spec(spec)
    import sys

    sys.modules["assets_build"] = build
    spec.loader.exec_module(build)
    build.assets = {
        asset.name: asset for asset in build.wanted(lambda name: in_extension(f"spectral_probe.{name}"))
    }
    yield build
    del sys.modules["assets_build"]


@pytest.fixture
def appended(scene):  # noqa: ARG001  # a new file first
    """Every asset, appended to a new file."""
    with bpy.data.libraries.load(str(BLEND), assets_only=True) as (source, target):
        target.materials = source.materials
    return {material.name: material for material in target.materials}


def test_it_is_small():
    assert BLEND.stat().st_size < 2_000_000


def test_it_holds_what_the_library_knows_by_name(build, appended):
    assert set(appended) == set(build.assets)
    assert len(build.assets) >= 60
    written = (FOLDER / "blender_assets.cats.txt").read_text("utf-8")
    assert written == build.catalogue_text([*build.assets.values()])


def test_settings_passports_and_previews_came_along(build, appended):
    catalogues = dict(
        line.split(":")[:2]
        for line in (FOLDER / "blender_assets.cats.txt").read_text().splitlines()
        if ":" in line
    )
    for name, asset in build.assets.items():
        settings, about = appended[name].spectral_probe, appended[name].asset_data
        for key, value in asset.settings.items():
            assert getattr(settings, key) == (pytest.approx(value) if isinstance(value, float) else value), (
                name
            )
        assert catalogues[about.catalog_id] == asset.catalogue, name
        assert (about.description, about.author) == (asset.about, "The Spectral Probe authors"), name
        assert asset.licence in about.license, name
        assert {"spectral", *asset.tags} == {tag.name for tag in about.tags}, name
        assert tuple(appended[name].preview.image_size) == (128, 128), name


def test_the_look_is_what_the_library_gives_today(appended, in_extension):
    """Else: assets/build.py again."""
    look = in_extension("operators.bridge.look")
    for name, material in appended.items():
        before = tuple(material.diffuse_color)
        look.material_look(material)
        assert tuple(material.diffuse_color) == pytest.approx(before, abs=2e-3), name


def test_every_asset_can_be_rendered_spectrally(scene, appended, in_extension):
    thing = bpy.context.object
    thing.data.materials.clear()
    for material in appended.values():
        thing.data.materials.append(material)
    with in_extension("operators.bridge.materials").spectral_materials(
        scene, one_wavelength=True
    ) as materials:
        assert materials.dispersive
        assert len(materials.spectra) >= 50

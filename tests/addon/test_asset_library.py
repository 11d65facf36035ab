"""The place of the asset library in Blender's preferences."""

from pathlib import Path

import bpy
import pytest

MODULE = "bl_ext.user_default.spectral_probe"
FOLDER = Path(__file__).resolve().parents[2] / "assets"


@pytest.fixture
def addon():
    """The extension in the preferences, as the person's click puts it there; loading it in a test does not."""
    added = bpy.context.preferences.addons.new()
    added.module = MODULE
    yield added
    bpy.context.preferences.addons.remove(added)


def ours():
    return [
        e for e in bpy.context.preferences.filepaths.asset_libraries if e.name.startswith("Spectral Probe")
    ]


def test_one_button_adds_it_and_one_removes_it(addon):
    operators = bpy.ops.spectral_probe
    assert operators.add_asset_library() == {"FINISHED"}
    assert [Path(entry.path).resolve() for entry in ours()] == [FOLDER]
    assert addon.preferences.asset_library
    assert not operators.add_asset_library.poll(), "it is there"
    assert operators.remove_asset_library() == {"FINISHED"}
    assert ours() == []
    assert not addon.preferences.asset_library
    assert not operators.remove_asset_library.poll()


@pytest.mark.usefixtures("addon")
def test_it_goes_with_the_extension_and_comes_back_with_it(extension):
    bpy.ops.spectral_probe.add_asset_library()
    extension.unregister()
    try:
        assert ours() == [], "an entry that leads nowhere"
    finally:
        extension.register()
    assert len(ours()) == 1
    bpy.ops.spectral_probe.remove_asset_library()


@pytest.mark.usefixtures("addon")
def test_an_entry_of_a_folder_that_is_gone_is_put_right(in_extension):
    libraries = bpy.context.preferences.filepaths.asset_libraries
    for version in ("5.1", "5.2"):
        libraries.new(name="Spectral Probe", directory=f"/gone/{version}/extensions/spectral_probe/assets")
    in_extension("operators.bridge.asset_library").add_entry()
    assert [Path(entry.path).resolve() for entry in ours()] == [FOLDER]
    bpy.ops.spectral_probe.remove_asset_library()
    assert ours() == []


@pytest.mark.usefixtures("addon")
def test_another_library_of_the_same_name_is_left_alone(tmp_path):
    entry = bpy.context.preferences.filepaths.asset_libraries.new(
        name="Spectral Probe", directory=str(tmp_path)
    )
    bpy.ops.spectral_probe.add_asset_library()
    bpy.ops.spectral_probe.remove_asset_library()
    assert [
        Path(kept.path)
        for kept in bpy.context.preferences.filepaths.asset_libraries
        if kept.path == entry.path
    ]
    bpy.context.preferences.filepaths.asset_libraries.remove(entry)

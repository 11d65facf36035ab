"""Our paths follow a file that is saved elsewhere, and what is appended or linked; no handler stays behind."""

from pathlib import Path

import bpy
import pytest

pytestmark = pytest.mark.usefixtures("scene")


@pytest.fixture
def project(tmp_path):
    """A saved file with a probe, a photograph, a spectrum and a lamp beside it; and another folder."""
    for name in (
        "a/spectral_probe/probe/probe.exr",
        "a/photos/v0.dng",
        "a/spectra/red.csv",
        "a/spectra/ball.csv",
    ):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    (tmp_path / "b" / "deep").mkdir(parents=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a" / "scene.blend"))
    settings = bpy.context.scene.spectral_probe
    settings.views.add().photos.add().path = "//photos/v0.dng"
    settings.views[0].photos.add().path = "//photos/lost.dng"
    settings.ball_material = "//spectra/ball.csv"
    material = bpy.data.materials.new("red")
    material.use_fake_user = True
    material.spectral_probe.reflectance_path = "//spectra/red.csv"
    bpy.data.lights.new("lamp", "POINT").spectral_probe.lamp = "//spectra/red.csv"
    bpy.ops.wm.save_mainfile()
    return tmp_path


def paths_of(scene):
    settings = scene.spectral_probe
    return [
        settings.probe_directory,
        settings.views[0].photos[0].path,
        settings.ball_material,
        bpy.data.materials["red"].spectral_probe.reflectance_path,
    ]


def test_saved_elsewhere_they_point_to_the_same(project):
    bpy.ops.wm.save_as_mainfile(filepath=str(project / "b" / "deep" / "scene.blend"))
    assert paths_of(bpy.context.scene) == [
        "//../../a/spectral_probe/probe/",
        "//../../a/photos/v0.dng",
        "//../../a/spectra/ball.csv",
        "//../../a/spectra/red.csv",
    ]
    settings = bpy.context.scene.spectral_probe
    assert settings.views[0].photos[1].path == "//photos/lost.dng"
    assert settings.render_directory == "//spectral_probe/render/"  # nothing is there: a render will make it
    bpy.ops.wm.open_mainfile(filepath=str(project / "b" / "deep" / "scene.blend"))
    assert all(Path(bpy.path.abspath(path)).exists() for path in paths_of(bpy.context.scene))


def test_a_copy_saved_elsewhere_changes_nothing_here(project):
    before = paths_of(bpy.context.scene)
    bpy.ops.wm.save_as_mainfile(filepath=str(project / "b" / "copy.blend"), copy=True)
    assert paths_of(bpy.context.scene) == before
    bpy.ops.wm.open_mainfile(filepath=str(project / "b" / "copy.blend"))
    assert all(Path(bpy.path.abspath(path)).exists() for path in paths_of(bpy.context.scene))


def test_saved_in_its_place_nothing_changes(project):
    before = paths_of(bpy.context.scene)
    bpy.ops.wm.save_as_mainfile(filepath=str(project / "a" / "scene_002.blend"))
    assert paths_of(bpy.context.scene) == before


@pytest.mark.parametrize("saved", [True, False])
def test_appended_they_point_to_the_same(project, saved):
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    if saved:
        bpy.ops.wm.save_as_mainfile(filepath=str(project / "b" / "other.blend"))
    own = bpy.context.scene
    with bpy.data.libraries.load(str(project / "a" / "scene.blend")) as (found, into):
        into.scenes, into.materials = found.scenes, ["red"]
    appended = next(scene for scene in bpy.data.scenes if scene != own)
    paths = paths_of(appended)
    assert all(path.startswith("//../a/" if saved else str(project)) for path in paths)
    assert all(Path(bpy.path.abspath(path)).exists() for path in paths)


@pytest.mark.parametrize("again", [False, True])
def test_linked_they_are_found_from_their_own_file(project, again):
    bpy.ops.wm.save_as_mainfile(filepath=str(project / "b" / "other.blend"))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(project / "b" / "other.blend"))
    with bpy.data.libraries.load(str(project / "a" / "scene.blend"), link=True) as (_, into):
        into.materials = ["red"]
    if again:
        into.materials[0].use_fake_user = True
        bpy.ops.mesh.primitive_plane_add()
        bpy.context.object.data.materials.append(into.materials[0])
        bpy.ops.wm.save_mainfile()
        bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath)
    linked = bpy.data.materials["red"]
    assert linked.library is not None
    assert Path(linked.spectral_probe.reflectance_path) == project / "a" / "spectra" / "red.csv"


def test_a_failed_save_changes_nothing(project):
    before = paths_of(bpy.context.scene)
    with pytest.raises(RuntimeError):
        bpy.ops.wm.save_as_mainfile(filepath=str(project / "nowhere" / "scene.blend"))
    assert paths_of(bpy.context.scene) == before


def test_handlers_come_and_go(extension, in_extension):
    handlers = in_extension("file_handlers")
    there = [handler for name in handlers._LISTS for handler in getattr(bpy.app.handlers, name)]
    assert len([each for each in there if each.__module__ == handlers.__name__]) == len(handlers._LISTS)
    extension.unregister()
    try:
        left = [handler.__module__ for name in handlers._LISTS for handler in getattr(bpy.app.handlers, name)]
        assert not [module for module in left if "spectral_probe" in module]
        assert not bpy.app.timers.is_registered(handlers._read_open_file)
    finally:
        extension.register()

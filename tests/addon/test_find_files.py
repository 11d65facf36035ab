"""Missing files are told, found again by folder, and our paths made relative or absolute."""

import shutil

import bpy
import pytest

pytestmark = pytest.mark.usefixtures("scene")
ops = bpy.ops.spectral_probe

FILES = (
    "photos/v0.dng",
    "photos/v1.dng",
    "spectra/red.csv",
    "probe/probe.exr",
    "render/xyz.exr",
    "render/comparison/x",
)


@pytest.fixture
def project(tmp_path):
    """A saved file and what it needs, in relative paths."""
    for name in FILES:
        path = tmp_path / "work" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "work" / "scene.blend"))
    settings = bpy.context.scene.spectral_probe
    view = settings.views.add()
    for number in range(2):
        view.photos.add().path = f"//photos/v{number}.dng"
    settings.probe_directory = settings.edits.probe_directory = settings.probe.directory = "//probe/"
    settings.probe.width_px = 64
    settings.render_directory, settings.render.passes = "//render", 3
    settings.comparison.directory = "//render/comparison"
    material = bpy.data.materials.new("red")
    material.use_fake_user = True
    material.spectral_probe.reflectance_path = "//spectra/red.csv"
    material.spectral_probe.glass = "red"  # a name of the library is no file
    bpy.ops.wm.save_mainfile()
    return tmp_path


@pytest.fixture
def moved(project):
    """All files but the .blend in another place, the photographs in a folder of another name."""
    (project / "archive" / "2024").mkdir(parents=True)
    for name in ("spectra", "probe", "render"):
        shutil.move(project / "work" / name, project / "archive" / "2024" / name)
    shutil.move(project / "work" / "photos", project / "archive" / "shots")
    (project / "archive" / "edits" / "1234").mkdir(parents=True)
    (project / "archive" / "edits" / "1234" / "probe.exr").touch()
    bpy.ops.wm.open_mainfile(filepath=str(project / "work" / "scene.blend"))
    return project


def missing():
    return bpy.context.window_manager.spectral_probe_files.missing.splitlines()


def test_nothing_is_missing(project):
    bpy.ops.wm.open_mainfile(filepath=str(project / "work" / "scene.blend"))
    assert missing() == []


def test_what_is_missing_is_known_when_the_file_is_open(moved):
    assert sorted(missing()) == sorted(str(moved / "work" / name) for name in FILES if not name.endswith("x"))


def test_files_are_found_in_a_folder(moved):
    assert ops.find_files(directory=str(moved / "archive")) == {"FINISHED"}
    settings = bpy.context.scene.spectral_probe
    assert [photo.path for photo in settings.views[0].photos] == [
        "//../archive/shots/v0.dng",
        "//../archive/shots/v1.dng",
    ]
    assert settings.probe_directory == "//../archive/2024/probe/"
    assert settings.edits.probe_directory == settings.probe.directory == settings.probe_directory
    assert settings.render_directory == "//../archive/2024/render"
    assert settings.comparison.directory == "//../archive/2024/render/comparison"
    assert bpy.data.materials["red"].spectral_probe.reflectance_path == "//../archive/2024/spectra/red.csv"
    assert bpy.data.materials["red"].spectral_probe.glass == "red"
    assert missing() == []


def test_what_is_not_there_stays_missing(moved):
    (moved / "archive" / "shots" / "v1.dng").unlink()
    ops.find_files(directory=str(moved / "archive"))
    assert missing() == [str(moved / "work" / "photos" / "v1.dng")]
    assert bpy.context.scene.spectral_probe.views[0].photos[1].path == "//photos/v1.dng"


def test_no_folder_is_said(project):
    with pytest.raises(RuntimeError, match="No folder is chosen"):
        ops.find_files()
    with pytest.raises(RuntimeError, match="is no folder"):
        ops.find_files(directory=str(project / "nowhere"))


def test_a_linked_material_is_left_to_its_file(moved):
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(str(moved / "work" / "scene.blend"), link=True) as (_, into):
        into.materials = ["red"]
    ops.find_files(directory=str(moved / "archive"))
    assert into.materials[0].spectral_probe.reflectance_path == "//spectra/red.csv"


def test_paths_become_absolute_and_relative_again(project):
    settings = bpy.context.scene.spectral_probe
    read = lambda: [  # noqa: E731  (twice the same list)
        settings.views[0].photos[0].path, settings.probe_directory, settings.edits.probe_directory,
        settings.render_directory, bpy.data.materials["red"].spectral_probe.reflectance_path,
    ]  # fmt: skip
    before = read()
    assert ops.make_paths(form="ABSOLUTE") == {"FINISHED"}
    work = project / "work"
    assert read() == [
        f"{work}/photos/v0.dng",
        f"{work}/probe/",
        f"{work}/probe/",
        f"{work}/render",
        f"{work}/spectra/red.csv",
    ]
    assert bpy.data.materials["red"].spectral_probe.glass == "red"
    ops.make_paths(form="RELATIVE")
    assert read() == before


def test_an_unsaved_file_has_nothing_to_be_relative_to():
    assert not ops.make_paths.poll()
    with pytest.raises(RuntimeError, match=r"Save the \.blend first"):
        ops.make_paths()


def test_the_panel_names_what_is_missing(moved, drawn):
    widgets = drawn(bpy.types.SPECTRAL_PROBE_PT_light_probe)
    texts = " ".join(widget.get("draw_string", "") for widget in widgets)
    assert "probe.exr" in texts
    assert any("find_files" in widget.get("operator", "") for widget in widgets)
    ops.find_files(directory=str(moved / "archive"))
    widgets = drawn(bpy.types.SPECTRAL_PROBE_PT_light_probe)
    assert not any("find_files" in widget.get("operator", "") for widget in widgets)


def test_the_panel_warns_of_settings_of_a_later_version(drawn):
    bpy.context.scene.spectral_probe.version = 99
    texts = " ".join(
        widget.get("draw_string", "") for widget in drawn(bpy.types.SPECTRAL_PROBE_PT_light_probe)
    )
    assert "later version" in texts


def test_buttons_say_which_photographs_are_missing(moved):
    with pytest.raises(RuntimeError, match=r"Photographs are missing: 2\. Find them"):
        ops.build_probe()
    ops.find_files(directory=str(moved / "archive"))
    assert ops.build_probe.poll()

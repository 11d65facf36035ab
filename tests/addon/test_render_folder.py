"""Two scenes, or two .blend files, do not render into one folder unnoticed."""

import json
import shutil

import bpy
import pytest

ops = bpy.ops.spectral_probe


@pytest.fixture
def folders(in_extension):
    return in_extension("operators.render_folder")


@pytest.fixture
def project(tmp_path, scene):
    """A saved .blend whose scene was rendered."""
    folder = tmp_path / "work"
    rendered = folder / "spectral_probe" / "render"
    rendered.mkdir(parents=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "scene.blend"))
    (rendered / "report.json").write_text(json.dumps({"scene": scene.name, "blend": "../../scene.blend"}))
    (rendered / "xyz.exr").touch()
    scene.spectral_probe.render.passes = 5
    scene.spectral_probe.comparison.mean_de2000 = 1.5
    bpy.ops.wm.save_mainfile()
    return folder


def test_a_scene_renders_again_to_its_folder(project, folders):
    assert folders.render_folder(bpy.context.scene) == project / "spectral_probe" / "render"


def test_a_full_copy_does_not_replace_the_render(project, folders):
    original = bpy.context.scene
    bpy.ops.scene.new(type="FULL_COPY")
    copy = bpy.context.scene
    with pytest.raises(Exception, match='holds the render of scene "Scene", which this one would replace'):
        folders.render_folder(copy)
    assert folders.render_folder(copy, replace=True) == folders.render_folder(original)
    assert ops.own_render_folder() == {"FINISHED"}
    assert copy.spectral_probe.render_directory == "//spectral_probe/render_Scene.001/"
    assert folders.render_folder(copy) == project / "spectral_probe" / "render_Scene.001"
    assert (copy.spectral_probe.render.passes, original.spectral_probe.render.passes) == (0, 5)
    assert copy.spectral_probe.comparison.mean_de2000 == 0
    assert original.spectral_probe.render_directory == "//spectral_probe/render/"


@pytest.mark.usefixtures("project")
@pytest.mark.parametrize("button", ["render_spectral", "render_animation", "render_and_compare"])
def test_the_render_buttons_say_it(scene, button):
    scene.spectral_probe.light = "WORLD"
    bpy.ops.scene.new(type="FULL_COPY")
    copy = bpy.context.scene
    copy.render.engine, copy.render.resolution_x, copy.render.resolution_y = "CYCLES", 8, 8
    with pytest.raises(RuntimeError, match="Choose another folder, or press Own Folder"):
        getattr(ops, button)()


@pytest.mark.usefixtures("project")
def test_the_panel_offers_a_folder_of_its_own(drawn):
    button = "own_render_folder"
    panel = bpy.types.SPECTRAL_PROBE_PT_render
    assert not any(button in widget.get("operator", "") for widget in drawn(panel))
    bpy.ops.scene.new(type="LINK_COPY")
    assert any(button in widget.get("operator", "") for widget in drawn(panel))


@pytest.mark.usefixtures("project")
def test_a_renamed_scene_keeps_its_folder(folders):
    bpy.context.scene.name = "Another"
    assert folders.render_folder(bpy.context.scene)


def test_the_next_version_beside_it_renders_to_the_same(project, folders):
    bpy.ops.wm.save_as_mainfile(filepath=str(project / "scene_002.blend"))
    assert folders.render_folder(bpy.context.scene)


def test_a_blend_saved_elsewhere_does_not_replace_the_render(project, folders):
    (project.parent / "other").mkdir()
    bpy.ops.wm.save_as_mainfile(filepath=str(project.parent / "other" / "scene.blend"))
    assert bpy.context.scene.spectral_probe.render_directory == "//../work/spectral_probe/render/"
    with pytest.raises(Exception, match=r"holds the render of .*work/scene\.blend"):
        folders.render_folder(bpy.context.scene)


def test_a_copied_project_is_its_own(project, folders):
    shutil.copytree(project, project.parent / "copied")
    bpy.ops.wm.open_mainfile(filepath=str(project.parent / "copied" / "scene.blend"))
    assert folders.render_folder(bpy.context.scene) == project.parent / "copied" / "spectral_probe" / "render"


@pytest.mark.parametrize("content", ["", "[]", '{"scene": 3, "blend": null}'])
def test_a_damaged_report_stops_nothing(project, folders, content):
    (project / "spectral_probe" / "render" / "report.json").write_text(content)
    assert folders.render_folder(bpy.context.scene)

"""A packed probe is in the .blend byte by byte, works where its files are gone, and comes out again where it was."""

import math
import os
import shutil
from pathlib import Path

import bpy
import pytest

ops = bpy.ops.spectral_probe


@pytest.fixture
def project(tmp_path, scene, write_small_probe):
    """A saved .blend that its probe lights, packed, with a glass put in."""
    folder = tmp_path / "work"
    folder.mkdir()
    write_small_probe(folder / "probe")
    (folder / "probe" / "report.json").write_text('{"views": [],\r\n "µ": 1}', encoding="utf-8", newline="")
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "scene.blend"))
    settings = scene.spectral_probe
    settings.probe_directory = "//probe/"
    settings.probe.width_px = 32
    settings.region.elevation = math.radians(30)
    ops.light_world(normalise=False)
    ops.add_glass()
    assert ops.pack_probe() == {"FINISHED"}
    bpy.ops.wm.save_mainfile()
    return folder


@pytest.fixture
def alone(project, tmp_path):
    """The .blend opened without the files."""
    shutil.move(project / "probe", tmp_path / "away")
    bpy.ops.wm.open_mainfile(filepath=str(project / "scene.blend"))
    return project


def contents(folder):
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and path.name != "layers.exr"
    }


def test_every_file_is_packed_byte_by_byte(alone, tmp_path):
    expected = contents(tmp_path / "away")
    assert {"probe.exr", "world.exr", "report.json", "preview.png"} < set(expected)
    assert len(expected) == 7  # and three of the edited light
    assert ops.unpack_probe() == {"FINISHED"}
    assert contents(alone / "probe") == expected
    assert not bpy.context.scene.spectral_probe.packed.files
    assert not [image.name for image in bpy.data.images if image.name.startswith("Spectral Probe File")]


def test_saving_without_the_probe_keeps_the_earlier_copy(project, tmp_path, in_extension):
    """Its disk may be gone, or its folder another one where nothing was built yet."""
    settings = bpy.context.scene.spectral_probe
    packed = [item.digest for item in settings.packed.files]
    settings.packed.outdated = True
    of_session = in_extension("operators.bridge.packed_probe").temporary_folder(settings)
    shutil.rmtree(of_session, ignore_errors=True)  # another test's
    shutil.move(project / "probe", tmp_path / "away")
    bpy.ops.wm.save_mainfile()
    assert [item.digest for item in settings.packed.files] == packed
    assert settings.packed.outdated, "the next time that the probe is there it is packed"
    bpy.ops.wm.open_mainfile(filepath=str(project / "scene.blend"))
    assert [item.digest for item in bpy.context.scene.spectral_probe.packed.files] == packed


def test_the_world_is_packed_and_shares_its_bytes(project):
    files = {item.name: item for item in bpy.context.scene.spectral_probe.packed.files}
    shown = next(
        node.image for node in bpy.context.scene.world.node_tree.nodes if node.type == "TEX_ENVIRONMENT"
    )
    state = bpy.context.scene.spectral_probe.edits.state
    assert shown.packed_file.data == files[f"edits/{state}/world.exr"].image.packed_file.data
    assert shown.packed_file.data == (project / "probe" / "edits" / state / "world.exr").read_bytes()


def test_buttons_work_with_the_copy_alone(alone, in_extension):
    settings = bpy.context.scene.spectral_probe
    assert settings.probe_directory == "//probe/"
    assert ops.light_world(normalise=False) == {"FINISHED"}
    assert ops.show_confidence() == {"FINISHED"}
    assert ops.replace_lamp() == {"FINISHED"}
    assert [item.name for item in settings.edits.items] == ["red", "LED-B3"]
    assert not (alone / "probe").exists()
    bpy.ops.wm.save_mainfile()  # packs what was edited
    shutil.rmtree(in_extension("operators.bridge.packed_probe").temporary_folder(settings))
    bpy.ops.wm.open_mainfile(filepath=str(alone / "scene.blend"))
    probe = in_extension("operators.settings").probe_folder(bpy.context.scene.spectral_probe) / "probe.exr"
    edits = in_extension("spectral_probe.files.probe_exr").read_probe(probe).edits
    assert [edit.name for edit in edits] == ["red", "LED-B3"]
    assert ops.remove_edit(everything=True) == {"FINISHED"}
    assert ops.unpack_probe() == {"FINISHED"}
    assert (alone / "probe" / "probe.exr").is_file()


def test_files_that_differ_are_never_replaced(alone):
    (alone / "probe").mkdir()
    (alone / "probe" / "world.exr").write_bytes(b"another")
    with pytest.raises(RuntimeError, match=r"holds another probe than the \.blend \(world\.exr\)"):
        ops.unpack_probe()
    assert contents(alone / "probe") == {"world.exr": b"another"}
    assert bpy.context.scene.spectral_probe.packed.files
    assert ops.unpack_probe(directory="//other/") == {"FINISHED"}
    settings = bpy.context.scene.spectral_probe
    assert settings.probe_directory == settings.edits.probe_directory == "//other/"
    assert (alone / "other" / "edits" / settings.edits.state / "probe.exr").is_file()


@pytest.mark.parametrize(
    "name",
    [
        "../escaped.json",
        "/nowhere/escaped.json",
        "edits/../../report.json",
        "..\\report.json",
        "C:report.json",
        "run.py",
        "",
    ],
)
def test_a_name_in_the_blend_that_leads_elsewhere_is_not_written(alone, name):
    """A .blend is anybody's file: its packed files come out under the names that packing gives, or not at all."""
    settings = bpy.context.scene.spectral_probe
    item = next(one for one in settings.packed.files if one.name == "report.json")
    item.name = name
    before = set(alone.parent.rglob("*"))
    assert ops.unpack_probe() == {"FINISHED"}
    new = {path.relative_to(alone).as_posix() for path in set(alone.parent.rglob("*")) - before}
    assert "probe/probe.exr" in new
    assert all(path.split("/")[0] == "probe" for path in new)
    assert not any(path.endswith((".json", ".py")) for path in new)
    assert not Path("/nowhere").exists()


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_may_not_be_written_to_is_said(alone):
    alone.chmod(0o500)
    try:
        with pytest.raises(RuntimeError, match="may not be written to"):
            ops.unpack_probe()
    finally:
        alone.chmod(0o700)


@pytest.mark.usefixtures("alone")
def test_in_a_file_without_a_place_it_works_from_the_copy(alone):
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    own = bpy.context.scene
    with bpy.data.libraries.load(str(alone / "scene.blend")) as (found, into):
        into.scenes = found.scenes
    appended = next(scene for scene in bpy.data.scenes if scene != own)
    with bpy.context.temp_override(scene=appended):
        assert ops.light_world(normalise=False) == {"FINISHED"}
        with pytest.raises(RuntimeError, match=r"Save the \.blend first"):
            ops.unpack_probe()


def test_a_copy_of_the_scene_keeps_the_packed_files(alone):
    bpy.ops.scene.new(type="FULL_COPY")
    assert ops.unpack_probe() == {"FINISHED"}
    other = next(scene for scene in bpy.data.scenes if scene != bpy.context.scene)
    assert all(item.image or item.text for item in other.spectral_probe.packed.files)
    shutil.rmtree(alone / "probe")
    with bpy.context.temp_override(scene=other):
        assert ops.unpack_probe() == {"FINISHED"}
    assert (alone / "probe" / "probe.exr").is_file()


@pytest.mark.usefixtures("scene")
def test_without_a_probe_there_is_nothing_to_pack():
    assert not ops.pack_probe.poll()
    assert not ops.unpack_probe.poll()
    bpy.context.scene.spectral_probe.probe_directory = str(Path("/nowhere"))
    bpy.context.scene.spectral_probe.probe.width_px = 64
    with pytest.raises(RuntimeError, match="files of the probe are gone"):
        ops.pack_probe()

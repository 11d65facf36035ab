"""Interrupted renders go on where they were; changed scenes, damaged files and full disks are noticed."""

import os
import resource
import signal
import subprocess
import sys
import textwrap

import bpy
import numpy as np
import pytest

WORDS = {"samples": 8, "passes": 3, "rgb_twin": False}


@pytest.fixture(autouse=True)
def plain(scene, ball):
    """A small scene without denoising, which takes longer than the passes."""
    scene.render.resolution_x = scene.render.resolution_y = 24
    scene.cycles.use_denoising = False
    ball()


@pytest.fixture
def render(scene, bridge, extension, uniform_light, go_on, tmp_path):
    """Render to the end, or some steps of the job; the result, or None."""

    def run(steps=None, **words):
        job = bridge.spectral_render(
            scene, uniform_light(np.linspace(0.5, 2.0, 61)), None, tmp_path / "out", **{**WORDS, **words}
        )
        if steps is None:
            return extension("spectral_probe.model").finish(job)
        go_on(job, steps)
        job.close()
        return None

    return run


@pytest.fixture
def xyz(extension):
    return lambda result: extension("spectral_probe.files.image_exr").read_rgb(result.xyz, ("X", "Y", "Z"))


def test_a_stopped_render_goes_on(render, xyz, tmp_path):
    whole = xyz(render())
    files = {path.name: path.read_bytes() for path in (tmp_path / "out" / "passes").glob("*.exr")}
    assert len(files) == 4  # head, tail, and two passes of few samples
    (tmp_path / "out").rename(tmp_path / "first")
    render(steps=4)  # planning, and before each of three renders: two are finished
    left = sorted(path.name for path in (tmp_path / "out" / "passes").glob("*.exr"))
    assert len(left) == 2
    times = {name: (tmp_path / "out" / "passes" / name).stat().st_mtime_ns for name in left}
    result = render()
    assert result.steps_kept == 2
    for name, time_ns in times.items():
        assert (tmp_path / "out" / "passes" / name).stat().st_mtime_ns == time_ns
    np.testing.assert_array_equal(xyz(result), whole)


@pytest.mark.parametrize("damage", ["flip", "cut"])
def test_a_damaged_pass_is_rendered_again(render, xyz, damage):
    first = render()
    whole, path = xyz(first), first.passes[1]
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0xFF
    path.write_bytes(content if damage == "flip" else content[:-100])
    again = render()
    assert again.steps_kept == len(again.passes) - 1
    np.testing.assert_array_equal(xyz(again), whole)


@pytest.mark.parametrize("name", ["plan.json", "passes/index.json"])
def test_a_damaged_plan_or_index_is_made_again(render, xyz, tmp_path, name):
    """By the same scene and light it is the same, and the passes belong to it still."""
    whole = xyz(render())
    before = (tmp_path / "out" / name).read_bytes()
    (tmp_path / "out" / name).write_text("{}")
    again = render()
    assert again.steps_kept == len(again.passes)
    assert (tmp_path / "out" / name).read_bytes() == before
    np.testing.assert_array_equal(xyz(again), whole)


def test_passes_of_another_plan_are_not_taken(render, tmp_path):
    render()
    (tmp_path / "out" / "plan.json").unlink()
    again = render(passes=4)
    assert again.steps_kept == 0
    stray = {path.stem for path in (tmp_path / "out" / "passes").iterdir()} - {p.stem for p in again.passes}
    assert stray == {"index"}


def test_files_of_others_stay_in_the_folder(render, tmp_path):
    (tmp_path / "out").mkdir()
    others = [tmp_path / "out" / name for name in ("image_sky.exr", "rgb_wood.exr", "passes.txt")]
    for path in others:
        path.write_bytes(b"not ours")
    render()
    assert all(path.read_bytes() == b"not ours" for path in others)


def test_the_rgb_twin_alone_is_added(render):
    render()
    result = render(rgb_twin=True)
    assert result.steps_kept == len(result.passes)
    assert result.rgb.is_file()


class TestChanges:
    @pytest.fixture
    def changed(self, render):
        render(steps=3)
        bpy.context.object.location.x += 0.5
        bpy.context.view_layer.update()

    @pytest.mark.usefixtures("changed")
    def test_are_refused(self, render, extension, tmp_path):
        error = extension("operators.bridge.resuming").SceneChangedError
        with pytest.raises(error, match=r"scene changed since then.*--restart.*--resume") as caught:
            render()
        assert "\n" not in str(caught.value)
        assert len(list((tmp_path / "out" / "passes").glob("*.exr"))) == 1

    @pytest.mark.usefixtures("changed")
    def test_restart(self, render):
        assert render(on_change="restart").steps_kept == 0

    @pytest.mark.usefixtures("changed")
    def test_resume(self, render):
        assert render(on_change="resume", samples=99).samples == 8

    def test_samples_and_passes_are_changes_too(self, render, extension):
        render(steps=3)
        error = extension("operators.bridge.resuming").SceneChangedError
        with pytest.raises(error, match="samples and plan"):
            render(samples=9, passes=4)

    def test_a_finished_render_is_simply_replaced(self, render):
        render()
        bpy.context.object.location.x += 0.5
        assert render().steps_kept == 0


def test_the_folder_of_a_probe_is_refused(render, extension, tmp_path):
    (tmp_path / "out").mkdir()
    names = ("probe.exr", "spectral.exr", "report.json")
    for name in names:
        (tmp_path / "out" / name).write_bytes(b"mine")
    with pytest.raises(extension("spectral_probe.errors").RenderError, match="folder of a probe"):
        render()
    assert all((tmp_path / "out" / name).read_bytes() == b"mine" for name in names)


def test_only_pictures_of_a_render_are_replaced(extension, tmp_path):
    assembling = extension("operators.bridge.assembling")
    (tmp_path / "report.json").write_text('{"view_layers": ["First", "Fog"]}')
    ours = ("xyz.exr", "image.exr", "rgb_Fog.exr", "swaps.json")
    theirs = ("image_0001.exr", "render_final.exr", "spectral_sun.exr")
    for name in (*ours, *theirs):
        (tmp_path / name).touch()
    assembling.remove_pictures(tmp_path, ["First", "Fog"])
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(theirs)


def test_a_full_disk_is_one_sentence_and_leaves_nothing_half_written(scene, render, extension, tmp_path):
    """A limit on the size of files fails Blender's writing as a full disk does."""
    scene.render.resolution_x = scene.render.resolution_y = 64
    _, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, hard))
    try:
        with pytest.raises(
            extension("spectral_probe.errors").RenderError, match="could not be written"
        ) as caught:
            render()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))
    assert "\n" not in str(caught.value)
    assert not list((tmp_path / "out").rglob("*.exr"))
    assert render().xyz.is_file()


def test_missing_textures_are_named(scene, render, extension, tmp_path):
    material = bpy.data.materials["Material"]
    texture = material.node_tree.nodes.new("ShaderNodeTexImage")
    material.node_tree.links.new(texture.outputs[0], material.node_tree.nodes["Shader"].inputs[0])
    picture = bpy.data.images.new("Wood", 4, 4)
    picture.filepath_raw, picture.file_format = str(tmp_path / "wood.png"), "PNG"
    picture.save()
    picture.source = "FILE"
    texture.image = picture
    assert extension("operators.bridge.missing_files").check_textures(scene) is None
    (tmp_path / "wood.png").unlink()
    with pytest.raises(
        extension("spectral_probe.errors").RenderError, match=r'"Wood" \(.*wood.png\) is missing'
    ):
        render()
    picture.source = "GENERATED"
    assert extension("operators.bridge.missing_files").check_textures(scene) is None


KILLED = """
    import importlib, importlib.util, os, signal, sys
    import numpy as np
    root, blend, out, after = sys.argv[1:5]
    spec = importlib.util.spec_from_file_location(
        "extension", root + "/__init__.py", submodule_search_locations=[root])
    sys.modules["extension"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sys.modules["extension"])
    import bpy
    importlib.import_module("extension.properties").register()
    bpy.ops.wm.open_mainfile(filepath=blend)
    cycles = importlib.import_module("extension.operators.bridge.cycles")
    fingerprint = importlib.import_module("extension.operators.bridge.fingerprint").scene_fingerprint
    panorama = importlib.import_module("extension.spectral_probe.model").SpectralPanorama(
        np.ones((8, 16, 1), np.float32), np.linspace(0.5, 2.0, 61)[None, None], np.zeros((8, 16), np.uint8),
        np.arange(400.0, 701.0, 5.0), np.ones((8, 16), bool), np.ones((8, 16), np.float32))
    print("fingerprint", fingerprint(bpy.context.scene))
    job = cycles.spectral_render(bpy.context.scene, panorama, None, __import__("pathlib").Path(out),
                                 samples=8, passes=3, rgb_twin=False)
    told = set()
    for progress in job:
        told.add(progress.message)
        if len(told) == int(after):
            sys.stdout.flush()
            os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.long
def test_killed_and_opened_again(render, extension, project_root, tmp_path):
    """Killed between its passes, another process goes on where it was, and the scene is what it was."""
    blend = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend), copy=True)
    before = blend.read_bytes()

    words = [str(project_root), str(blend), str(tmp_path / "out"), "4"]
    killed = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(KILLED), *words],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
    )
    assert killed.returncode == -signal.SIGKILL, killed.stderr
    finished = {path.name: path.stat().st_mtime_ns for path in (tmp_path / "out" / "passes").glob("*.exr")}
    assert len(finished) == 2
    result = render()  # this process has the scene of which the file is a copy
    assert result.steps_kept == 2
    for name, time_ns in finished.items():
        assert (tmp_path / "out" / "passes" / name).stat().st_mtime_ns == time_ns
    assert blend.read_bytes() == before
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    fingerprint = extension("operators.bridge.fingerprint").scene_fingerprint(bpy.context.scene)
    assert f"fingerprint {fingerprint}" in killed.stdout.splitlines()

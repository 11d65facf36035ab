"""Tasks of one frame as processes of their own, at once and killed: as if one process had rendered it."""

import json
import os
import signal
import subprocess
import sys
import time

import bpy
import numpy as np
import pytest

pytestmark = pytest.mark.long

VERB = "import sys; from spectral_probe.cli import main; sys.exit(main())"


@pytest.fixture
def scene_file(scene, tmp_path):
    """The cube of a new file, moving, under a sky of its own."""
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 32, 24, 100
    scene.cycles.samples, scene.cycles.use_denoising = 8, False
    cube = bpy.data.objects["Cube"]
    for frame, x in ((1, -1.0), (2, 1.0)):
        cube.location.x = x
        cube.keyframe_insert("location", frame=frame)
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


@pytest.fixture
def start(scene_file, project_root):
    """Start a verb on the scene, in a process of its own."""
    running = []

    def begin(verb, *words):
        scene_words = [str(scene_file), "--world", "--passes", "2"] if verb.startswith("render") else []
        process = subprocess.Popen(
            [sys.executable, "-c", VERB, verb, *scene_words, *map(str, words), "--json"],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=project_root,
            env={**os.environ, "OMP_NUM_THREADS": "1"},
        )  # fmt: skip
        running.append(process)
        return process

    yield begin
    for process in running:
        process.kill()
        process.communicate()


def numbers_of(process):
    out, err = process.communicate(timeout=300)
    assert process.returncode == 0, err
    return json.loads(out)


def check_same(one, other, read_channels):
    for name in ("xyz.exr", "image.exr", "render.exr", "rgb.exr"):
        first, second = read_channels(one / name)[0], read_channels(other / name)[0]
        assert first.keys() == second.keys()
        for channel, plane in first.items():
            np.testing.assert_array_equal(plane, second[channel])


def test_two_frames_by_tasks_at_once_are_the_animation(start, in_extension, tmp_path):
    """Each frame's first two tasks come at once, the same one twice; one is killed and done again."""
    whole, apart = tmp_path / "whole", tmp_path / "apart"
    assert numbers_of(start("render", "--frames", "1-2", "-o", whole))["frames"] == 2
    words = {frame: ("-o", apart, "--frame", frame, "--pass") for frame in (1, 2)}
    first = [start("render-pass", *words[1], which) for which in ("1/2", "1/2", "2/2")]
    done = [numbers_of(process) for process in first]
    rendered = [name for task in done for name in task["rendered"]]
    assert sorted(rendered) == sorted(set(rendered))
    assert sorted(rendered) == sorted({*done[0]["rendered"], *done[0]["finished_before"],
                                       *done[2]["rendered"], *done[2]["finished_before"]})  # fmt: skip

    killed = start("render-pass", *words[2], "1/1")
    passes = apart / "frame_0002" / "passes"
    while killed.poll() is None and not list(passes.glob("*.exr")):
        time.sleep(0.001)
    killed.send_signal(signal.SIGKILL)
    killed.wait()
    again = numbers_of(start("render-pass", *words[2], "1/1"))
    assert {*again["rendered"], *again["finished_before"]} == set(rendered)
    assert numbers_of(start("combine", apart, "--frames", "1-2"))["frames"] == 2
    read = in_extension("spectral_probe.files.image_exr").read_channels
    for frame in ("frame_0001", "frame_0002"):
        check_same(apart / frame, whole / frame, read)
        left = {path.name for path in (apart / frame).rglob("*")} - {
            path.name for path in (whole / frame).rglob("*")
        }
        assert left == set()

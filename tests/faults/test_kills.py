"""kill -9 at random moments of `probe`, of a batch and of `render`; the same command goes on, and nothing is lost or different.

Each trial starts in an empty folder, is killed at a moment of its own part of the whole duration (fixed seeds), every second
one again while it goes on, and every fifth a third time. Between a kill and what follows every file that has its name is whole;
in the end all is as an undisturbed run leaves it, pixel for pixel, nothing of the killed ones is left over, and the scene is
untouched.
"""

from __future__ import annotations

import hashlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from spectral_probe.files.image_exr import read_channels

ROOT = Path(__file__).resolve().parents[2]
GYM = ROOT / "sample_scenes" / "gym"
LIMIT_S = 400.0
MAIN = "import sys; from spectral_probe.cli import main; sys.exit(main())"
SCENE = """
import sys, bpy
bpy.ops.wm.read_homefile(use_factory_startup=True)
scene = bpy.context.scene
scene.render.engine = "CYCLES"
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 64, 48, 100
scene.cycles.samples = 4
bpy.data.materials["Material"].node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.8, 0.3, 0.1, 1)
bpy.data.objects.remove(bpy.data.objects["Light"])
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[1])
"""
PROGRAMS = ("probe", "batch", "render")


@dataclass(frozen=True)
class Program:
    """What is killed: the words for an output folder, the inputs it must not touch, and what an undisturbed run leaves."""

    words: Callable[[Path], list[str]]
    inputs: tuple[Path, ...]
    expected: dict[str, object]
    seconds: float


def pytest_generate_tests(metafunc):
    if "trial" in metafunc.fixturenames:
        kills = metafunc.config.getoption("kills")
        metafunc.parametrize(
            ("program", "trial"),
            [(name, number) for name in PROGRAMS for number in range(trials_of(name, kills))],
            indirect=["program"],
        )


def trials_of(name, kills):
    """How often a program is killed; a batch, whose captures are probes, less often."""
    return max(1, kills // 5) if name == "batch" else kills


def start(words):
    return subprocess.Popen(
        [sys.executable, "-c", MAIN, *map(str, words)],
        cwd=ROOT,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def finished(words):
    """Run to the end, which must be a good one; the seconds it took."""
    began = time.monotonic()
    with start(words) as process:
        out, err = process.communicate(timeout=LIMIT_S)
    assert process.returncode == 0, (out, err)
    assert "Traceback" not in err
    return time.monotonic() - began


@pytest.fixture(scope="session")
def light(tmp_path_factory):
    """A small probe to render with."""
    folder = tmp_path_factory.mktemp("light")
    finished(["probe", plain_capture(folder / "a" / "capture.toml"), "-o", folder / "probe", "--width", 64])
    return folder / "probe" / "probe.exr"


def one_view_of_the_gym(folder):
    """The sample's capture file with its first view alone."""
    text, _, views = (GYM / "capture.toml").read_text().partition("[[view]]")
    view = views.partition("[[view]]")[0].replace('"view0', f'"{GYM.as_posix()}/view0')
    (folder / "capture.toml").write_text(f"{text}[[view]]{view}")
    return folder / "capture.toml"


def plain_capture(path):
    path.parent.mkdir(parents=True)
    image = np.full((300, 300, 3), 40, np.uint8)
    cv2.circle(image, (150, 150), 90, (200, 190, 180), -1, cv2.LINE_AA)
    cv2.imwrite(str(path.parent / "ball.png"), image)
    path.write_text(
        '[camera]\nmodel = "Rec.709"\nfocal_px = 1500.0\n[[view]]\nphotos = ["ball.png"]\nexposures_s = [0.01]\n'
    )
    return path


@pytest.fixture(scope="session")
def programs():
    """Programs that were run undisturbed, by name: trials come in any order, and each is run so once."""
    return {}


@pytest.fixture
def program(request, programs, tmp_path_factory):
    if request.param not in programs:
        programs[request.param] = undisturbed(request, tmp_path_factory.mktemp(request.param))
    return programs[request.param]


def undisturbed(request, folder):
    if request.param == "probe":
        capture = one_view_of_the_gym(folder)
        inputs = (capture, *GYM.glob("view0_*.dng"))

        def words(out):
            return ["probe", capture, "-o", out, "--width", 64]

    elif request.param == "batch":
        captures = [plain_capture(folder / "captures" / name / "capture.toml") for name in "ab"]
        inputs = tuple(file for capture in captures for file in capture.parent.iterdir())

        def words(out):
            return ["probe", folder / "captures", "-o", out, "--width", 64]

    else:
        scene, light = folder / "scene.blend", request.getfixturevalue("light")
        subprocess.run([sys.executable, "-c", SCENE, scene], check=True, capture_output=True)
        inputs = (scene, light)

        def words(out):
            return ["render", scene, "--probe", light, "-o", out]

    seconds = finished(words(folder / "undisturbed"))
    return Program(words, inputs, contents(folder / "undisturbed"), seconds)


@pytest.mark.long
def test_a_killed_program_goes_on_as_if_nothing_had_been(request, program, trial, kills, tmp_path):
    name = request.node.callspec.params["program"]
    chance = random.Random(f"{name} {trial}")
    out = tmp_path / "out"
    before = [digest(path) for path in program.inputs]
    share = (trial + chance.random()) / trials_of(name, kills)
    shares = [share, *(chance.random() for again in (2, 5) if trial % again == 0)]
    for share in shares:
        killed = kill_at(program.words(out), share * program.seconds)
        check_whole(out)
        told = f"killed at {share:.0%} of {program.seconds:.1f} s" if killed else "had finished"
        sys.stdout.write(f"{told}\n")
    finished(program.words(out))
    assert contents(out) == program.expected
    left = [str(path) for path in out.rglob("*") if path.name.startswith(".")]
    assert left == [], "leftovers of killed processes, or locks"
    assert [digest(path) for path in program.inputs] == before
    shutil.rmtree(out)


def kill_at(words, seconds):
    """Start and kill -9 after so many seconds; whether it was still running."""
    with start(words) as process:
        try:
            process.communicate(timeout=seconds)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.communicate()
    if process.returncode != -signal.SIGKILL:
        assert process.returncode == 0
        return False
    return True


def check_whole(folder):
    """Every file that has its name is whole."""
    contents(folder)


def contents(folder):
    """What the outputs of a folder hold, by their names; those still being written, which have other names, left out."""
    found = {}
    for path in sorted(folder.rglob("*")) if folder.is_dir() else ():
        name = path.relative_to(folder).as_posix()
        if path.is_dir() or any(part.startswith(".") for part in Path(name).parts):
            continue
        found[name] = content(path)
    return found


def content(path):
    """What a file holds: pixels and channels of an image; of a record only that it is whole, since it has seconds in it."""
    if path.suffix == ".exr":
        channels, _ = read_channels(path)
        return {
            name: hashlib.blake2b(np.ascontiguousarray(plane)).hexdigest() for name, plane in channels.items()
        }
    if path.suffix in (".png", ".jpg"):
        with Image.open(path) as image:
            return hashlib.blake2b(np.asarray(image).tobytes()).hexdigest()
    if path.suffix == ".json":
        record = json.loads(path.read_text())
        return path.name == "report.json" or sorted(record)
    assert path.suffix == ".csv", f"{path} is a kind of file that this test does not know"
    return len(path.read_text().splitlines())


def digest(path):
    return hashlib.blake2b(path.read_bytes()).hexdigest()

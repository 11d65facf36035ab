"""A shot as a farm renders it, for real: by `openjd run`, and by a shell that runs the list of commands."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from spectral_probe.files.image_exr import read_channels

pytestmark = [pytest.mark.long, pytest.mark.skipif(os.name != "posix", reason="the program is a script")]

OPENJD = Path(sys.executable).with_name("openjd")


@pytest.fixture
def job(shot, verb, blender, tmp_path):
    """Write a job that renders into `tmp_path / "frames"`; returns its folder."""

    def written(kind="openjd", name="job"):
        folder = tmp_path / name
        done = verb(
            "farm", shot / "scene.blend", "--probe", shot / "probe" / "probe.exr", "--frames", "1-2", "-o", folder,
            "--render", tmp_path / "frames", "--format", kind, "--blender", blender,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        return folder

    return written


def openjd_run(run, job, *words):
    return run([OPENJD, "run", job / "template.yaml", "-p", f"file://{job / 'openjd_values.yaml'}", *words])


def assert_same_pixels(first, second):
    """Every channel of two images, bit for bit; Blender writes the time of day into headers."""
    one, other = read_channels(first)[0], read_channels(second)[0]
    assert list(one) == list(other), first
    for name, pixels in one.items():
        assert pixels.dtype == other[name].dtype, (first, name)
        assert pixels.tobytes() == other[name].tobytes(), (first, name)


def assert_same_frames(folder, expected):
    for frame in ("frame_0001", "frame_0002"):
        files = sorted(path.relative_to(expected / frame) for path in (expected / frame).rglob("*.exr"))
        assert files
        assert files == sorted(path.relative_to(folder / frame) for path in (folder / frame).rglob("*.exr"))
        for name in files:
            assert_same_pixels(folder / frame / name, expected / frame / name)
        assert (folder / frame / "report.json").is_file()


def test_a_farm_renders_what_one_machine_renders(job, run, tmp_path, on_one_machine):
    folder = job()
    checked = run([OPENJD, "check", folder / "template.yaml"])
    assert checked.returncode == 0, checked.stdout + checked.stderr
    done = openjd_run(run, folder)
    assert done.returncode == 0, done.stdout + done.stderr
    assert_same_frames(tmp_path / "frames", on_one_machine)
    assert (tmp_path / "frames" / "comparison" / "contact_sheet.png").is_file()
    told = done.stdout
    assert "openjd_progress: " in told
    assert "openjd_status: Rendering in RGB" in told
    assert "openjd_fail" not in told


def test_a_list_of_commands_and_a_task_killed_and_retried(job, run, tmp_path, on_one_machine):
    commands = job("commands") / "commands.txt"
    first = next(line for line in commands.read_text().splitlines() if not line.startswith("#"))
    passes = tmp_path / "frames" / "frame_0001" / "passes"
    with subprocess.Popen(
        ["bash", "-c", f"exec {first}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as task:
        while not any(passes.glob(".writing-*")) and task.poll() is None:
            time.sleep(0.005)
        task.send_signal(signal.SIGKILL)
    assert not (passes / "pass_00.json").is_file(), "it was killed too late to test anything"
    done = run(["bash", commands])
    assert done.returncode == 0, done.stderr
    assert_same_frames(tmp_path / "frames", on_one_machine)
    assert not list((tmp_path / "frames").rglob(".*"))


def test_a_task_that_fails_says_why_and_ends_the_job(job, run, shot, tmp_path):
    folder = job()
    values = folder / "openjd_values.yaml"
    values.write_text(
        values.read_text().replace(str(shot / "probe" / "probe.exr"), str(tmp_path / "gone.exr"))
    )
    done = openjd_run(run, folder, "--step", "Render", "--maximum-tasks", "1")
    assert done.returncode != 0
    assert f"openjd_fail: There is no file {tmp_path / 'gone.exr'}" in done.stdout

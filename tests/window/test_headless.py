"""A real Blender without its window, the extension from the zip: every verb of the command line, and the batch scripts.

They run where SPECTRAL_PROBE_BLENDER names a command that starts Blender.
"""

from __future__ import annotations

import json
import os
import shlex
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

LIMIT_S = 280
REGION = '{"polygon_deg": [[-20, -10], [20, -10], [20, 20], [-20, 20]]}'

type Blender = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture(scope="session")
def blender(request: pytest.FixtureRequest, project_root: Path) -> Blender:
    """Start Blender in background on the profile, with these words."""
    command = shlex.split(os.environ.get("SPECTRAL_PROBE_BLENDER", ""))
    if not command:
        pytest.skip("no Blender here: SPECTRAL_PROBE_BLENDER names none")
    profile = request.getfixturevalue("profile")

    def start(*words: object) -> subprocess.CompletedProcess[str]:
        done = subprocess.run(
            [*command, "--background", *map(str, words)],
            cwd=project_root,
            env={**os.environ, "BLENDER_USER_RESOURCES": str(profile)},
            capture_output=True,
            text=True,
            timeout=LIMIT_S,
            check=False,
        )
        assert "Traceback" not in done.stdout + done.stderr
        return done

    return start


@pytest.fixture(scope="module")
def gym(project_root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("gym")
    source = project_root / "sample_scenes" / "gym"
    for file in [*source.glob("*.dng"), source / "capture.toml"]:
        shutil.copy(file, folder)
    (folder / "region.json").write_text(REGION)
    return folder


def test_every_verb_from_photographs_to_the_composite(blender: Blender, gym: Path):
    def verb(*words: object) -> dict:
        done = blender("--command", "spectral_probe", *words, "--json")
        assert done.returncode == 0, done.stderr
        return json.loads(next(line for line in done.stdout.splitlines() if line.startswith(("{", "["))))

    probe, scene, render = gym / "probe", gym / "plate.blend", gym / "render"
    assert verb("probe", gym / "capture.toml", "-o", probe, "--width", 128)["width"] == 128
    assert verb("spectrum", probe / "probe.exr", "--at", "10,0", "-o", gym / "spectrum")
    stained = gym / "stained.exr"
    verb("filter", probe / "probe.exr", "--glass", "red", "--region", gym / "region.json", "-o", stained)
    assert stained.is_file()
    verb(
        "backplate",
        probe,
        "--plate",
        gym / "view0_1.dng",
        "-o",
        scene,
        "--object",
        "copper-ball",
        "--width",
        64,
    )
    verb("render", scene, "--probe", probe / "probe.exr", "-o", render, "--samples", 2, "--passes", 1)
    verb("compare", render / "xyz.exr", render / "rgb.exr", "-o", gym / "comparison")
    assert (gym / "comparison" / "sheet.png").is_file()
    verb("composite", render, "-o", gym / "composite")
    assert (gym / "composite" / "composite.png").is_file()
    assert verb("library", "search", "gold")
    assert verb("swap", render, "--list") is not None


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("probe", "lost.toml", "-o", "out"), "There is no capture file at"),
        (("calibrate", "lost.png", "-o", "camera.json"), "1 photograph is too few"),
        (("rendr",), "Argument"),
    ],
)
def test_what_is_wrong_is_one_line_and_status_2(blender: Blender, words, message):
    done = blender("--command", "spectral_probe", *words)
    assert done.returncode == 2
    assert message in done.stderr.strip().splitlines()[-1]


def test_the_batch_scripts_run_one_after_the_other(blender: Blender, project_root: Path, gym: Path):
    scripts, small = project_root / "sample_scenes", ("--samples", 1, "--size", 32, 24)
    out, lights = gym / "batch", gym / "lights"
    start = ("--python-exit-code", 1, "--python")
    script = scripts / "batch_render.py"
    done = blender(*start, script, "--", gym / "capture.toml", out, "--width", 64, *small)
    assert done.returncode == 0, done.stderr
    assert (out / "render" / "comparison" / "sheet.png").is_file()
    done = blender(
        *start, scripts / "batch_lights.py", "--", out / "scene.blend", lights, out / "probe", *small
    )
    assert done.returncode == 0, done.stderr
    assert len((lights / "lights.csv").read_text().splitlines()) == 2

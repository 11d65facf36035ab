"""`blender --command spectral_probe VERB ...` and the batch script: same verbs, clear errors, a clean terminal."""

import json
import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest


@pytest.fixture
def run(in_extension):
    return in_extension("operators.command_line").run


@pytest.fixture
def probe_file(tmp_path, in_extension) -> Path:
    """A probe of even light from everywhere."""
    wavelengths_nm = in_extension("spectral_probe.spectra.grid").WAVELENGTHS_NM
    weights = np.zeros((16, 32, 3), np.float32)
    weights[..., 0] = 1
    panorama = in_extension("spectral_probe.model").SpectralPanorama(
        weights=weights,
        bases=np.ones((1, 3, len(wavelengths_nm))),
        basis_index=np.zeros((16, 32), np.uint8),
        wavelengths_nm=wavelengths_nm,
        valid=np.ones((16, 32), bool),
        confidence=np.ones((16, 32), np.float32),
    )
    path = tmp_path / "probe.exr"
    in_extension("spectral_probe.files.probe_exr").write_probe(path, panorama)
    return path


@pytest.fixture
def scene_file(scene, tmp_path) -> Path:
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 16, 12, 100
    scene.cycles.samples = 1
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def test_render_writes_its_files_and_prints_only_json(run, scene_file, probe_file, tmp_path, capfd):
    out = tmp_path / "out"
    words = ["render", str(scene_file), "--probe", str(probe_file), "-o", str(out), "--passes", "2", "--json"]
    capfd.readouterr()
    assert run(words) == 0
    printed = capfd.readouterr()
    numbers = json.loads(printed.out)
    assert (numbers["passes"], numbers["samples"]) == (2, 1)
    assert numbers == {**json.loads((out / "report.json").read_text()), "written": str(out)}
    assert {"xyz.exr", "image.exr", "rgb.exr", "plan.json", "report.json"} <= {
        path.name for path in out.iterdir()
    }
    assert "Pass 2 of 2" not in printed.err  # progress lines only from ten seconds on, away from a terminal
    assert "Saved" not in printed.err


def test_render_takes_frame_samples_and_no_rgb(run, scene_file, probe_file, tmp_path, capfd):
    out = tmp_path / "out"
    words = ["render", str(scene_file), "--probe", str(probe_file), "-o", str(out), "--passes", "1", "--json"]
    assert run([*words, "--frame", "7", "--samples", "2", "--no-rgb"]) == 0
    numbers = json.loads(capfd.readouterr().out.splitlines()[-1])
    assert (numbers["frame"], numbers["samples"]) == (7, 2)
    assert not (out / "rgb.exr").exists()


def test_a_plan_is_used_again_in_the_own_world(run, scene_file, tmp_path, capfd):
    out, plan = tmp_path / "out", tmp_path / "out" / "plan.json"
    words = ["render", str(scene_file), "--world", "--samples", "1", "--no-rgb", "--json"]
    assert run([*words, "-o", str(out), "--passes", "2"]) == 0
    assert run([*words, "-o", str(tmp_path / "again"), "--plan", str(plan)]) == 0
    first, again = map(json.loads, capfd.readouterr().out.splitlines()[-2:])
    assert first["passes"] == 2
    assert again["wavelengths_nm"] == first["wavelengths_nm"]
    assert run([*words, "-o", str(out), "--plan", str(tmp_path / "lost.json")]) == 2
    assert "lost.json" in capfd.readouterr().err.splitlines()[-1]


def test_frames_in_parts(run, scene_file, probe_file, tmp_path, capfd):
    """Two tasks a frame and one that puts the frames together, as a farm calls them."""
    out = tmp_path / "out"
    light = ["--probe", str(probe_file), "--passes", "1", "--no-rgb"]
    words = ["render-pass", str(scene_file), *light, "-o", str(out), "--json"]

    def task(frame, which, *more, status=0):
        capfd.readouterr()
        assert run([*words, "--frame", frame, "--pass", which, *more]) == status
        printed = capfd.readouterr()
        return json.loads(printed.out) if status == 0 else printed.err.splitlines()[-1]

    first = task("7", "1/2")
    assert (first["rendered"], first["written"]) == (["pass_00"], str(out / "frame_0007"))
    assert task("7", "2/2")["note"] == "Nothing to do: all 1 passes of the frame are in other shares."
    assert task("7", "pass_00")["finished_before"] == ["pass_00"]
    assert "its samples changed" in task("7", "1/2", "--samples", "2", status=2)
    assert 'no pass "pass_09"' in task("7", "pass_09", status=2)
    assert run(["combine", str(out), "--frames", "7-8"]) == 2
    told = capfd.readouterr().err.splitlines()[-1]
    assert told.startswith(f"1 of 2 frames were not put together. There is no frame in {out / 'frame_0008'}")
    report = out / "frame_0007" / "report.json"
    assert report.is_file()  # all are tried
    shutil.rmtree(out / "frame_0007" / "passes")
    assert task("7", "1/1")["rendered"] == ["pass_00"]
    task("8", "1/1")
    assert run(["combine", str(out / "frame_0007"), "--spectral", "--json"]) == 0
    numbers = json.loads(capfd.readouterr().out)
    assert numbers == {**json.loads(report.read_text()), "written": str(out / "frame_0007")}
    assert (numbers["frame"], numbers["blend"]) == (7, "../../scene.blend")
    assert (out / "frame_0007" / "spectral.exr").is_file()
    (out / "frame_0008" / "passes" / "pass_00.exr").unlink()
    assert run(["combine", str(out), "--frame", "8"]) == 2
    told = capfd.readouterr().err.splitlines()[-1]
    assert told.startswith(f"1 of 1 passes is missing or damaged in {out / 'frame_0008'}: pass_00.")
    command = shlex.split(told.split("Render it: spectral-probe ")[1])
    assert command == [
        "render-pass", str(scene_file), *light, "-o", str(out), "--frame", "8", "--pass", "pass_00",
    ]  # fmt: skip
    assert run(["combine", str(out)]) == 2
    assert "--frames" in capfd.readouterr().err.splitlines()[-1]


@pytest.mark.parametrize(
    "which", ["0/3", "4/3", "1/0", "-1/2", "1/", "a/b", "../x", "1/1000000", "pass_00;x"]
)
def test_a_share_that_there_is_not(run, which, capfd):
    assert run(["render-pass", "a.blend", "--world", "-o", "out", "--frame", "1", f"--pass={which}"]) == 2
    assert len(capfd.readouterr().err.splitlines()) == 1


@pytest.mark.parametrize(
    ("scene_name", "probe_name", "message"),
    [
        ("lost.blend", "probe.exr", "There is no scene at"),
        ("broken.blend", "probe.exr", "broken.blend cannot be opened"),
        ("scene.blend", "lost.exr", "lost.exr"),
    ],
)
@pytest.mark.usefixtures("scene_file", "probe_file")
def test_bad_input_is_one_line_and_status_2(run, tmp_path, capfd, scene_name, probe_name, message):
    (tmp_path / "broken.blend").write_text("not a scene")
    capfd.readouterr()
    words = [
        "render",
        str(tmp_path / scene_name),
        "--probe",
        str(tmp_path / probe_name),
        "-o",
        str(tmp_path / "out"),
    ]
    assert run(words) == 2
    printed = capfd.readouterr()
    assert printed.out == ""
    assert message in printed.err.splitlines()[-1]
    assert "Traceback" not in printed.err
    assert not list(tmp_path.glob("out/*.exr"))


def test_eevee_is_refused_with_a_reason(run, scene, probe_file, tmp_path, capfd):
    scene.render.engine = "BLENDER_EEVEE"
    path = tmp_path / "eevee.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    assert run(["render", str(path), "--probe", str(probe_file), "-o", str(tmp_path / "out")]) == 2
    assert "Cycles" in capfd.readouterr().err.splitlines()[-1]


def test_verbs_of_the_core_work_inside_blender_too(run, capture_file, tmp_path, capfd):
    assert run(["probe", str(capture_file), "-o", str(tmp_path / "out"), "--width", "64", "--json"]) == 0
    assert json.loads(capfd.readouterr().out.splitlines()[-1])["width"] == 64
    assert (tmp_path / "out" / "world.exr").is_file()


@pytest.mark.parametrize(
    ("words", "status"), [(["--help"], 0), (["render", "--help"], 0), (["rendr"], 2), ([], 2)]
)
def test_words_the_parser_answers_itself(run, words, status):
    assert run(words) == status


def test_silence_ends_with_its_block(in_extension, capfd):
    with in_extension("operators.terminal").blender_silenced():
        os.write(1, b"from the C side\n")
        sys.stdout.write("from Python\n")
    os.write(1, b"afterwards\n")
    assert capfd.readouterr().out == "afterwards\n"


def batch(script: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Run a script as `blender --background --python SCRIPT -- WORDS` does, with the extension enabled."""
    start = (
        "import bpy, addon_utils, runpy, sys\n"
        "addon_utils.enable('bl_ext.user_default.spectral_probe')\n"
        "runpy.run_path(sys.argv[1], run_name='__main__')\n"
    )
    return subprocess.run(
        [sys.executable, "-c", start, str(script), "--", *words],
        capture_output=True, text=True, check=False, timeout=300,
    )  # fmt: skip


@pytest.mark.long
def test_the_batch_script_goes_from_photographs_to_comparison(project_root, capture_file, tmp_path):
    script = project_root / "sample_scenes" / "batch_render.py"
    out = tmp_path / "out"
    done = batch(script, str(capture_file), str(out), "--samples", "1", "--width", "64", "--size", "16", "12")
    assert done.returncode == 0, done.stderr
    for name in (
        "probe/probe.exr",
        "render/xyz.exr",
        "render/rgb.exr",
        "render/comparison/sheet.png",
        "scene.blend",
    ):
        assert (out / name).is_file(), name
    assert "RGB differs from spectral by dE2000" in done.stdout


def test_the_batch_script_says_what_is_wrong(project_root, tmp_path):
    done = batch(
        project_root / "sample_scenes" / "batch_render.py", str(tmp_path / "lost.toml"), str(tmp_path)
    )
    assert done.returncode == 2
    assert "There is no capture file at" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.long
def test_the_batch_of_lights_renders_one_scene_in_each(
    project_root, scene_file, probe_file, tmp_path, in_extension
):
    panorama = in_extension("spectral_probe.files.probe_exr").read_probe(probe_file)
    to_rgb = in_extension("spectral_probe.files.image_exr").write_rgb
    for name in ("noon", "dusk"):
        folder = tmp_path / name / "probe"
        folder.mkdir(parents=True)
        (folder / "probe.exr").write_bytes(probe_file.read_bytes())
        to_rgb(folder / "world.exr", np.ones((*panorama.weights.shape[:2], 3), np.float32))
    script, out = project_root / "sample_scenes" / "batch_lights.py", tmp_path / "out"
    probes = [str(tmp_path / name / "probe") for name in ("noon", "dusk")]
    done = batch(script, str(scene_file), str(out), *probes, "--samples", "1", "--size", "16", "12")
    assert done.returncode == 0, done.stderr
    rows = (out / "lights.csv").read_text().splitlines()
    assert [row.split(",")[0] for row in rows] == ["light", "noon", "dusk"]
    for name in ("noon", "dusk"):
        assert (out / name / "xyz.exr").is_file()
        assert (out / name / "comparison" / "sheet.png").is_file()
        assert (out / name / "scene.blend").is_file()
    lost = batch(script, str(scene_file), str(out), str(tmp_path / "lost"))
    assert lost.returncode == 2
    assert "Traceback" not in lost.stderr
    assert "robe" in lost.stderr.splitlines()[0]

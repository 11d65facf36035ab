import argparse
import json
import subprocess
import sys

import cv2
import numpy as np
import pytest

from spectral_probe.cli import _parser, main
from spectral_probe.files.image_exr import write_rgb
from spectral_probe.files.probe_exr import write_probe
from spectral_probe.geometry.frames import bearing_to_direction, panorama_directions
from spectral_probe.model import Progress, SpectralPanorama
from spectral_probe.spectra.basis import principal_components
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.library import planck, training_lights


@pytest.fixture
def probe_file(tmp_path):
    """A panorama with one filament lamp at bearing 330, elevation -10, in daylight."""
    basis = principal_components(training_lights(["incandescent", "daylight"]), 3)
    lamp = panorama_directions(64, 128) @ bearing_to_direction(330, -10) > np.cos(np.radians(8))
    spectra = np.where(lamp[..., None], 50 * planck(2850.0), training_lights(["daylight"])[6])
    valid = np.ones((64, 128), bool)
    valid[:4] = False
    panorama = SpectralPanorama(
        (spectra @ basis.T).astype(np.float32),
        basis[None],
        np.zeros((64, 128), np.uint8),
        WAVELENGTHS_NM,
        valid,
        np.full((64, 128), 0.9, np.float32),
    )
    write_probe(tmp_path / "probe.exr", panorama)
    return tmp_path / "probe.exr"


def run(capsys, *words):
    code = main([str(word) for word in words])
    out, err = capsys.readouterr()
    return code, out, err


def test_spectrum_of_a_lamp(probe_file, tmp_path, capsys):
    measured = tmp_path / "lamp.csv"
    rows = [f"{nm:g},{value:g}" for nm, value in zip(WAVELENGTHS_NM, planck(2850.0), strict=True)]
    measured.write_text("wavelength_nm,radiance\n" + "\n".join(rows))
    code, out, _ = run(capsys, "spectrum", probe_file, "--at", "-30,-10", "--measured", measured, "--json")
    numbers = json.loads(out)
    assert code == 0
    assert numbers["gfc"] > 0.999
    assert numbers["relative_rmse"] < 0.03
    assert numbers["cct_kelvin"] == pytest.approx(
        2850, abs=80
    )  # the basis is for mixed light, not for this lamp alone
    table = np.genfromtxt(numbers["csv"], delimiter=",", names=True)
    assert table["radiance"] == pytest.approx(50 * planck(2850.0), rel=0.03, abs=2.5)
    for suffix in (".csv", ".png", ".svg"):
        assert (tmp_path / f"spectrum_330_-10{suffix}").stat().st_size > 500


def test_a_direction_nobody_saw(probe_file, capsys):
    code, out, err = run(capsys, "spectrum", probe_file, "--at", "0,90")
    assert (code, out) == (2, "")
    assert err.splitlines()[-1].startswith("No view saw the direction 0,90 unclipped.")


def test_renders_of_different_sizes(tmp_path, capsys):
    write_rgb(tmp_path / "a.exr", np.ones((4, 4, 3)))
    write_rgb(tmp_path / "b.exr", np.ones((4, 6, 3)))
    code, _, err = run(capsys, "compare", tmp_path / "a.exr", tmp_path / "b.exr", "-o", tmp_path / "out")
    assert code == 2
    assert (
        err.splitlines()[-1] == "a.exr is 4 x 4 pixels, b.exr is 6 x 4 pixels. Compare renders of one size."
    )
    assert not (tmp_path / "out").exists()


def test_a_missing_capture_writes_nothing(tmp_path, capsys):
    code, out, err = run(capsys, "probe", tmp_path / "none.toml", "-o", tmp_path / "out")
    assert (code, out) == (2, "")
    assert err == f"There is no capture file at {tmp_path / 'none.toml'}. Check the path.\n"
    assert not (tmp_path / "out").exists()


def write_capture(folder, **changes):
    """A capture of one photograph of a plain ball, with some lines replaced."""
    image = np.full((300, 300, 3), 40, np.uint8)
    cv2.circle(image, (150, 150), changes.pop("radius_px", 90), (200, 190, 180), -1, cv2.LINE_AA)
    cv2.imwrite(str(folder / "ball.png"), image)
    lines = {
        "model": '"Rec.709"',
        "focal_px": "1500.0",
        "photos": '["ball.png"]',
        "exposures_s": "[0.01]",
        **changes,
    }
    camera = "\n".join(
        f"{key} = {lines[key]}" for key in ("model", "focal_px", "sensitivities") if lines.get(key)
    )
    view = "\n".join(
        f"{key} = {lines[key]}" for key in ("photos", "exposures_s", "outline") if lines.get(key)
    )
    (folder / "capture.toml").write_text(f"[camera]\n{camera}\n[[view]]\n{view}\n")
    return folder / "capture.toml"


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        (
            {"model": '"Nikon 5100"'},
            'There is no camera called "Nikon 5100" in the library. Did you mean "Nikon 5100 (NPL)"?',
        ),
        ({"sensitivities": '"short.csv"'}, "short.csv covers 450-650 nm, but 400-700 nm is needed."),
        ({"photos": '["nothing.png"]'}, "there is no file"),
        ({"exposures_s": None}, "exposure"),
        ({"focal_px": None}, "does not say its focal length"),
        ({"outline": "[150, 20, 90]"}, "leaves the frame of 300 x 300 pixels at the top."),
        ({"focal_px": "1500.0.0"}, "is not valid TOML"),
        ({"photos": '["ball.txt"]'}, "ball.txt"),
    ],
)
def test_bad_captures_get_one_line_exit_2_and_nothing_written(tmp_path, capsys, changes, line):
    (tmp_path / "short.csv").write_text("wavelength_nm,r,g,b\n450,1,2,3\n650,3,2,1\n")
    (tmp_path / "ball.txt").write_text("no photograph")
    before = {file.name for file in tmp_path.iterdir()} | {"ball.png", "capture.toml"}
    code, out, err = run(
        capsys, "probe", write_capture(tmp_path, **changes), "-o", tmp_path / "out", "--width", "64"
    )
    message = err.splitlines()
    assert (code, out) == (2, "")
    assert len(message) == 1
    assert line in message[0]
    assert {file.name for file in tmp_path.iterdir()} == before


def test_an_output_that_is_a_file(tmp_path, capsys):
    code, _, err = run(capsys, "probe", write_capture(tmp_path), "-o", tmp_path / "ball.png")
    assert code == 2
    assert "is a file, not a folder" in err


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["spectrum", "p.exr", "--at", "north"], '"north" is no bearing'),
        (["spectrum", "p.exr", "--at", "10,95"], "not between -90 and 90"),
        (["render", "a.blend", "--probe", "p.exr", "-o", "x", "--passes", "0"], "no whole number above 0"),
        (["prob", "a.toml"], "invalid choice: 'prob'"),
        (["probe", "a.toml"], "the following arguments are required: -o/--output"),
        (["compare", "a.exr", "b.exr", "-o", "x", "--blur", "-1"], "not a number from 0 to 90"),
    ],
)
def test_wrong_words_get_one_line_and_exit_2(words, line, capsys):
    with pytest.raises(SystemExit) as left:
        main(words)
    err = capsys.readouterr().err
    assert left.value.code == 2
    assert line.lower() in err.lower()
    assert err.count("\n") == 1


@pytest.mark.parametrize("verb", ["demo", "probe", "spectrum", "render", "compare"])
def test_help_has_an_example(verb, capsys):
    with pytest.raises(SystemExit) as left:
        main([verb, "--help"])
    assert left.value.code == 0
    assert f"Example: spectral-probe {verb}" in capsys.readouterr().out


def test_blenders_verbs_are_called_with_the_arguments(tmp_path, capsys):
    def render(arguments):
        yield Progress(0.5, "rendering")
        return {"passes": arguments.passes, "scene": arguments.scene.name}

    words = ["render", "a.blend", "--probe", "p.exr", "-o", str(tmp_path), "--passes", "all", "--json"]
    assert main(words, {"render": render}) == 0
    out, err = capsys.readouterr()
    assert json.loads(out) == {"passes": "all", "scene": "a.blend"}
    assert err == ""  # done before there was anything to tell


def test_an_interrupted_verb_says_so(tmp_path, capsys):
    def render(_):
        yield Progress(0.1, "rendering")
        raise KeyboardInterrupt

    assert main(["render", "a.blend", "--probe", "p.exr", "-o", str(tmp_path)], {"render": render}) == 130
    assert "Stopped" in capsys.readouterr().err


def test_the_installed_command(tmp_path):
    code = "import sys; from spectral_probe.cli import main; sys.exit(main())"
    done = subprocess.run(
        [sys.executable, "-c", code, "probe", tmp_path / "x.toml", "-o", tmp_path],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1


def test_long_work_away_from_a_terminal_tells_how_far_it_is(tmp_path, capsys, monkeypatch):
    clock = iter([0.0, 4.0, 11.0, 11.0, 12.0])
    monkeypatch.setattr("spectral_probe.cli_progress.time.monotonic", lambda: next(clock))

    def render(_):
        for step in (0.1, 0.5, 0.6):
            yield Progress(step, "rendering")
        return {}

    assert main(["render", "a.blend", "--probe", "p.exr", "-o", str(tmp_path)], {"render": render}) == 0
    assert capsys.readouterr().err == " 50% rendering\n"


def test_long_lists_of_numbers_are_told_briefly_and_whole_in_json(tmp_path, capsys):
    light, few = [0.5 + 0.125 * band for band in range(61)], [410.0, 530.0, 600.0]
    pairs = [[float(number), -number] for number in range(20)]

    def render(_):
        yield Progress(0.5, "rendering")
        return {"mean_light": light, "pairs": pairs, "wavelengths_nm": few, "objects": ["Ball"] * 40}

    words = ["render", "a.blend", "--probe", "p.exr", "-o", str(tmp_path)]
    assert main(words, {"render": render}) == 0
    told = capsys.readouterr().out.splitlines()
    assert told[:3] == [
        "mean light: 61 numbers, 0.5 to 8",
        "pairs: 40 numbers, -19 to 19",
        "wavelengths nm: 410, 530, 600",
    ]
    assert told[3].count("Ball") == 40  # names are never left out
    assert main([*words, "--json"], {"render": render}) == 0
    assert json.loads(capsys.readouterr().out)["mean_light"] == light


def test_every_verb_is_in_the_manual(project_root):
    subparsers = (action for action in _parser()._actions if isinstance(action, argparse._SubParsersAction))
    verbs = set(next(subparsers).choices)
    page = (project_root / "docs" / "manual" / "command_line.md").read_text("utf-8")
    assert {"demo", "probe", "render"} < verbs
    assert {verb for verb in verbs if f"| `{verb} " not in page} == set()

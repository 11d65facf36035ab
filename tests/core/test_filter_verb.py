"""`spectral-probe filter`: glasses and lamps in a probe file, listed and taken back."""

import json

import cv2
import numpy as np
import pytest

from spectral_probe.cli import main
from spectral_probe.files.probe_exr import read_probe, write_probe
from spectral_probe.geometry.frames import bearing_to_direction, panorama_directions
from spectral_probe.model import SpectralPanorama
from spectral_probe.spectra.colorimetry import chromaticity, illuminant, spectra_to_xyz
from spectral_probe.spectra.glass import glass_transmittance
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.library import daylight, planck

HEIGHT, WIDTH = 64, 128


@pytest.fixture
def probe_file(tmp_path):
    """Two daylight windows at bearings 0 and 90, and a filament lamp at bearing 330, elevation -10, in a dim room."""
    directions = panorama_directions(HEIGHT, WIDTH)
    levels = np.full((HEIGHT, WIDTH, 2), [0.02, 0.0], np.float32)
    for azimuth in (0, 90):
        levels[directions @ bearing_to_direction(azimuth, 10) > np.cos(np.radians(12)), 0] = 1
    levels[directions @ bearing_to_direction(330, -10) > np.cos(np.radians(5))] = [0, 20]
    valid = np.ones((HEIGHT, WIDTH), bool)
    panorama = SpectralPanorama(
        levels,
        np.stack([daylight(6500.0), planck(2850.0)])[None],
        np.zeros((HEIGHT, WIDTH), np.uint8),
        WAVELENGTHS_NM,
        valid,
        np.full((HEIGHT, WIDTH), 0.9, np.float32),
    )
    write_probe(tmp_path / "probe.exr", panorama)
    return tmp_path / "probe.exr"


@pytest.fixture
def region(tmp_path):
    def write(**described):
        (tmp_path / "region.json").write_text(json.dumps(described))
        return tmp_path / "region.json"

    return write


def run(capsys, *words):
    code = main([str(word) for word in words])
    out, err = capsys.readouterr()
    return code, out, err


def numbers_of(capsys, *words):
    code, out, err = run(capsys, "filter", *words, "--json")
    assert (code, err) == (0, "")
    return json.loads(out)


def test_a_red_window(probe_file, region, tmp_path, capsys):
    out = tmp_path / "stained" / "out.exr"
    before = {file.name for file in tmp_path.iterdir()} | {"region.json", "stained"}
    numbers = numbers_of(
        capsys, probe_file, "--glass", "red", "--region", region(seed_deg=[0, 10]), "-o", out
    )
    cap = 2 * np.pi * (1 - np.cos(np.radians(12)))
    assert numbers["solid_angle_sr"] == pytest.approx(cap, rel=0.05)
    assert (numbers["edit"], numbers["kind"], numbers["name"]) == (1, "glass", "red")
    assert numbers["before"]["xy"] == pytest.approx([0.3127, 0.329], abs=2e-3)
    red = spectra_to_xyz(daylight(6500.0) * glass_transmittance("red"))
    assert numbers["after"]["xy"] == pytest.approx(chromaticity(red).tolist(), abs=1e-3)
    assert numbers["after"]["luminance"] == pytest.approx(red[1], rel=1e-3)
    assert {file.name for file in tmp_path.iterdir()} == before
    assert [file.name for file in out.parent.iterdir()] == ["out.exr"]

    code, text, _ = run(capsys, "spectrum", out, "--at", "0,10", "--json")
    assert code == 0
    table = np.genfromtxt(json.loads(text)["csv"], delimiter=",", names=True)
    assert table["radiance"] == pytest.approx(daylight(6500.0) * glass_transmittance("red"), rel=1e-5)
    code, text, _ = run(capsys, "spectrum", out, "--at", "90,10", "--json")
    table = np.genfromtxt(json.loads(text)["csv"], delimiter=",", names=True)
    assert table["radiance"] == pytest.approx(daylight(6500.0), rel=1e-5)


def test_a_filament_lamp_becomes_an_led(probe_file, region, tmp_path, capsys):
    out = tmp_path / "led.exr"
    where = region(seed_deg=[-30, -10])
    numbers = numbers_of(capsys, probe_file, "--lamp", "LED-B3", "--region", where, "-o", out)
    assert numbers["after"]["luminance"] == pytest.approx(numbers["before"]["luminance"], rel=1e-6)
    led = chromaticity(spectra_to_xyz(illuminant("LED-B3")))
    assert numbers["after"]["xy"] == pytest.approx(led.tolist(), abs=1e-4)
    code, text, _ = run(capsys, "spectrum", out, "--at", "-30,-10", "--json")
    assert code == 0
    assert json.loads(text)["confidence"] == pytest.approx(1.0)
    kept = numbers_of(capsys, probe_file, "--lamp", "LED-B3", "--keep", "power", "--region", where, "-o", out)
    assert kept["after"]["luminance"] > 1.2 * kept["before"]["luminance"]
    relit = numbers_of(
        capsys,
        probe_file,
        "--lamp",
        "LED-B3",
        "--keep",
        "surfaces",
        "--was",
        "A",
        "--region",
        where,
        "-o",
        out,
    )
    assert relit["name"] == "LED-B3 for A"
    assert relit["after"]["xy"] == pytest.approx(led.tolist(), abs=2e-3)


def test_edits_are_listed_and_taken_back(probe_file, region, tmp_path, capsys):
    first, second, third = (tmp_path / f"{name}.exr" for name in ("first", "second", "third"))
    polygon = region(polygon_deg=[[340, -10], [20, -10], [20, 30], [340, 30]])
    numbers_of(capsys, probe_file, "--glass", "red", "--region", polygon, "-o", first)
    cv2.imwrite(str(tmp_path / "all.png"), np.full((16, 32), 255, np.uint8))
    numbers = numbers_of(capsys, first, "--glass", "yellow", "--region", region(mask="all.png"), "-o", second)
    assert [edit["name"] for edit in numbers["edits"]] == ["red", "yellow"]
    listed = numbers_of(capsys, second, "--list")
    assert listed["count"] == 2
    assert listed["edits"][1]["solid_angle_sr"] == pytest.approx(4 * np.pi)
    assert listed["edits"][0]["region"] == "polygon of 4 corners about 0.0,10.6"
    numbers = numbers_of(capsys, second, "--remove", "1", "-o", third)
    assert [edit["name"] for edit in numbers["edits"]] == ["yellow"]
    numbers_of(capsys, third, "--remove", "1", "-o", third)
    assert third.read_bytes() == probe_file.read_bytes()
    numbers_of(capsys, second, "--remove", "all", "-o", third)
    assert third.read_bytes() == probe_file.read_bytes()
    assert numbers_of(capsys, third, "--list") == {"count": 0, "edits": []}


def test_a_picture_is_written_where_asked(probe_file, region, tmp_path, capsys):
    where = region(seed_deg=[0, 10])
    out, picture = tmp_path / "out.exr", tmp_path / "pictures" / "out.png"
    numbers_of(capsys, probe_file, "--glass", "red", "--region", where, "-o", out, "--preview", picture)
    row, column = np.unravel_index(
        np.argmax(panorama_directions(HEIGHT, WIDTH) @ bearing_to_direction(0, 10)), (HEIGHT, WIDTH)
    )
    blue, green, red = cv2.imread(str(picture))[row, column].astype(int)
    assert red > green + 80
    assert red > blue + 80
    code, _, err = run(capsys, "filter", probe_file, "--remove", "all", "-o", out, "--preview", tmp_path)
    assert code == 2
    assert "is no file to write a picture to" in err


def test_the_list_as_text(probe_file, region, tmp_path, capsys):
    out = tmp_path / "out.exr"
    run(capsys, "filter", probe_file, "--glass", "green", "--region", region(seed_deg=[90, 10]), "-o", out)
    code, text, _ = run(capsys, "filter", out, "--list")
    assert code == 0
    assert "edits 1:" in text
    assert "name: green" in text


def test_a_glass_of_ones_own(probe_file, region, tmp_path, capsys):
    (tmp_path / "grey.csv").write_text("wavelength_nm,transmittance\n400,0.5\n700,0.5\n")
    numbers = numbers_of(
        capsys, probe_file, "--glass", tmp_path / "grey.csv", "--region", region(seed_deg=[0, 10]),
        "-o", tmp_path / "out.exr",
    )  # fmt: skip
    assert numbers["name"] == "grey.csv"
    assert numbers["after"]["luminance"] == pytest.approx(numbers["before"]["luminance"] / 2)
    assert len(read_probe(tmp_path / "out.exr").edits) == 1


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["--glass", "rred", "--region", "REGION"], 'There is no glass "rred". Did you mean "red"?'),
        (["--lamp", "LED-B33", "--region", "REGION"], "LED-B33"),
        (["--lamp", "LED-B3", "--keep", "surfaces", "--region", "REGION"], "Say which lamp it was"),
        (["--lamp", "LED-B3", "--was", "A", "--region", "REGION"], "give --lamp and --keep surfaces with it"),
        (["--glass", "red"], "Say where: give --region REGION.json."),
        (["--glass", "red", "--region", "lost.json"], "There is no region file lost.json."),
        (["--glass", "red", "--region", "DARK"], "selects nothing"),
        (["--remove", "3"], "The probe has no edit 3: it has none."),
    ],
)
def test_bad_input_gets_one_line_and_writes_nothing(probe_file, region, tmp_path, capsys, words, line):
    region(seed_deg=[0, 10])
    (tmp_path / "dark.json").write_text('{"polygon_deg": [[0, 0], [0.1, 0], [0, 0.1]]}')
    places = {"REGION": tmp_path / "region.json", "DARK": tmp_path / "dark.json"}
    words = [places.get(word, word) for word in words]
    before = {file.name for file in tmp_path.iterdir()}
    code, out, err = run(capsys, "filter", probe_file, *words, "-o", tmp_path / "out.exr")
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert line in err
    assert {file.name for file in tmp_path.iterdir()} == before


def test_where_to_write(probe_file, tmp_path, capsys):
    code, _, err = run(capsys, "filter", probe_file, "--remove", "all")
    assert (code, err) == (2, "Say where to write the edited probe: give -o OUT.exr.\n")
    code, _, err = run(capsys, "filter", probe_file, "--remove", "all", "-o", tmp_path)
    assert code == 2
    assert "is no file to write a probe to" in err
    code, _, err = run(capsys, "filter", tmp_path / "lost.exr", "--list")
    assert (code, err) == (2, f"There is no file {tmp_path / 'lost.exr'}. Check the path.\n")


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["filter", "p.exr", "--glass", "red", "--lamp", "A"], "not allowed with argument"),
        (["filter", "p.exr"], "ne of the arguments --glass --lamp --list --remove is required"),
        (["filter", "p.exr", "--remove", "0"], "is no number of an edit"),
        (["filter", "p.exr", "--lamp", "A", "--keep", "colour"], "invalid choice"),
    ],
)
def test_wrong_words(words, line, capsys):
    with pytest.raises(SystemExit) as left:
        main(words)
    err = capsys.readouterr().err
    assert left.value.code == 2
    assert line in err
    assert err.count("\n") == 1


def test_help_has_an_example(capsys):
    with pytest.raises(SystemExit) as left:
        main(["filter", "--help"])
    assert left.value.code == 0
    assert "Example: spectral-probe filter" in capsys.readouterr().out

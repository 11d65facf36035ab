import json
from unittest.mock import patch

import numpy as np
import pytest

from spectral_probe.cli import main
from spectral_probe.compare_command import CompareSettings, compare, object_masks
from spectral_probe.composite_model import ObjectCoverage
from spectral_probe.errors import SpectralProbeError
from spectral_probe.figures.display import read_png
from spectral_probe.files.image_exr import write_rgb
from spectral_probe.files.objects_exr import write_objects
from spectral_probe.model import finish
from spectral_probe.spectra.colorimetry import chromaticity, illuminant, spectra_to_xyz, white_xyz

SIZE = (20, 30)


def numbers_of(job):
    """What a comparison writes into compare.json, without its pictures."""
    with patch("spectral_probe.compare_command.draw_comparison", lambda *_: iter(())):
        finish(job)


@pytest.fixture
def renders(tmp_path):
    """A folder with a spectral render, an RGB render whose gold is redder, and which pixels are gold and silver."""
    spectral = np.random.default_rng(14).uniform(0.2, 1, (*SIZE, 1)) * white_xyz()
    gold, silver = np.zeros(SIZE, np.float32), np.zeros(SIZE, np.float32)
    gold[4:12, 5:15], gold[12, 5:15] = 1.0, 0.4
    silver[4:12, 18:24] = 0.9
    rgb = np.where(gold[..., None] > 0.5, spectral * (1.08, 1.0, 0.9), spectral)
    write(tmp_path, spectral, rgb)
    nowhere = np.zeros(SIZE, np.float32)
    found = ObjectCoverage({"Gold": gold, "Silver": silver, "Hidden": nowhere}, gold + silver, nowhere)
    write_objects(tmp_path / "objects.exr", found)
    return tmp_path


def write(folder, spectral, rgb):
    write_rgb(folder / "xyz.exr", np.asarray(spectral, np.float32), ("X", "Y", "Z"))
    write_rgb(folder / "rgb.exr", np.asarray(rgb, np.float32), ("X", "Y", "Z"))


def run(capsys, folder, *words):
    files = [str(folder / "xyz.exr"), str(folder / "rgb.exr"), "-o", str(folder / "out")]
    code = main(["compare", *files, *words])
    return code, *capsys.readouterr()


def test_everything_is_written_and_the_numbers_are_by_object(renders, capsys):
    words = ("--json", "--light", "FL11", "--metals", "gold", "main/Cu/McPeak", "--split", "0.25")
    code, out, _ = run(capsys, renders, *words)
    numbers = json.loads(out)
    assert code == 0
    gold, silver = numbers["objects"]
    assert (gold["name"], gold["raw"]["pixels"]) == ("Gold", 80)  # its edge is covered by less than half
    assert gold["raw"]["mean"] > 3
    assert gold["raw"]["p95"] >= gold["raw"]["mean"]
    assert gold["xy_shift"][0] > 0.005
    assert (silver["name"], silver["raw"]["pixels"], silver["raw"]["max"]) == ("Silver", 48, 0.0)
    assert numbers["unseen_objects"] == ["Hidden"]
    assert list(numbers["rgb_ways"]["metals"]) == ["Gold", "main/Cu/McPeak"]
    assert numbers["rgb_ways"]["light"] == "FL11"
    assert numbers["written"] == str(renders / "out")
    del numbers["written"]
    assert json.loads((renders / "out" / "compare.json").read_text()) == numbers
    files = {file.name for file in (renders / "out").iterdir()}
    drawn = {
        f"{name}{suffix}"
        for name in ("sheet", "delta_e", "chromaticity", "rgb_ways")
        for suffix in (".png", ".svg")
    }
    assert files == drawn | {"compare.json", "wipe.png", "spectral.png", "rgb.png"}
    wipe, spectral, rgb = (read_png(renders / "out" / f"{name}.png") for name in ("wipe", "spectral", "rgb"))
    column = round(0.25 * SIZE[1])
    np.testing.assert_array_equal(wipe[:, : column - 1], spectral[:, : column - 1])
    np.testing.assert_array_equal(wipe[:, column + 2 :], rgb[:, column + 2 :])
    assert (wipe[:, column] == 255).all()
    assert not np.array_equal(spectral, rgb)


def test_the_renders_own_light_is_the_light_of_the_four_ways(renders):
    lamp = illuminant("A")
    (renders / "report.json").write_text(json.dumps({"mean_light": lamp.tolist()}))
    numbers_of(compare(renders / "xyz.exr", renders / "rgb.exr", renders / "out"))
    ways = json.loads((renders / "out" / "compare.json").read_text())["rgb_ways"]
    assert ways["light"] == "the render's mean light"
    assert ways["white_xy"] == pytest.approx(chromaticity(spectra_to_xyz(lamp)))
    assert list(ways["metals"]) == ["Gold", "Silver", "Copper"]


@pytest.mark.parametrize(
    "report", ["", "[]", '{"mean_light": null}', '{"mean_light": [1, 2]}', '{"mean_light": "x"}']
)
def test_without_its_own_light_it_is_d65(renders, report):
    (renders / "report.json").write_text(report)
    numbers_of(compare(renders / "xyz.exr", renders / "rgb.exr", renders / "out"))
    assert json.loads((renders / "out" / "compare.json").read_text())["rgb_ways"]["light"] == "D65"


def test_what_is_not_a_number_is_said_and_left_out(renders):
    spectral = np.ones((*SIZE, 3))
    rgb = spectral.copy()
    spectral[0, 0], rgb[3, 4:7, 1] = np.nan, np.inf
    write(renders, spectral, rgb)
    numbers_of(compare(renders / "xyz.exr", renders / "rgb.exr", renders / "out"))
    numbers = json.loads((renders / "out" / "compare.json").read_text())
    assert numbers["remarks"] == [
        "1 pixel of xyz.exr is not a number and left out: hatched in the map.",
        "3 pixels of rgb.exr are not numbers and left out: hatched in the map.",
    ]
    assert numbers["image"]["raw"]["pixels"] == SIZE[0] * SIZE[1] - 4


def test_coverage_of_another_size_is_said(renders):
    masks, told = object_masks(renders, (5, 6))
    assert masks == {}
    assert told == ["objects.exr is 30 x 20 pixels, the renders 6 x 5: there are no numbers by object."]
    assert object_masks(renders / "elsewhere", SIZE) == ({}, [])


@pytest.mark.parametrize(
    ("spectral", "rgb", "settings", "message"),
    [
        (np.ones((4, 6, 3)), np.ones((4, 4, 3)), {}, "xyz.exr is 6 x 4 pixels, rgb.exr is 4 x 4"),
        (np.ones((4, 6, 3)), np.zeros((4, 6, 3)), {}, "RGB image is black in every pixel"),
        (np.zeros((4, 6, 3)), np.ones((4, 6, 3)), {}, "spectral image is black in every pixel"),
        (
            np.full((4, 6, 3), np.nan),
            np.ones((4, 6, 3)),
            {},
            "24 of the 24 pixels of the spectral image are not",
        ),
        (np.ones((4, 6, 3)), np.ones((4, 6, 3)), {"light": "FL99"}, 'no lamp called "FL99"'),
        (np.ones((4, 6, 3)), np.ones((4, 6, 3)), {"light": "mine.csv"}, "no file mine.csv"),
        (np.ones((4, 6, 3)), np.ones((4, 6, 3)), {"light": "none.exr"}, "no file none.exr"),
        (np.ones((4, 6, 3)), np.ones((4, 6, 3)), {"at": (0.0, 0.0)}, '"D65" has no directions'),
        (np.ones((4, 6, 3)), np.ones((4, 6, 3)), {"metals": ("gould",)}, 'Did you mean "Au"'),
        (np.ones((4, 6, 3)), np.ones((4, 6, 3)), {"metals": ()}, "at least one metal"),
    ],
)
def test_bad_input_is_one_clear_line_and_writes_nothing(tmp_path, spectral, rgb, settings, message):
    write(tmp_path, spectral, rgb)
    with pytest.raises(SpectralProbeError, match=message) as caught:
        numbers_of(
            compare(tmp_path / "xyz.exr", tmp_path / "rgb.exr", tmp_path / "out", CompareSettings(**settings))
        )
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--split", "1.5"), "not a number from 0 to 1"),
        (("--blur", "nan"), "not a number from 0 to 90"),
        (("--at", "1,2", "--region", "a.json"), "not allowed with"),
    ],
)
def test_words_that_make_no_sense(renders, capsys, words, message):
    with pytest.raises(SystemExit) as stop:
        run(capsys, renders, *words)
    assert stop.value.code == 2
    assert message in capsys.readouterr().err

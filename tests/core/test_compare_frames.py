import csv
import json

import numpy as np
import pytest

from spectral_probe.cli import main
from spectral_probe.compare_frames import frames_in
from spectral_probe.errors import FileFormatError
from spectral_probe.figures.contact_sheet import MOST_FRAMES, Tiles
from spectral_probe.files.image_exr import write_rgb
from spectral_probe.spectra.colorimetry import white_xyz


def write_frame(folder, frame, redder, size=(8, 12)):
    """A finished frame whose RGB render is redder by a share."""
    place = folder / f"frame_{frame:04d}"
    place.mkdir(parents=True)
    spectral = np.random.default_rng(frame).uniform(0.2, 1, (*size, 1)) * white_xyz()
    write_rgb(place / "xyz.exr", spectral.astype(np.float32), ("X", "Y", "Z"))
    rgb = spectral * (1 + redder, 1, 1)
    write_rgb(place / "rgb.exr", rgb.astype(np.float32), ("X", "Y", "Z"))
    (place / "report.json").write_text("{}")
    return place


def test_what_is_there_is_compared_and_what_is_not_is_named(tmp_path, capsys):
    write_frame(tmp_path, 1, 0.02)
    write_frame(tmp_path, 2, 0.1, size=(12, 8))
    (write_frame(tmp_path, 3, 0.0) / "report.json").unlink()
    (write_frame(tmp_path, 4, 0.0) / "xyz.exr").write_bytes(b"no image")
    code = main(["compare", str(tmp_path), "-o", str(tmp_path), "--frames", "1-5", "--json"])
    out, err = capsys.readouterr()
    numbers = json.loads(out)
    assert code == 2
    assert err.startswith("3 of 5 frames were not compared: 3 (report.json is missing); 4 (")
    assert "5 (there is no such frame)" in err
    assert err.count("\n") == 1
    assert numbers["failed_frames"] == [3, 4, 5]
    assert numbers["worst_frame"]["frame"] == 2
    with (tmp_path / "comparison.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["status"] for row in rows] == ["compared", "compared", "failed", "failed", "failed"]
    assert (rows[1]["width_px"], rows[1]["height_px"]) == ("8", "12")
    assert float(rows[1]["de2000_mean"]) > float(rows[0]["de2000_mean"]) > 0
    told = json.loads((tmp_path / "comparison.json").read_text())
    assert told["rows"][0]["image"]["raw"]["mean"] == float(rows[0]["de2000_mean"])
    assert (tmp_path / "contact_sheet.png").stat().st_size > 1000


@pytest.mark.parametrize("unfinished", [False, True])
def test_without_a_frame_nothing_is_written(tmp_path, capsys, unfinished):
    render = tmp_path / "render"
    render.mkdir()
    if unfinished:
        (render / "frame_0001").mkdir()
    assert main(["compare", str(render), "-o", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_frames_are_in_order_and_other_folders_none(tmp_path):
    for name in ("frame_0010", "frame_0002", "frame_-001", "frame_002", "frame_12345", "other"):
        (tmp_path / name).mkdir()
    assert frames_in(tmp_path) == (-1, 2, 10, 12345)
    with pytest.raises(FileFormatError, match="no frames"):
        frames_in(tmp_path / "other")


def test_of_many_frames_an_even_choice_is_shown():
    chosen = sorted(Tiles(range(1, 241)).chosen)
    assert (len(chosen), chosen[0], chosen[-1]) == (MOST_FRAMES, 1, 240)
    assert set(np.diff(chosen)) <= {6, 7}

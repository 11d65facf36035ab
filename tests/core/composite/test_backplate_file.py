"""backplate.json comes back as it was, and anything else is refused in one sentence."""

import json
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from spectral_probe.composite.backplate_file import load_backplate, save_backplate
from spectral_probe.composite_model import Backplate
from spectral_probe.errors import FileFormatError
from spectral_probe.model import Camera


def backplate(folder: Path) -> Backplate:
    return Backplate(
        camera=Camera((900.5, 910.25), (301.5, 198.0), (600, 400), (0.1, -0.02, 1e-3, 2e-3, 0.0), "EXIF"),
        rotation=np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
        position_m=np.array([0.1, -2.0, 0.7]),
        photo=folder / "photos" / "plate.jpg",
        photo_size_px=(6000, 4000),
        frame_px=(-12.0, -8.5, 624, 417),
        ball_centre_m=np.array([0.0, 0.0, 0.05]),
        ball_radius_m=0.05,
        camera_model="Nikon 5100 (NPL)",
        sensitivities=folder / "curves.csv",
        response_log_gain=np.linspace(-0.1, 0.1, 75).reshape(3, 25),
        exposure=0.0125,
        gain=np.array([1.0, 0.98, 1.01]),
    )


@pytest.mark.parametrize("bare", [False, True])
def test_comes_back_the_same(tmp_path: Path, bare: bool) -> None:
    written = backplate(tmp_path)
    if bare:
        written = replace(
            written,
            photo=Path(),
            ball_centre_m=None,
            ball_radius_m=0.0,
            sensitivities=None,
            response_log_gain=None,
        )
    save_backplate(tmp_path / "backplate.json", written)
    found = load_backplate(tmp_path / "backplate.json")
    for field in fields(Backplate):
        one, other = getattr(written, field.name), getattr(found, field.name)
        if isinstance(one, np.ndarray):
            np.testing.assert_array_equal(one, other, err_msg=field.name)
        else:
            assert one == other, field.name


def test_files_are_found_again_after_the_whole_folder_moved(tmp_path: Path) -> None:
    (tmp_path / "here").mkdir()
    save_backplate(tmp_path / "here" / "render" / "backplate.json", backplate(tmp_path / "here"))
    (tmp_path / "here").rename(tmp_path / "there")
    found = load_backplate(tmp_path / "there" / "render" / "backplate.json")
    assert found.photo == tmp_path / "there" / "photos" / "plate.jpg"
    assert found.sensitivities == tmp_path / "there" / "curves.csv"


@pytest.mark.parametrize(
    "changed",
    [
        {"rotation": [[1, 0], [0, 1]]},
        {"camera": None},
        {"gain": [1, 1, None]},
        {"version": 99},
        {"exposure": "bright"},
    ],
)
def test_what_is_no_backplate_is_refused(tmp_path: Path, changed: dict[str, object]) -> None:
    path = tmp_path / "backplate.json"
    save_backplate(path, backplate(tmp_path))
    path.write_text(json.dumps(json.loads(path.read_text()) | changed))
    with pytest.raises(FileFormatError, match=r"backplate\.json does not describe a backplate"):
        load_backplate(path)


def test_no_json_and_no_file_are_refused(tmp_path: Path) -> None:
    (tmp_path / "x.json").write_text("[" * 3)
    with pytest.raises(FileFormatError, match="does not describe"):
        load_backplate(tmp_path / "x.json")
    with pytest.raises(FileFormatError, match="no backplate"):
        load_backplate(tmp_path / "y.json")

"""The operator gives the scene what the function gives, and reports what is wrong with the photographs."""

import json
from pathlib import Path

import bpy
import cv2
import numpy as np
import pytest

ops = bpy.ops.spectral_probe
FOCAL_PX, SIZE = 500.0, (400, 300)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Six photographs of a chessboard of 7 x 5 squares through a pinhole."""
    found = tmp_path_factory.mktemp("boards")
    row, column = np.mgrid[:7, :9]
    inside = (row > 0) & (row < 6) & (column > 0) & (column < 8)
    board = np.kron(
        np.where(inside & ((row + column) % 2 == 0), 25, 230).astype(np.uint8), np.ones((40, 40), np.uint8)
    )
    to_squares = np.array([[1 / 40, 0, -4.5], [0, 1 / 40, -3.5], [0, 0, 1]])
    lens = np.array([[FOCAL_PX, 0, 200.0], [0, FOCAL_PX, 150.0], [0, 0, 1]])
    for number in range(6):
        towards = number * np.pi / 3
        turn = cv2.Rodrigues(np.array([np.cos(towards), np.sin(towards), 0.05 * number]) * 0.5)[0]
        pose = np.column_stack([turn[:, 0], turn[:, 1], (0.2 * number - 0.5, 0.1 * number - 0.3, 13.5)])
        seen = cv2.warpPerspective(board, lens @ pose @ to_squares, SIZE, borderValue=110)
        cv2.imwrite(str(found / f"b{number}.png"), cv2.GaussianBlur(seen, (0, 0), 0.8))
    return found


def files(folder: Path) -> list[dict[str, str]]:
    return [{"name": path.name} for path in sorted(folder.glob("b*.png"))]


def test_calibrate_gives_what_the_function_gives(settings, folder, in_extension):
    assert ops.calibrate(directory=str(folder), files=files(folder)) == {"FINISHED"}
    written = json.loads((folder / "camera.json").read_text())
    assert (settings.camera.focal_source, Path(settings.camera.calibration)) == (
        "CALIBRATION",
        folder / "camera.json",
    )
    finish = in_extension("spectral_probe.model").finish
    paths = sorted(folder.glob("b*.png"))
    expected = finish(in_extension("spectral_probe.geometry.calibration").calibrate(paths))
    assert written["focal_px"] == pytest.approx(expected.focal_px)
    assert written["focal_px"] == pytest.approx((FOCAL_PX, FOCAL_PX), rel=0.005)


def test_calibrate_reports_and_changes_nothing(settings, folder):
    for chosen, message in (
        ([], "Choose the photographs of the board"),
        (files(folder)[:2], "2 photographs are too few"),
        ([*files(folder), {"name": "lost.png"}], r"There is no photograph .*lost\.png"),
    ):
        with pytest.raises(RuntimeError, match=message):
            ops.calibrate(directory=str(folder), files=chosen, result_name="other.json")
    assert not (folder / "other.json").exists()
    assert settings.camera.focal_source == "EXIF"

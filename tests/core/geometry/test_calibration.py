"""Cameras from boards rendered through a known lens: every pixel's rays are traced to the board."""

import functools
import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from spectral_probe.cli import main
from spectral_probe.errors import CaptureError, PhotographError
from spectral_probe.geometry.boards import Board, board_from
from spectral_probe.geometry.calibration import calibrate, calibration_record, find_boards, fit_camera
from spectral_probe.geometry.camera import camera_for, pixel_rays, project
from spectral_probe.model import Camera, CameraSettings, finish
from spectral_probe.photo.read import read_photograph

LENS = Camera((812.0, 806.0), (331.0, 236.5), (640, 480), (-0.12, 0.06, 0.0008, -0.0011, 0.0))
SQUARE_PX = 40


def chessboard(columns: int, rows: int) -> np.ndarray:
    """A board with a white margin of one square, `SQUARE_PX` a square."""
    row, column = np.mgrid[: rows + 2, : columns + 2]
    inside = (row > 0) & (row <= rows) & (column > 0) & (column <= columns)
    squares = np.where(inside & ((row + column) % 2 == 0), 25, 230).astype(np.uint8)
    return np.kron(squares, np.ones((SQUARE_PX, SQUARE_PX), np.uint8))


def charuco(columns: int, rows: int, *, legacy: bool = False) -> np.ndarray:
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_100)
    board = cv2.aruco.CharucoBoard((columns, rows), 1.0, 0.7, dictionary)
    board.setLegacyPattern(legacy)
    printed = board.generateImage((columns * SQUARE_PX, rows * SQUARE_PX), None, 0, 1)
    bordered = cv2.copyMakeBorder(printed, *(SQUARE_PX,) * 4, cv2.BORDER_CONSTANT, value=255)
    return (25 + bordered * 0.8).astype(np.uint8)


@functools.cache
def traced() -> np.ndarray:
    """Rays through the lens (4 H W, 2), two by two a pixel, as points of the plane z = 1."""
    width, height = LENS.size_px
    fine = np.stack(np.meshgrid(np.arange(2 * width) + 0.5, np.arange(2 * height) + 0.5), -1) / 2
    rays = pixel_rays(LENS, fine).reshape(-1, 3)
    return rays[:, :2] / rays[:, 2:]


def rendered(
    texture: np.ndarray, pose: tuple[np.ndarray, np.ndarray], seed: int = 0, bend: float = 0.0
) -> np.ndarray:
    """A grey photograph of a board centred at the pose, in squares; `bend` curls it along its columns."""
    width, height = LENS.size_px
    rotation, shift = cv2.Rodrigues(pose[0])[0], pose[1]
    to_board = np.linalg.inv(np.column_stack([rotation[:, 0], rotation[:, 1], shift]))
    board = traced() @ to_board[:, :2].T + to_board[:, 2]
    board = board[:, :2] / board[:, 2:]
    board[:, 1] += bend * board[:, 0] ** 2
    at = (board * SQUARE_PX + np.array(texture.shape[::-1]) / 2 - 0.5).reshape(2 * height, 2 * width, 2)
    seen = cv2.remap(
        texture,
        at.astype(np.float32),
        None,
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=110,
    )
    image = cv2.resize(seen, LENS.size_px, interpolation=cv2.INTER_AREA).astype(np.float32)
    noise = np.random.default_rng(seed).normal(0.0, 1.5, image.shape)
    return np.clip(cv2.GaussianBlur(image, (0, 0), 0.7) + noise, 0, 255).round().astype(np.uint8)


def poses(count: int, distance: float = 16.0) -> list[tuple[np.ndarray, np.ndarray]]:
    """Boards tilted by 18, 35 and 52 degrees to all sides, off the axis."""
    rng = np.random.default_rng(2)
    found = []
    for number in range(count):
        towards, tilt = 2 * np.pi * number / count, np.radians(18 + 17 * (number % 3))
        axis = np.array([np.cos(towards), np.sin(towards), 0.0]) * tilt
        turned = cv2.Rodrigues(axis)[0] @ cv2.Rodrigues(np.array([0.0, 0.0, rng.uniform(-0.5, 0.5)]))[0]
        place = np.array([rng.uniform(-2, 2), rng.uniform(-1.2, 1.2), distance * rng.uniform(0.9, 1.2)])
        found.append((cv2.Rodrigues(turned)[0].ravel(), place))
    return found


@pytest.fixture(scope="module")
def photos(tmp_path_factory) -> list[Path]:
    """Twelve photographs of a chessboard of 9 x 6 squares."""
    folder = tmp_path_factory.mktemp("boards")
    for number, pose in enumerate(poses(12)):
        cv2.imwrite(str(folder / f"b{number:02}.png"), rendered(chessboard(9, 6), pose, number))
    return sorted(folder.iterdir())


@pytest.fixture(scope="module")
def calibration(photos):
    return finish(calibrate(photos))


def assert_is_the_lens(found) -> None:
    assert found.focal_px == pytest.approx(LENS.focal_px, rel=0.002)
    # A wrong convention of pixel centres would miss by 0.5 in both.
    assert found.principal_px == pytest.approx(LENS.principal_px, abs=1.0)
    assert found.rms_px < 0.2
    for axis in (0, 1):
        assert abs(found.focal_px[axis] - LENS.focal_px[axis]) < 4 * found.focal_error_px[axis] + 0.3
        assert (
            abs(found.principal_px[axis] - LENS.principal_px[axis]) < 4 * found.principal_error_px[axis] + 0.1
        )
    # What counts is where rays go: within a tenth of a pixel wherever the boards were.
    camera = Camera(found.focal_px, found.principal_px, LENS.size_px, found.distortion)
    rays = np.random.default_rng(5).uniform((-0.3, -0.2, 1), (0.3, 0.2, 1), (500, 3))
    assert np.abs(project(camera, rays) - project(LENS, rays)).max() < 1.0


def test_a_chessboard_of_unknown_size_gives_the_lens(calibration, photos):
    assert (calibration.board.kind, calibration.board.columns, calibration.board.rows) == ("chessboard", 9, 6)
    assert_is_the_lens(calibration)
    assert set(calibration.used) == {photo.name for photo in photos}
    assert max(calibration.used.values()) < 0.2
    assert calibration.dropped == {}


def test_pixel_centres_are_at_halves(photos):
    """The principal point is half a pixel from OpenCV's, whose pixel centres are integers."""
    images = [cv2.imread(str(photo), cv2.IMREAD_GRAYSCALE) for photo in photos]
    board, found = find_boards(images, Board())
    points = [view.points_m.astype(np.float32) for view in found]
    corners = [(view.corners_px - 0.5).astype(np.float32) for view in found]
    _, matrix, *_ = cv2.calibrateCamera(points, corners, LENS.size_px, None, None, flags=cv2.CALIB_FIX_K3)
    fitted = fit_camera(
        board, {photo.name: view for photo, view in zip(photos, found, strict=True)}, LENS.size_px
    )
    assert fitted.principal_px == pytest.approx((matrix[0, 2] + 0.5, matrix[1, 2] + 0.5), abs=0.02)
    # The corners themselves, against the truth: their mean error would be 0.5 px in either wrong convention.
    rotation, shift = cv2.Rodrigues(poses(12)[0][0])[0], poses(12)[0][1]
    grid = np.stack(np.meshgrid(np.arange(8) - 3.5, np.arange(5) - 2.0, 0.0), -1).reshape(-1, 3)
    truth = project(LENS, grid @ rotation.T + shift)
    nearest = np.abs(truth[:, None] - found[0].corners_px[None]).sum(-1).argmin(1)
    offsets = found[0].corners_px[nearest] - truth
    assert np.abs(offsets.mean(0)).max() < 0.03
    assert np.linalg.norm(offsets, axis=-1).max() < 0.15


@pytest.mark.parametrize(("columns", "rows", "legacy"), [(9, 6, False), (8, 6, True), (5, 7, False)])
def test_a_charuco_board_of_which_nothing_is_said(columns, rows, legacy):
    texture = charuco(columns, rows, legacy=legacy)
    images = [rendered(texture, pose, number) for number, pose in enumerate(poses(6, 15.0))]
    # A marker that is not the board's lies about in one picture.
    alien = cv2.aruco.generateImageMarker(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_100), 77, 28)
    images[1][:40, :40] = 230
    images[1][6:34, 6:34] = alien
    board, found = find_boards(images, Board())
    assert (board.kind, board.columns, board.rows, board.legacy) == ("charuco", columns, rows, legacy)
    assert board.marker_share == pytest.approx(0.7, abs=0.03)
    fitted = fit_camera(board, {str(number): view for number, view in enumerate(found)}, LENS.size_px)
    assert fitted.focal_px == pytest.approx(LENS.focal_px, rel=0.004)  # six photographs, not twelve
    assert fitted.rms_px < 0.2


@pytest.mark.parametrize("given", [Board("chessboard", 9, 6), Board("chessboard", 6, 9), Board("auto", 8, 5)])
def test_the_size_given_may_be_turned_or_count_inner_corners(photos, given):
    images = [cv2.imread(str(photo), cv2.IMREAD_GRAYSCALE) for photo in photos[:2]]
    board, found = find_boards(images, given)
    assert (board.columns, board.rows) == (9, 6)
    assert [len(view.corners_px) for view in found] == [40, 40]


def test_a_bent_board_and_a_picture_without_one_are_left_out_by_name(photos, tmp_path):
    cv2.imwrite(str(tmp_path / "bent.png"), rendered(chessboard(9, 6), poses(12)[3], 3, bend=0.01))
    cv2.imwrite(
        str(tmp_path / "none.png"), np.random.default_rng(0).integers(90, 120, (480, 640)).astype(np.uint8)
    )
    found = finish(calibrate([*photos[:9], tmp_path / "bent.png", tmp_path / "none.png"]))
    assert set(found.dropped) == {"bent.png", "none.png"}
    assert "far above" in found.dropped["bent.png"]
    assert found.dropped["none.png"] == "no chessboard found"
    assert found.focal_px == pytest.approx(LENS.focal_px, rel=0.003)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (Board("chessboard", 7, 5), "show a chessboard of 9 x 6 squares, not 7 x 5. Give the size"),
        (Board("charuco"), "No ChArUco board was found in the 5 photographs"),
    ],
)
def test_another_board_than_the_one_described(photos, given, message):
    with pytest.raises(CaptureError, match=message):
        finish(calibrate(photos[:5], given))


def test_a_charuco_board_of_another_size_is_named():
    images = [rendered(charuco(9, 6), pose) for pose in poses(4)[:2]]
    with pytest.raises(CaptureError, match="show a ChArUco board of 9 x 6 squares, not 7 x 5"):
        find_boards(images, Board("charuco", 7, 5))


def test_what_the_photographs_do_not_determine_is_refused(photos, tmp_path):
    with pytest.raises(CaptureError, match="3 photographs are too few"):
        finish(calibrate(photos[:3]))
    pose = poses(12)[4]
    for number in range(5):  # one direction, five places
        moved = (pose[0], pose[1] + np.array([0.5 * number - 1, 0.3 * number - 0.6, 0.0]))
        cv2.imwrite(str(tmp_path / f"same{number}.png"), rendered(chessboard(9, 6), moved, number))
    with pytest.raises(CaptureError, match=r"All \d photographs show the board from the same direction"):
        finish(calibrate(sorted(tmp_path.iterdir())))


def test_photographs_that_do_not_belong_together(photos, tmp_path):
    small = cv2.resize(cv2.imread(str(photos[0])), (320, 240))
    cv2.imwrite(str(tmp_path / "small.png"), small)
    cv2.imwrite(str(tmp_path / "turned.png"), cv2.imread(str(photos[0])).swapaxes(0, 1))
    with pytest.raises(CaptureError, match=r"small\.png is 320 x 240 pixels, but b00\.png is 640 x 480"):
        finish(calibrate([*photos[:4], tmp_path / "small.png"]))
    with pytest.raises(CaptureError, match=r"turned\.png is 480 x 640 .* same way up"):
        finish(calibrate([*photos[:4], tmp_path / "turned.png"]))
    with pytest.raises(CaptureError, match=r"b00\.png is given twice"):
        finish(calibrate([*photos[:4], photos[0]]))
    with pytest.raises(PhotographError, match=r"There is no photograph .*gone\.png"):
        finish(calibrate([*photos[:4], tmp_path / "gone.png"]))


def test_no_board_at_all(tmp_path):
    for number in range(4):
        ramp = np.tile(np.linspace(20, 200 + number, 160), (120, 1)).astype(np.uint8)
        cv2.imwrite(str(tmp_path / f"{number}.png"), ramp)
    with pytest.raises(CaptureError, match=r"No board was found in the 4 photographs\. Show all of it"):
        finish(calibrate(sorted(tmp_path.iterdir())))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("auto", 9, None, None, None, None), "both the columns and the rows"),
        (("auto", 2, 9, None, None, None), "at least 3 squares"),
        (("charuco", 9, 6, None, 20.0, None), "needs the side of a square"),
        (("charuco", 9, 6, 20.0, 30.0, None), "must be the larger"),
        (("chessboard", 9, 6, None, None, "4X4_50"), "A chessboard has no markers"),
        (("charuco", 9, 6, None, None, "4X5_50"), 'no marker dictionary "4X5_50"'),
    ],
)
def test_contradictory_descriptions(words, message):
    with pytest.raises(CaptureError, match=message):
        board_from(*words)


# ---------------------------------------------------------------- the command and its file


def test_the_command_writes_what_the_pipeline_reads(photos, calibration, tmp_path, capsys):
    path = tmp_path / "camera.json"
    words = ["calibrate", *map(str, photos[:6]), "-o", str(path), "--square-mm", "25", "--json"]
    assert main(words) == 0
    told = json.loads(capsys.readouterr().out)
    written = json.loads(path.read_text())
    assert told == {**written, "written": str(path)}
    assert written["focal_px"] == pytest.approx(calibration.focal_px, rel=0.002)
    assert written["image_size_px"] == [640, 480]
    assert written["board"]["square_mm"] == 25.0
    assert set(calibration_record(calibration)) == set(written)
    assert {"rms_px", "distortion", "date", "focal_error_px", "photos", "dropped"} <= set(written)
    camera = camera_for(CameraSettings(calibration=path), read_photograph(photos[0], grey=True))
    assert list(camera.focal_px) == written["focal_px"]
    assert list(camera.distortion) == written["distortion"]


def test_bad_input_is_one_line_and_nothing_is_written(photos, tmp_path, capsys):
    before = photos[0].read_bytes()
    for output, line in (
        (tmp_path, "is a folder. Give the name of a file"),
        (photos[0], "is one of the photographs"),
        (tmp_path / "camera.json", "2 photographs are too few"),
    ):
        assert main(["calibrate", *map(str, photos[:2]), "-o", str(output)]) == 2
        err = capsys.readouterr().err
        assert line in err
        assert err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []
    assert photos[0].read_bytes() == before

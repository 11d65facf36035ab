"""The camera's intrinsics from photographs of a calibration board (Zhang 2000, doi:10.1109/34.888718).

OpenCV fits; what is added here is judgement: which photographs to leave out, whether the lens needs a sixth-order term,
whether the photographs determine the focal length at all, and how sure the result is.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from ..errors import CaptureError
from ..files.atomic import written_whole
from ..model import FloatArray, Job, Photograph, Progress
from ..photo.read import read_photograph
from .boards import Board, BoardView, GreyImage
from .charuco import find_charuco_boards
from .chessboard import find_chessboards

FEWEST_PHOTOS = 4
"""Zhang's method needs three photographs; the fourth is what tells a bad one."""

OUTLIER_RATIO = 3.0
"""A photograph whose error is this many times the median of the others does not show the board as the others do: blurred,
bent, or wrongly found. Errors of good photographs stay within a factor of two."""

OUTLIER_FLOOR_PX = 0.15
"""Below this error no photograph is left out: it is no worse than sub-pixel detection."""

FOCAL_ERROR_LIMIT = 0.02
"""Relative standard error of the focal length above which the photographs do not determine it."""

FOCAL_ERROR_WARNING = 0.005
LEAST_TILT_DEG = 8.0
"""Parallel boards say nothing of the focal length, however many (Zhang 2000, section 3.4): normals must spread this far."""

_SIGNIFICANT = 3.0
_CRITERIA = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-10)


@dataclass(frozen=True)
class CameraCalibration:
    """A calibrated camera, and how it came about.

    Lengths in pixels, pixel centres at integer + 0.5; two numbers are (x, y). `distortion` in OpenCV's order
    k1 k2 p1 p2 k3. `focal_error_px` and `principal_error_px` are standard errors. `used` maps the photographs' names to
    their RMS reprojection error in pixels, `dropped` those left out to the reason.
    """

    focal_px: tuple[float, float]
    principal_px: tuple[float, float]
    distortion: tuple[float, ...]
    rms_px: float
    image_size_px: tuple[int, int]
    focal_error_px: tuple[float, float]
    principal_error_px: tuple[float, float]
    board: Board
    used: dict[str, float]
    dropped: dict[str, str]
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class _Fit:
    """What OpenCV gives for some views; `normals` (V, 3) of the board in the camera's frame."""

    matrix: FloatArray
    distortion: FloatArray
    rms_px: float
    errors_px: FloatArray
    deviations: FloatArray
    normals: FloatArray


def calibrate(paths: Sequence[Path], board: Board | None = None) -> Job[CameraCalibration]:
    """Calibrate a camera from photographs of a board.

    Parameters
    ----------
    paths
        Photographs of the same size, lens, zoom and focus, the board at many angles; ten or more serve well.
    board
        What is known of the board; None: everything is found out.

    Yields
    ------
    Progress

    Returns
    -------
    CameraCalibration

    Raises
    ------
    SpectralProbeError
        If the photographs do not determine the camera; the message says why and what to do.
    """
    names = _names(paths)
    if len(paths) < FEWEST_PHOTOS:
        raise CaptureError(
            f"{len(paths)} photograph{'s are' if len(paths) != 1 else ' is'} too few for a calibration. Photograph the board "
            f"at least {FEWEST_PHOTOS} times, better ten, each time from another angle."
        )
    images: list[GreyImage] = []
    first: Photograph | None = None
    for number, path in enumerate(paths):
        yield Progress(0.5 * number / len(paths), f"Reading {path.name}")
        photograph = read_photograph(path, grey=True)
        first = first or photograph
        _check_alike(first, photograph)
        images.append(grey_image(photograph))
    yield Progress(0.5, "Finding the board")
    full_board, found = find_boards(images, board or Board())
    yield Progress(0.9, "Fitting the camera")
    height, width = images[0].shape
    return fit_camera(full_board, dict(zip(names, found, strict=True)), (width, height))


def fit_camera(
    board: Board, found: dict[str, BoardView | str], size_px: tuple[int, int]
) -> CameraCalibration:
    """The camera that saw the corners of some photographs, without those that contradict the rest.

    Parameters
    ----------
    board
        The board.
    found
        By photograph: the corners, or why there are none.
    size_px
        Width and height of the photographs.
    """
    dropped = {name: reason for name, reason in found.items() if isinstance(reason, str)}
    views = {name: view for name, view in found.items() if not isinstance(view, str)}
    if len(views) < FEWEST_PHOTOS:
        name, reason = next(iter(dropped.items()))
        raise CaptureError(
            f"The {board.described()} was found in only {len(views)} of {len(found)} photographs ({name}: {reason}); "
            f"{FEWEST_PHOTOS} are needed. Show all of it, sharp and evenly lit."
        )
    fit = _fit(list(views.values()), size_px)
    while len(views) > FEWEST_PHOTOS:
        worst = int(np.argmax(fit.errors_px))
        usual = float(np.median(np.delete(fit.errors_px, worst)))
        if fit.errors_px[worst] <= max(OUTLIER_RATIO * usual, OUTLIER_FLOOR_PX):
            break
        name = list(views)[worst]
        dropped[name] = f"its error of {fit.errors_px[worst]:.2f} px is far above the others' {usual:.2f} px"
        del views[name]
        fit = _fit(list(views.values()), size_px)
    _check_determined(fit, len(views))
    matrix, deviations = fit.matrix, fit.deviations
    return CameraCalibration(
        focal_px=(float(matrix[0, 0]), float(matrix[1, 1])),
        # OpenCV counts pixel centres at integers.
        principal_px=(float(matrix[0, 2]) + 0.5, float(matrix[1, 2]) + 0.5),
        distortion=tuple(float(value) for value in fit.distortion),
        rms_px=fit.rms_px,
        image_size_px=size_px,
        focal_error_px=(float(deviations[0]), float(deviations[1])),
        principal_error_px=(float(deviations[2]), float(deviations[3])),
        board=board,
        used={name: float(error) for name, error in zip(views, fit.errors_px, strict=True)},
        dropped=dropped,
        warnings=_warnings(fit, views, size_px),
    )


def _fit(views: Sequence[BoardView], size_px: tuple[int, int]) -> _Fit:
    """Fit with the sixth-order term k3 only where the photographs show that there is one: else it bends the edges at will."""
    full = _opencv_fit(views, size_px, 0)
    if abs(full.distortion[4]) > _SIGNIFICANT * full.deviations[8]:
        return full
    return _opencv_fit(views, size_px, cv2.CALIB_FIX_K3)


def _opencv_fit(views: Sequence[BoardView], size_px: tuple[int, int], flags: int) -> _Fit:
    points = [view.points_m.astype(np.float32) for view in views]
    corners = [(view.corners_px - 0.5).astype(np.float32).reshape(-1, 1, 2) for view in views]
    try:
        rms, matrix, distortion, rotations, _, deviations, _, errors = cv2.calibrateCameraExtended(
            points, corners, size_px, None, None, flags=flags, criteria=_CRITERIA
        )
    except cv2.error as error:
        raise CaptureError(
            "No camera fits the corners found. Photograph one flat board at several angles, and give its size."
        ) from error
    normals = np.stack([cv2.Rodrigues(rotation)[0][:, 2] for rotation in rotations])
    return _Fit(matrix, distortion.ravel()[:5], float(rms), errors.ravel(), deviations.ravel(), normals)


def _check_determined(fit: _Fit, count: int) -> None:
    """Refuse what parallel boards, or too little tilt, left open."""
    cosines = np.clip(np.abs(fit.normals @ fit.normals.T), 0.0, 1.0)
    spread_deg = float(np.degrees(np.arccos(cosines.min())))
    errors = fit.deviations[:2] / np.diag(fit.matrix)[:2]
    if spread_deg < LEAST_TILT_DEG:
        raise CaptureError(
            f"All {count} photographs show the board from the same direction (within {spread_deg:.1f} degrees), which leaves "
            "the focal length open. Tilt the board by 20 to 40 degrees, to every side."
        )
    if not np.isfinite(errors).all() or errors.max() > FOCAL_ERROR_LIMIT:
        raise CaptureError(
            f"The photographs leave the focal length open ({fit.matrix[0, 0]:.0f} px with a standard error of "
            f"{fit.deviations[0]:.0f}). Take more, sharper, with the board tilted by 20 to 40 degrees to every side."
        )


def _warnings(fit: _Fit, views: dict[str, BoardView], size_px: tuple[int, int]) -> tuple[str, ...]:
    told = []
    if (error := float((fit.deviations[:2] / np.diag(fit.matrix)[:2]).max())) > FOCAL_ERROR_WARNING:
        told.append(f"The focal length is known to {error:.1%} only: take more photographs, with more tilt.")
    half = np.array(size_px) / 2
    corners = np.concatenate([view.corners_px for view in views.values()])
    reach = float((np.linalg.norm(corners - half, axis=-1) / np.linalg.norm(half)).max())
    if reach < 0.7:
        told.append(
            f"The board reaches out to {reach:.0%} of the way to the frame's corners: beyond, the distortion is extrapolated."
        )
    return tuple(told)


# ---------------------------------------------------------------- photographs


def find_boards(images: Sequence[GreyImage], board: Board) -> tuple[Board, list[BoardView | str]]:
    """Find the board in every photograph.

    Parameters
    ----------
    images
        Grey pictures (H, W), 8 bits.
    board
        What is known of the board.

    Returns
    -------
    tuple
        The board with everything found out, and for each photograph its corners, or why there are none.

    Raises
    ------
    CaptureError
        If no photograph shows a board, or all show another than the one described.
    """
    if board.kind != "chessboard":
        found = find_charuco_boards(images, board)
        if found is not None:
            return found
        if board.kind == "charuco" or board.dictionary is not None:
            raise CaptureError(
                f"No ChArUco board was found in the {len(images)} photographs. Show it whole, sharp and evenly lit, or "
                "name its marker dictionary."
            )
    return find_chessboards(images, board)


def grey_image(photograph: Photograph) -> GreyImage:
    """A photograph as the 8-bit grey picture (H, W) in which boards are looked for.

    The square root evens out noise and gives dark parts their codes; corners are saddle points, which no tone curve moves.
    """
    grey = cv2.transform(photograph.pixels, np.array([[0.25, 0.5, 0.25]], np.float32))
    white = max(float(np.percentile(grey[::4, ::4], 99.5)), 1e-12)
    np.clip(grey, 0.0, white, out=grey)
    np.sqrt(grey, out=grey)
    grey *= np.float32(255.0 / np.sqrt(white))
    return np.asarray(grey.astype(np.uint8))


def _names(paths: Sequence[Path]) -> list[str]:
    """File names, with their folders where the same name comes twice; a file given twice is refused."""
    twice = next(
        (path for path, count in Counter(path.resolve() for path in paths).items() if count > 1), None
    )
    if twice is not None:
        raise CaptureError(f"{twice.name} is given twice. Give every photograph once.")
    counts = Counter(path.name for path in paths)
    return [path.name if counts[path.name] == 1 else str(path) for path in paths]


def _check_alike(first: Photograph, photograph: Photograph) -> None:
    """All photographs must be taken with one size and one focal length."""
    height, width = first.pixels.shape[:2]
    own_height, own_width = photograph.pixels.shape[:2]
    if (own_width, own_height) != (width, height):
        turned = (own_height, own_width) == (width, height)
        advice = (
            "Hold the camera the same way up for all." if turned else "Leave it out, or take all at one size."
        )
        raise CaptureError(
            f"{photograph.path.name} is {own_width} x {own_height} pixels, but {first.path.name} is {width} x {height}. "
            f"{advice}"
        )
    if first.focal_mm and photograph.focal_mm and abs(photograph.focal_mm / first.focal_mm - 1.0) > 0.01:
        raise CaptureError(
            f"{photograph.path.name} was taken at {photograph.focal_mm:g} mm, but {first.path.name} at {first.focal_mm:g} mm. "
            "Calibrate at one setting of the zoom."
        )


# ---------------------------------------------------------------- the file


def calibration_record(calibration: CameraCalibration) -> dict[str, Any]:
    """The calibration as the tables of camera.json."""
    board = calibration.board
    return {
        "focal_px": list(calibration.focal_px),
        "principal_px": list(calibration.principal_px),
        "distortion": list(calibration.distortion),
        "image_size_px": list(calibration.image_size_px),
        "rms_px": calibration.rms_px,
        "focal_error_px": list(calibration.focal_error_px),
        "principal_error_px": list(calibration.principal_error_px),
        "board": {
            "kind": board.kind,
            "columns": board.columns,
            "rows": board.rows,
            "square_mm": None if board.square_m is None else board.square_m * 1000.0,
            "dictionary": board.dictionary,
        },
        "photos": [{"name": name, "rms_px": error} for name, error in calibration.used.items()],
        "dropped": [{"name": name, "reason": reason} for name, reason in calibration.dropped.items()],
        "warnings": list(calibration.warnings),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def write_calibration(path: Path, calibration: CameraCalibration) -> dict[str, Any]:
    """Write camera.json, whole or not at all, and return what it holds."""
    record = calibration_record(calibration)
    with written_whole(path) as temporary:
        temporary.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    return record

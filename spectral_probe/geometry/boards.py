"""Calibration boards: what is known of one, and what a photograph shows of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np
import numpy.typing as npt

from ..errors import CaptureError
from ..model import FloatArray

type GreyImage = npt.NDArray[np.uint8]

type BoardKind = Literal["auto", "chessboard", "charuco"]

BOARD_KINDS: tuple[BoardKind, ...] = ("auto", "chessboard", "charuco")
DICTIONARIES = (
    "DICT_4X4_50", "DICT_4X4_100", "DICT_4X4_250", "DICT_4X4_1000", "DICT_5X5_50", "DICT_5X5_100", "DICT_5X5_250",
    "DICT_5X5_1000", "DICT_6X6_50", "DICT_6X6_100", "DICT_6X6_250", "DICT_6X6_1000", "DICT_7X7_50", "DICT_7X7_100",
    "DICT_7X7_250", "DICT_7X7_1000", "DICT_ARUCO_ORIGINAL", "DICT_ARUCO_MIP_36h12", "DICT_APRILTAG_16h5",
    "DICT_APRILTAG_25h9", "DICT_APRILTAG_36h10", "DICT_APRILTAG_36h11",
)  # fmt: skip
"""Marker dictionaries of OpenCV; within a family the smaller come first and are the beginnings of the larger."""

SEARCH_PX = 1600
"""Longer side to which a photograph is reduced to find the board; corners are then refined at its own size."""

FEWEST_CORNERS = 12
"""Corners a photograph must show: half of them fix its pose, the others test the lens."""

FEWEST_SQUARES = 3
_SUBPIXEL_CRITERIA = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 60, 1e-4)


@dataclass(frozen=True)
class Board:
    """A calibration board; what is None is found out from the photographs.

    `columns` and `rows` count squares. `square_m` is the side of a square in metres (None: 1 is taken, which changes
    nothing of the camera), `marker_share` that of a ChArUco marker as a share of it. `legacy` is the pattern of OpenCV
    before 4.6.
    """

    kind: BoardKind = "auto"
    columns: int | None = None
    rows: int | None = None
    square_m: float | None = None
    marker_share: float | None = None
    dictionary: str | None = None
    legacy: bool = False

    def described(self) -> str:
        """The board in words.

        Examples
        --------
        >>> Board("chessboard", 9, 6).described()
        'chessboard of 9 x 6 squares'
        """
        name = "chessboard" if self.kind == "chessboard" else "ChArUco board"
        return f"{name} of {self.columns} x {self.rows} squares"


@dataclass(frozen=True)
class BoardView:
    """The corners found in one photograph.

    `corners_px` (N, 2), pixel centres at integer + 0.5; `points_m` (N, 3), the same corners on the board (z = 0).
    """

    corners_px: FloatArray
    points_m: FloatArray


def board_from(
    kind: str,
    columns: int | None,
    rows: int | None,
    square_mm: float | None,
    marker_mm: float | None,
    dictionary: str | None,
) -> Board:
    """The board as a person describes it, in millimetres; what is None is to be found out.

    Examples
    --------
    >>> board_from("charuco", 7, 5, 30.0, 21.0, "5X5_100").marker_share
    0.7

    Raises
    ------
    CaptureError
        If the description contradicts itself or is half given.
    """
    if (columns is None) != (rows is None):
        raise CaptureError("Give both the columns and the rows of the board, or neither.")
    if columns is not None and rows is not None and min(columns, rows) < FEWEST_SQUARES:
        raise CaptureError(f"A board has at least {FEWEST_SQUARES} squares each way, not {columns} x {rows}.")
    share = None
    if marker_mm is not None:
        if square_mm is None or marker_mm >= square_mm:
            raise CaptureError(
                "A marker's side needs the side of a square with it, which must be the larger."
            )
        share = marker_mm / square_mm
    if kind == "chessboard" and (marker_mm is not None or dictionary is not None):
        raise CaptureError(
            "A chessboard has no markers. Leave them out, or say that the board is a ChArUco board."
        )
    known = next(name for name in BOARD_KINDS if name == kind)
    return Board(
        known,
        columns,
        rows,
        None if square_mm is None else square_mm / 1000.0,
        share,
        None if dictionary is None else dictionary_name(dictionary),
    )


def dictionary_name(text: str) -> str:
    """The full name of a marker dictionary.

    Examples
    --------
    >>> dictionary_name("5x5_100"), dictionary_name("DICT_APRILTAG_36H11")
    ('DICT_5X5_100', 'DICT_APRILTAG_36h11')
    """
    wanted = text.strip().upper().removeprefix("DICT_")
    for name in DICTIONARIES:
        if name.upper() == f"DICT_{wanted}":
            return name
    known = ", ".join(name.removeprefix("DICT_") for name in DICTIONARIES)
    raise CaptureError(f'There is no marker dictionary "{text}". Choose one of {known}.')


# ---------------------------------------------------------------- pixels


def reduced(image: GreyImage) -> tuple[GreyImage, float]:
    """The picture no longer than `SEARCH_PX`, and its scale."""
    scale = SEARCH_PX / max(image.shape)
    if scale >= 1.0:
        return image, 1.0
    height, width = image.shape
    size = (round(width * scale), round(height * scale))
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA)), size[0] / width


def refined(image: GreyImage, corners: FloatArray, clear_px: float) -> FloatArray:
    """Corners (N, 2) moved to the saddle points of the picture, which are clear of others within half of `clear_px`."""
    half = int(np.clip(round(0.35 * clear_px), 2, 15))
    start = corners.astype(np.float32).reshape(-1, 1, 2)
    found = cv2.cornerSubPix(image, start, (half, half), (-1, -1), _SUBPIXEL_CRITERIA)
    return np.asarray(found, float).reshape(-1, 2)

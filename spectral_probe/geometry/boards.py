"""Calibration boards in photographs: chessboard corners and ChArUco corners, to a few hundredths of a pixel.

What the board is (its kind, its size, the dictionary of its markers) need not be said: the photographs show it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NoReturn

import cv2
import numpy as np
import numpy.typing as npt

from ..errors import CaptureError
from ..model import FloatArray, IntArray

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

_SINGLE = DICTIONARIES[16:]

SEARCH_PX = 1600
"""Longer side to which a photograph is reduced to find the board; corners are then refined at its own size."""

FEWEST_CORNERS = 12
"""Corners a photograph must show: half of them fix its pose, the others test the lens."""

_FEWEST_MARKERS = 6
_FEWEST_SQUARES = 3
_LEAST_SADDLE = 1.5
"""Half way between a corner of four alternating squares and the corner of a single one."""

_FIRST = 50
"""Markers of a dictionary by which it is recognised: boards number theirs from 0."""

_LAYOUT_RESIDUAL = 0.25
"""RMS in squares by which the markers' centres may miss a layout seen through a lens; a wrong layout misses by a square."""

_QUICK_SEARCH = cv2.CALIB_CB_NORMALIZE_IMAGE
_THOROUGH_SEARCH = _QUICK_SEARCH | cv2.CALIB_CB_ACCURACY | cv2.CALIB_CB_EXHAUSTIVE
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


@dataclass(frozen=True)
class Markers:
    """ArUco markers found in one photograph: `corners_px` (M, 4, 2) in OpenCV's pixel coordinates, `ids` (M,)."""

    corners_px: FloatArray
    ids: IntArray


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
    if columns is not None and rows is not None and min(columns, rows) < _FEWEST_SQUARES:
        raise CaptureError(
            f"A board has at least {_FEWEST_SQUARES} squares each way, not {columns} x {rows}."
        )
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
        found = _charuco(images, board)
        if found is not None:
            return found
        if board.kind == "charuco" or board.dictionary is not None:
            raise CaptureError(
                f"No ChArUco board was found in the {len(images)} photographs. Show it whole, sharp and evenly lit, or "
                "name its marker dictionary."
            )
    return _chessboard(images, board)


# ---------------------------------------------------------------- chessboards


def _chessboard(images: Sequence[GreyImage], board: Board) -> tuple[Board, list[BoardView | str]]:
    grids = [_corner_grid(image, None) for image in images]
    sizes = Counter(_size(grid) for grid in grids if grid is not None)
    wanted = _inner_corners(board)
    most = max(
        sizes.values(), default=0
    )  # a board cut by the frame, or by chance, may look like another in a photograph or two
    size = next(
        (s for s, count in sizes.most_common() if (wanted is None or s in wanted) and 2 * count >= most), None
    )
    if not sizes and wanted is not None:
        size = next((s for s in wanted if any(_corner_grid(image, s) is not None for image in images)), None)
    if size is None:
        _no_chessboard(len(images), sizes, board)
    found: list[BoardView | str] = []
    square_m = board.square_m or 1.0
    for image, first in zip(images, grids, strict=True):
        grid = first if first is not None and _size(first) == size else _corner_grid(image, size)
        if grid is not None:
            found.append(_grid_view(image, grid, square_m))
        elif first is None:
            found.append("no chessboard found")
        else:
            across, down = _size(first)
            found.append(f"shows {across + 1} x {down + 1} squares of the chessboard")
    told = replace(board, kind="chessboard", columns=size[0] + 1, rows=size[1] + 1)
    return told, found


def _no_chessboard(count: int, sizes: Counter[tuple[int, int]], board: Board) -> NoReturn:
    if not sizes:
        what = "board" if board.kind == "auto" else "chessboard"
        raise CaptureError(
            f"No {what} was found in the {count} photographs. Show all of it, sharp, evenly lit, and with a white margin."
        )
    across, down = sizes.most_common(1)[0][0]
    raise CaptureError(
        f"The photographs show a chessboard of {across + 1} x {down + 1} squares, not {board.columns} x {board.rows}. "
        "Give the size of that board, or none."
    )


def _inner_corners(board: Board) -> tuple[tuple[int, int], ...] | None:
    """Grids of inner corners that fit the size given: its squares', or the size itself, as OpenCV counts; None without."""
    if board.columns is None or board.rows is None:
        return None
    longer, shorter = max(board.columns, board.rows), min(board.columns, board.rows)
    return ((longer - 1, shorter - 1), (longer, shorter))


def _size(grid: FloatArray) -> tuple[int, int]:
    """Inner corners along the longer and the shorter side of a grid (rows, columns, 2)."""
    return max(grid.shape[:2]), min(grid.shape[:2])


def _corner_grid(image: GreyImage, size: tuple[int, int] | None) -> FloatArray | None:
    """Inner corners (rows, columns, 2) in OpenCV's pixel coordinates; of whatever chessboard there is without `size`."""
    small, scale = _reduced(image)
    larger = cv2.CALIB_CB_LARGER if size is None else 0
    for search in (_QUICK_SEARCH, _THOROUGH_SEARCH):
        found, corners, meta = cv2.findChessboardCornersSBWithMeta(small, size or (3, 3), search | larger)
        if found:
            break
    else:
        return None
    rows, columns = meta.shape if size is None else size[::-1]
    grid = _saddles_only(small, np.asarray(corners, float).reshape(rows, columns, 2))
    if min(grid.shape[:2]) < _FEWEST_SQUARES - 1 or (size is not None and _size(grid) != size):
        return None
    return (grid + 0.5) / scale - 0.5


def _saddles_only(image: GreyImage, grid: FloatArray) -> FloatArray:
    """The grid without outer rows and columns that are no corners of four squares.

    Where the size is not known, OpenCV lets the grid grow along the board's outer edge. There one square in four is black
    and three are margin, while at an inner corner two and two face each other: of the range of brightness around it, a
    corner's diagonals differ by twice as much.
    """
    blurred = cv2.GaussianBlur(image, (0, 0), max(0.08 * _spacing_px(grid), 0.5)).astype(np.float32)
    while min(grid.shape[:2]) >= _FEWEST_SQUARES - 1:
        saddles = _saddle_strength(blurred, grid)
        borders = [saddles[0], saddles[-1], saddles[:, 0], saddles[:, -1]]
        weakest = int(np.argmin([np.median(border) for border in borders]))
        if np.median(borders[weakest]) > _LEAST_SADDLE:
            break
        grid = (grid[1:], grid[:-1], grid[:, 1:], grid[:, :-1])[weakest]
    return grid


def _saddle_strength(image: npt.NDArray[np.float32], grid: FloatArray) -> FloatArray:
    """For each corner (rows, columns): 2 between alternating squares, 1 where one of four differs, 0 on an edge."""
    padded = grid
    for axis in (0, 1):  # the corners that the outermost squares would have
        first, second = np.take(padded, [0], axis), np.take(padded, [1], axis)
        last, before = np.take(padded, [-1], axis), np.take(padded, [-2], axis)
        padded = np.concatenate([2 * first - second, padded, 2 * last - before], axis)
    centres = (padded[:-1, :-1] + padded[:-1, 1:] + padded[1:, :-1] + padded[1:, 1:]) / 4
    squares = cv2.remap(
        image, centres.astype(np.float32), None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    around = np.stack([squares[:-1, :-1], squares[:-1, 1:], squares[1:, 1:], squares[1:, :-1]])
    span = np.ptp(around, axis=0)
    alternating = np.abs(around[0] - around[1] + around[2] - around[3])
    return np.asarray(alternating / np.maximum(span, 0.3 * np.median(span) + 1e-6))


def _grid_view(image: GreyImage, grid: FloatArray, square_m: float) -> BoardView:
    rows, columns = grid.shape[:2]
    down, across = np.mgrid[:rows, :columns].astype(float)
    points = np.stack([across, down, np.zeros_like(down)], axis=-1).reshape(-1, 3) * square_m
    return BoardView(_refined(image, grid.reshape(-1, 2), _spacing_px(grid)) + 0.5, points)


def _spacing_px(grid: FloatArray) -> float:
    """Smallest distance between neighbouring corners."""
    return min(float(np.linalg.norm(np.diff(grid, axis=axis), axis=-1).min()) for axis in (0, 1))


# ---------------------------------------------------------------- ChArUco


def _charuco(images: Sequence[GreyImage], board: Board) -> tuple[Board, list[BoardView | str]] | None:
    """As `find_boards`; None where no photograph shows markers."""
    reduced = [_reduced(image) for image in images]
    sample = [reduced[number][0] for number in sorted({0, len(images) // 2, len(images) - 1})]
    dictionary = board.dictionary or _dictionary_of(sample)
    if dictionary is None:
        return None
    seen = [_markers(image, dictionary) for image, _ in reduced]
    if max(len(markers.ids) for markers in seen) < _FEWEST_MARKERS:
        return None
    told = _with_layout(replace(board, kind="charuco", dictionary=dictionary), seen)
    detector = cv2.aruco.CharucoDetector(_opencv_board(told))
    found: list[BoardView | str] = []
    for image, (reduced_image, scale), markers in zip(images, reduced, seen, strict=True):
        if not len(markers.ids):
            found.append("no ChArUco board found")
            continue
        quads = [corners[None].astype(np.float32) for corners in markers.corners_px]
        corners, ids, _, _ = detector.detectBoard(reduced_image, markerCorners=quads, markerIds=markers.ids)
        count = 0 if ids is None else len(ids)
        if count < FEWEST_CORNERS or detector.getBoard().checkCharucoCornersCollinear(ids):
            found.append(f"{count} corners of the board found, {FEWEST_CORNERS} are needed")
            continue
        start = (np.asarray(corners, float).reshape(-1, 2) + 0.5) / scale - 0.5
        clear_px = _nearest_px(start) * (
            1.0 - (told.marker_share or 0.0)
        )  # a marker's edge must stay outside
        points = np.asarray(detector.getBoard().getChessboardCorners(), float)[ids.ravel()]
        found.append(BoardView(_refined(image, start, clear_px) + 0.5, points * (told.square_m or 1.0)))
    return told, found


def _dictionary_of(images: Sequence[GreyImage]) -> str | None:
    """The smallest dictionary that holds the markers of some photographs, the surest to tell them by; None without any."""
    families: dict[str, list[str]] = {}
    for name in DICTIONARIES:
        families.setdefault(name if name in _SINGLE else name.rpartition("_")[0], []).append(name)
    for image in images:
        counts = {family: len(_markers(image, names[0], _FIRST).ids) for family, names in families.items()}
        best = max(counts, key=lambda family: counts[family])
        if counts[best] >= _FEWEST_MARKERS:
            names = families[best]
            highest = max(int(_markers(other, names[-1]).ids.max(initial=0)) for other in images)
            return next((name for name in names if highest < _dictionary_size(name)), names[-1])
    return None


def _dictionary_size(name: str) -> int:
    return int(_opencv_dictionary(name).bytesList.shape[0])


def _markers(image: GreyImage, dictionary: str, first: int | None = None) -> Markers:
    """Markers of a dictionary, or of its `first` ones only, which is quicker."""
    whole = _opencv_dictionary(dictionary)
    some = cv2.aruco.Dictionary(whole.bytesList[:first], whole.markerSize, whole.maxCorrectionBits)
    detector = cv2.aruco.ArucoDetector(some)
    corners, ids, _ = detector.detectMarkers(image)
    if ids is None:
        return Markers(np.zeros((0, 4, 2)), np.zeros(0, int))
    return Markers(np.asarray(corners, float).reshape(-1, 4, 2), np.asarray(ids).ravel())


def _with_layout(board: Board, seen: Sequence[Markers]) -> Board:
    """The board with columns, rows, pattern and the share of its markers, from where the markers lie."""
    fullest = max(seen, key=lambda markers: len(markers.ids))
    count = 1 + max(int(markers.ids.max()) for markers in seen if len(markers.ids))
    given = None if board.columns is None or board.rows is None else (board.columns, board.rows)
    fits = [(*_fit(candidate, fullest), candidate) for candidate in _candidates(board, count)]
    residual, share, best = min(fits, key=lambda fit: fit[0], default=(np.inf, 0.0, board))
    if residual > _LAYOUT_RESIDUAL:
        raise CaptureError(
            "The markers do not lie as on a ChArUco board of one known size. Show the whole board in some photographs, or "
            "give its columns and rows."
        )
    if given is not None and {best.columns, best.rows} != set(given):
        raise CaptureError(
            f"The photographs show a {best.described()}, not {given[0]} x {given[1]}. Give the size of that board, or none."
        )
    return replace(best, marker_share=board.marker_share or share)


def _candidates(board: Board, count: int) -> list[Board]:
    """Boards with `count` markers, of either pattern, and those of the size given."""
    sizes = {
        (columns, squares // columns)
        for squares in (2 * count, 2 * count + 1)
        for columns in range(3, squares // 3 + 1)
        if squares % columns == 0
    }
    if board.columns is not None and board.rows is not None:
        sizes |= {(board.columns, board.rows), (board.rows, board.columns)}
    return [
        replace(board, columns=columns, rows=rows, legacy=legacy)
        for columns, rows in sorted(sizes)
        for legacy in (False, True)
        if columns * rows // 2 >= count
    ]


def _fit(board: Board, markers: Markers) -> tuple[float, float]:
    """How badly markers lie for a board (RMS in sides of a square), and their side as a share of a square's."""
    places = np.asarray(_opencv_board(board).getObjPoints(), float)[markers.ids, :, :2].mean(axis=1)
    homography, _ = cv2.findHomography(markers.corners_px.mean(axis=1), places)
    if homography is None:
        return np.inf, 0.0
    centres = cv2.perspectiveTransform(markers.corners_px.mean(axis=1)[None], homography)[0]
    corners = cv2.perspectiveTransform(markers.corners_px.reshape(1, -1, 2), homography).reshape(-1, 4, 2)
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1)
    residual = float(np.sqrt(((centres - places) ** 2).sum(-1).mean()))
    return residual, float(np.clip(np.median(sides), 0.1, 0.95))


def _opencv_board(board: Board) -> Any:
    """OpenCV's own board, of unit squares."""
    dictionary = _opencv_dictionary(board.dictionary or DICTIONARIES[0])
    made = cv2.aruco.CharucoBoard((board.columns, board.rows), 1.0, board.marker_share or 0.5, dictionary)
    made.setLegacyPattern(board.legacy)
    return made


def _opencv_dictionary(name: str) -> Any:
    return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))


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


def _reduced(image: GreyImage) -> tuple[GreyImage, float]:
    """The picture no longer than `SEARCH_PX`, and its scale."""
    scale = SEARCH_PX / max(image.shape)
    if scale >= 1.0:
        return image, 1.0
    height, width = image.shape
    size = (round(width * scale), round(height * scale))
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA)), size[0] / width


def _nearest_px(corners: FloatArray) -> float:
    """Smallest distance between two of the corners (N, 2)."""
    apart = np.linalg.norm(corners[:, None] - corners[None], axis=-1)
    return float(apart[~np.eye(len(corners), dtype=bool)].min())


def _refined(image: GreyImage, corners: FloatArray, clear_px: float) -> FloatArray:
    """Corners (N, 2) moved to the saddle points of the picture, which are clear of others within half of `clear_px`."""
    half = int(np.clip(round(0.35 * clear_px), 2, 15))
    start = corners.astype(np.float32).reshape(-1, 1, 2)
    refined = cv2.cornerSubPix(image, start, (half, half), (-1, -1), _SUBPIXEL_CRITERIA)
    return np.asarray(refined, float).reshape(-1, 2)

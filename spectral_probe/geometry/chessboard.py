"""Inner corners of a chessboard in photographs, its size found out or given."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import NoReturn

import cv2
import numpy as np
import numpy.typing as npt

from ..errors import CaptureError
from ..model import FloatArray
from .boards import FEWEST_SQUARES, Board, BoardView, GreyImage, reduced, refined

_LEAST_SADDLE = 1.5
"""Half way between a corner of four alternating squares and the corner of a single one."""

_QUICK_SEARCH = cv2.CALIB_CB_NORMALIZE_IMAGE
_THOROUGH_SEARCH = _QUICK_SEARCH | cv2.CALIB_CB_ACCURACY | cv2.CALIB_CB_EXHAUSTIVE


def find_chessboards(images: Sequence[GreyImage], board: Board) -> tuple[Board, list[BoardView | str]]:
    """Find a chessboard in every photograph: the board with its size, and its corners or why there are none.

    Raises
    ------
    CaptureError
        If no photograph shows one, or they show another than the one described.
    """
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
    small, scale = reduced(image)
    larger = cv2.CALIB_CB_LARGER if size is None else 0
    for search in (_QUICK_SEARCH, _THOROUGH_SEARCH):
        found, corners, meta = cv2.findChessboardCornersSBWithMeta(small, size or (3, 3), search | larger)
        if found:
            break
    else:
        return None
    rows, columns = meta.shape if size is None else size[::-1]
    grid = _saddles_only(small, np.asarray(corners, float).reshape(rows, columns, 2))
    if min(grid.shape[:2]) < FEWEST_SQUARES - 1 or (size is not None and _size(grid) != size):
        return None
    return (grid + 0.5) / scale - 0.5


def _saddles_only(image: GreyImage, grid: FloatArray) -> FloatArray:
    """The grid without outer rows and columns that are no corners of four squares.

    Where the size is not known, OpenCV lets the grid grow along the board's outer edge. There one square in four is black
    and three are margin, while at an inner corner two and two face each other: of the range of brightness around it, a
    corner's diagonals differ by twice as much.
    """
    blurred = cv2.GaussianBlur(image, (0, 0), max(0.08 * _spacing_px(grid), 0.5)).astype(np.float32)
    while min(grid.shape[:2]) >= FEWEST_SQUARES - 1:
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
    return BoardView(refined(image, grid.reshape(-1, 2), _spacing_px(grid)) + 0.5, points)


def _spacing_px(grid: FloatArray) -> float:
    """Smallest distance between neighbouring corners."""
    return min(float(np.linalg.norm(np.diff(grid, axis=axis), axis=-1).min()) for axis in (0, 1))

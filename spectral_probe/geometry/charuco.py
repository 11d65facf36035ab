"""Corners of a ChArUco board in photographs; its dictionary, size, pattern and the share of its markers found out or given."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np

from ..errors import CaptureError
from ..model import FloatArray, IntArray
from .boards import DICTIONARIES, FEWEST_CORNERS, Board, BoardView, GreyImage, reduced, refined

_SINGLE = DICTIONARIES[16:]

_FEWEST_MARKERS = 6
_FIRST = 50
"""Markers of a dictionary by which it is recognised: boards number theirs from 0."""

_LAYOUT_RESIDUAL = 0.25
"""RMS in squares by which the markers' centres may miss a layout seen through a lens; a wrong layout misses by a square."""


@dataclass(frozen=True)
class Markers:
    """ArUco markers found in one photograph: `corners_px` (M, 4, 2) in OpenCV's pixel coordinates, `ids` (M,)."""

    corners_px: FloatArray
    ids: IntArray


def find_charuco_boards(
    images: Sequence[GreyImage], board: Board
) -> tuple[Board, list[BoardView | str]] | None:
    """As `find_boards`; None where no photograph shows markers."""
    smaller = [reduced(image) for image in images]
    sample = [smaller[number][0] for number in sorted({0, len(images) // 2, len(images) - 1})]
    dictionary = board.dictionary or _dictionary_of(sample)
    if dictionary is None:
        return None
    seen = [_markers(image, dictionary) for image, _ in smaller]
    if max(len(markers.ids) for markers in seen) < _FEWEST_MARKERS:
        return None
    told = _with_layout(replace(board, kind="charuco", dictionary=dictionary), seen)
    seen = [_of_board(markers, told) for markers in seen]
    detector = cv2.aruco.CharucoDetector(_opencv_board(told))
    found: list[BoardView | str] = []
    for image, (reduced_image, scale), markers in zip(images, smaller, seen, strict=True):
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
        # The edges of the markers must stay outside of what is looked at.
        clear_px = _nearest_px(start) * (1.0 - (told.marker_share or 0.0))
        points = np.asarray(detector.getBoard().getChessboardCorners(), float)[ids.ravel()]
        found.append(BoardView(refined(image, start, clear_px) + 0.5, points * (told.square_m or 1.0)))
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
    times = Counter(int(number) for markers in seen for number in markers.ids)
    # A number seen once may be something else taken for a marker.
    count = 1 + max([number for number, count in times.items() if count > 1] or times)
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
    markers = _of_board(markers, board)
    if len(markers.ids) < _FEWEST_MARKERS:
        return np.inf, 0.0
    places = np.asarray(_opencv_board(board).getObjPoints(), float)[markers.ids, :, :2].mean(axis=1)
    homography, _ = cv2.findHomography(markers.corners_px.mean(axis=1), places)
    if homography is None:
        return np.inf, 0.0
    centres = cv2.perspectiveTransform(markers.corners_px.mean(axis=1)[None], homography)[0]
    corners = cv2.perspectiveTransform(markers.corners_px.reshape(1, -1, 2), homography).reshape(-1, 4, 2)
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1)
    # Not the median: every other row of markers fits the other pattern.
    residual = float(np.sqrt(((centres - places) ** 2).sum(-1).mean()))
    return residual, float(np.clip(np.median(sides), 0.1, 0.95))


def _nearest_px(corners: FloatArray) -> float:
    """Smallest distance between two of the corners (N, 2)."""
    apart = np.linalg.norm(corners[:, None] - corners[None], axis=-1)
    return float(apart[~np.eye(len(corners), dtype=bool)].min())


def _of_board(markers: Markers, board: Board) -> Markers:
    """Those markers that the board has."""
    own = markers.ids < len(_opencv_board(board).getIds())
    return Markers(markers.corners_px[own], markers.ids[own])


def _opencv_board(board: Board) -> Any:
    """OpenCV's own board, of unit squares."""
    dictionary = _opencv_dictionary(board.dictionary or DICTIONARIES[0])
    made = cv2.aruco.CharucoBoard((board.columns, board.rows), 1.0, board.marker_share or 0.5, dictionary)
    made.setLegacyPattern(board.legacy)
    return made


def _opencv_dictionary(name: str) -> Any:
    return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))

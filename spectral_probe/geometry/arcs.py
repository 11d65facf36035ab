"""Lines on the sphere as lines on an equirectangular picture: edges of polygons, and outlines of some of its texels.

Points of the picture are (across, up), each 0..1 from its lower left corner: those of Blender's image editor.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..model import BoolArray, FloatArray
from .frames import (
    bearing_to_direction,
    direction_to_bearing,
    direction_to_equirectangular,
    equirectangular_to_direction,
)

_OPPOSITE = 1e-9
"""Directions whose sum is a vector shorter than this lie opposite each other: no arc between them is the shortest."""


def bearing_to_picture(azimuth_deg: FloatArray | float, elevation_deg: FloatArray | float) -> FloatArray:
    """Points (..., 2) of a picture of bearings and elevations in degrees; the inverse of `picture_to_bearing`.

    Examples
    --------
    >>> bearing_to_picture(90.0, 45.0).tolist()
    [0.5, 0.75]
    """
    return _upright(direction_to_equirectangular(bearing_to_direction(azimuth_deg, elevation_deg), 1, 1))


def picture_to_bearing(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Bearings in 0..360 and elevations, in degrees, of points (..., 2) of a picture.

    Examples
    --------
    >>> [round(float(angle), 6) for angle in picture_to_bearing(np.array([0.5, 0.75]))]
    [90.0, 45.0]
    """
    return direction_to_bearing(equirectangular_to_direction(_upright(np.asarray(points, float)), 1, 1))


def _upright(points: FloatArray) -> FloatArray:
    return points * (1.0, -1.0) + (0.0, 1.0)  # rows run down, the picture's second axis up


def polygon_lines(
    corners_deg: Sequence[tuple[float, float]], *, closed: bool = True, step_deg: float = 1.0
) -> FloatArray:
    """The great circles that join corners, as short straight lines of the picture.

    Parameters
    ----------
    corners_deg
        (compass bearing, elevation) of each in degrees, one or more.
    closed
        Whether the last is joined to the first.
    step_deg
        The longest piece, as an angle on the sphere.

    Returns
    -------
    ndarray
        (N, 2, 2) the two ends of each line. A line over the picture's left or right edge is two. Neighbours that lie opposite
        each other are not joined.

    Examples
    --------
    >>> lines = polygon_lines([(260.0, 0.0), (280.0, 0.0)], closed=False, step_deg=30.0)  # over the edge, at bearing 270
    >>> lines[..., 0].round(3).tolist()
    [[0.972, 1.0], [0.0, 0.028]]
    """
    corners = bearing_to_direction(*np.array(corners_deg, float).T)
    following = np.roll(corners, -1, axis=0)
    edges = list(zip(corners, following, strict=True))
    if not closed or len(edges) < 3:
        edges = edges[:-1]
    pieces = [_arc_lines(start, end, step_deg) for start, end in edges]
    return np.concatenate([np.empty((0, 2, 2)), *pieces])


def _arc_lines(start: FloatArray, end: FloatArray, step_deg: float) -> FloatArray:
    """The shorter arc between two directions (3,)."""
    if np.linalg.norm(start + end) < _OPPOSITE:
        return np.empty((0, 2, 2))
    normal = np.cross(start, end)
    angle = float(np.arctan2(np.linalg.norm(normal), start @ end))
    if angle == 0.0:
        return np.empty((0, 2, 2))
    along = np.linspace(0.0, angle, 1 + max(1, int(np.ceil(np.degrees(angle) / step_deg))))[:, None]
    directions = (np.sin(angle - along) * start + np.sin(along) * end) / np.sin(angle)
    points = _upright(direction_to_equirectangular(directions, 1, 1))
    return _over_the_edge(np.stack([points[:-1], points[1:]], axis=1))


def _over_the_edge(lines: FloatArray) -> FloatArray:
    """Lines (N, 2, 2), each that crosses the picture's left or right edge in two."""
    leap = lines[:, 1, 0] - lines[:, 0, 0]
    over = np.abs(leap) > 0.5
    if not over.any():
        return lines
    crossing = lines[over]
    turn = np.sign(leap[over])  # 1 where the line leaves on the left, -1 where it does on the right
    unrolled = crossing[:, 1, 0] - turn
    edge = np.where(turn > 0, 0.0, 1.0)
    span = unrolled - crossing[:, 0, 0]
    share = np.where(span == 0, 0.5, (edge - crossing[:, 0, 0]) / np.where(span == 0, 1.0, span))
    height = crossing[:, 0, 1] + share * (crossing[:, 1, 1] - crossing[:, 0, 1])
    leaving = np.stack([crossing[:, 0], np.stack([edge, height], -1)], axis=1)
    entering = np.stack([np.stack([1.0 - edge, height], -1), crossing[:, 1]], axis=1)
    return np.concatenate([lines[~over], leaving, entering])


def mask_outline(mask: BoolArray) -> FloatArray:
    """Where texels inside a mask (H, W) and texels outside meet, as lines of the picture (N, 2, 2); the sides join.

    Examples
    --------
    >>> mask_outline(np.array([[False, True], [False, False]])).tolist()
    [[[0.5, 0.5], [1.0, 0.5]], [[0.5, 0.5], [0.5, 1.0]], [[1.0, 0.5], [1.0, 1.0]]]
    """
    height, width = mask.shape
    rows, columns = np.nonzero(mask[1:] != mask[:-1])
    level = 1.0 - (rows + 1) / height
    across = np.stack(
        [np.stack([columns / width, level], -1), np.stack([(columns + 1) / width, level], -1)], 1
    )
    before = np.roll(mask, 1, axis=1)
    rows, columns = np.nonzero(mask != before)
    # Between the last and the first column the line is drawn on the side that is inside.
    place = np.where((columns == 0) & before[rows, columns], width, columns) / width
    up = np.stack(
        [np.stack([place, 1.0 - (rows + 1) / height], -1), np.stack([place, 1.0 - rows / height], -1)], 1
    )
    order = np.argsort(place, kind="stable")
    return np.concatenate([across, up[order]])

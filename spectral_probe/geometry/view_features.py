"""What registration compares: one view's detail on the sphere, free of its exposure, with its gradient.

The logarithm of radiance between two blur widths (a difference of Gaussians) knows nothing of exposure or of slow
shading; divided by its own spread and compressed, it lets no lamp outweigh a room.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from ..model import FloatArray
from .frames import direction_to_equirectangular, equirectangular_to_direction, panorama_directions
from .panorama import ViewPanorama
from .sphere import blurred_where, padded, resized

_DARK = 0.03
"""Radiance, as a share of the view's median, below which differences are noise more than detail."""

_STRONG = 2.5
"""Detail beyond this many times its usual size is compressed: lamps and their edges."""

_OWN_REFLECTION_RAD = (np.radians(12.0), np.radians(22.0))
"""Towards itself a view shows the camera and who stands behind it: within the first angle nothing counts."""

_RESOLVED = 1.5
"""A direction whose pixel spans this many times the finer blur has half the weight: there the view is blurred already."""

_PADDING = 2

_COLUMNS = 1024
"""Samples are laid out in rows of this length: OpenCV's remap takes no more than 32767 in one."""


@dataclass(frozen=True)
class FeatureMap:
    """One view's detail on a panorama, continued over its edges for interpolation.

    `values` (H', W', 4) hold the detail and its gradient (3,) along the sphere, per radian; `weight` (H', W') says how much a
    direction counts; `size` is (height, width) without the continuation.
    """

    values: FloatArray
    weight: FloatArray
    size: tuple[int, int]


def feature_map(
    view: ViewPanorama, pixel_rad: float, width: int, fine_rad: float, coarse_rad: float
) -> FeatureMap:
    """Detail between two blur widths.

    Parameters
    ----------
    view
        The view's panorama, at least `width` wide.
    pixel_rad
        Angle that a pixel spans where the ball faces the camera, 2 / R for an outline of R pixels.
    width
        Width of the map in pixels.
    fine_rad, coarse_rad
        Standard deviations of both blurs, in radians.

    Returns
    -------
    FeatureMap
        Detail in units of its own usual size, so that views of unlike contrast compare.
    """
    log, weight = _logarithm(view, width, pixel_rad, fine_rad)
    detail = blurred_where(log, weight, fine_rad) - blurred_where(log, weight, coarse_rad)
    counted = weight > 0.1 * weight.max()
    size = 1.4826 * float(np.median(np.abs(detail[counted]))) if counted.any() else 1.0
    detail = detail / max(size, 1e-9)
    detail = detail / np.sqrt(1.0 + (detail / _STRONG) ** 2)
    detail -= (detail * weight).sum() / max(float(weight.sum()), 1e-9)
    values = np.dstack([detail, _gradient(detail)]).astype(np.float32)
    return FeatureMap(
        padded(values, _PADDING, _PADDING),
        padded(weight.astype(np.float32), _PADDING, _PADDING),
        (weight.shape[0], weight.shape[1]),
    )


def _logarithm(
    view: ViewPanorama, width: int, pixel_rad: float, fine_rad: float
) -> tuple[FloatArray, FloatArray]:
    """Logarithm of the mean response (H, W), and each direction's weight (H, W): less where pixels are wider than the blur."""
    mean = np.maximum(view.responses.mean(-1), 0.0)
    floor = max(_DARK * float(np.median(mean[view.seen])), 1e-30) if view.seen.any() else 1.0
    first, last = _OWN_REFLECTION_RAD
    ramp = np.clip((view.facing_rad - first) / (last - first), 0.0, 1.0)
    spread_rad = pixel_rad / np.maximum(view.cos_incidence, 1e-3)  # of a pixel, away from the camera
    weight = view.seen * ramp / (1.0 + (spread_rad / (_RESOLVED * fine_rad)) ** 2)
    both = resized(np.dstack([np.log(mean + floor), weight]).astype(np.float32), width)
    return both[..., 0], both[..., 1]


def _gradient(detail: FloatArray) -> FloatArray:
    """Gradient along the unit sphere, (H, W) -> (H, W, 3), per radian."""
    height, width = detail.shape
    around = padded(detail, 1, 1)
    northward = (around[:-2, 1:-1] - around[2:, 1:-1]) * (height / (2 * np.pi))
    westward = (around[1:-1, :-2] - around[1:-1, 2:]) * (
        width / (4 * np.pi)
    )  # longitude falls with the column
    directions = panorama_directions(height, width)
    x, y, z = np.moveaxis(directions, -1, 0)
    across = np.hypot(x, y)
    west = np.stack([-y, x, np.zeros_like(x)], axis=-1) / across[..., None]
    north = np.stack([-z * x / across, -z * y / across, across], axis=-1)
    return np.asarray(northward[..., None] * north + (westward / across)[..., None] * west)


def sample(features: FeatureMap, directions: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Detail (N,), gradient (N, 3) and weight (N,) of a map in directions (N, 3) of its own frame."""
    points = direction_to_equirectangular(directions, *features.size) + (_PADDING - 0.5)
    missing = -len(points) % _COLUMNS
    grid = np.pad(points.astype(np.float32), ((0, missing), (0, 0))).reshape(-1, _COLUMNS, 2)
    values = cv2.remap(features.values, grid, None, cv2.INTER_LINEAR).reshape(-1, 4)[: len(points)]
    weight = cv2.remap(features.weight, grid, None, cv2.INTER_LINEAR).reshape(-1)[: len(points)]
    return values[:, 0], values[:, 1:], weight


def even_directions(count: int) -> FloatArray:
    """Directions (N, 3) spread evenly over the sphere (Fibonacci's spiral).

    Examples
    --------
    >>> bool(np.abs(even_directions(1000).mean(0)).max() < 0.01)
    True
    """
    index = np.arange(count) + 0.5
    rows = np.arccos(1 - 2 * index / count) / np.pi
    columns = (index * (np.sqrt(5.0) - 1) / 2) % 1.0
    return equirectangular_to_direction(np.stack([columns, rows], axis=-1), 1, 1)

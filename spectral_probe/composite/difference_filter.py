"""Noise taken out of what objects do to the ground, without losing the edge of a shadow or its depth.

A render with and one without the objects share their samples, so their proportion is exactly one wherever no path met an object,
and much of their noise cancels in it elsewhere. What is left is noise about a change that is steep where the objects touch the
ground and ever flatter, and fainter, away from them. So each pixel gets the widest mean of its surroundings that does not
contradict a narrower one (Lepski's rule), and then the mean, over the same width, of what that left out: one mean alone would
lighten every shadow's middle and darken its surroundings. All means are of light over light, so that texture is in none of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from ..model import BoolArray, FloatArray

WIDTHS_PX = (1, 3, 5, 9, 17, 33, 65)
"""Sides of the square means, each applied twice; the first is the pixel itself."""

CONFIDENCE = {1: 3.0}
"""By side: standard errors by which a wider mean may differ and still count as the same. Light paths are no normal distribution:
single pixels stray far. Wider means that stray a little leave a slope unfinished, which the second round cannot mend wholly."""

_CONFIDENCE_WIDE = 1.5

_TWICE = 1.34
"""Standard error of a mean corrected by the mean of what it left out, over that of the mean: with k the weights of a square mean
applied twice, the root of the sum of squares of 2 k - k * k over that of k. The same within 0.001 for all sides but the first."""

_MEDIAN_PX = 3

NOISE_PX = (9, 33)
"""Sides of the surroundings in which the noise is measured; the larger of both counts, for rare bright paths may all lie outside
the smaller."""

_TINY = 1e-12


@dataclass(frozen=True)
class SmoothChange:
    """The change without its noise.

    `relative` (H, W, 3) float32; `standard_error` (H, W, 3) what is left of the noise; `width_px` (H, W) the side of the mean
    that each pixel got.
    """

    relative: FloatArray
    standard_error: FloatArray
    width_px: FloatArray


def smooth_change(relative: FloatArray, ground: FloatArray, where: BoolArray) -> SmoothChange:
    """Smooth the change that objects make on the ground.

    Parameters
    ----------
    relative
        (H, W, 3) what the objects change, over the ground without them: -1 where they leave no light.
    ground
        (H, W, 3) the ground without them: so much a pixel counts in a mean.
    where
        (H, W) pixels that show nothing but ground; others are neither read nor changed.

    Returns
    -------
    SmoothChange

    Notes
    -----
    The rule that chooses the means is Lepski's in the form of intersecting confidence intervals [1]_; the second round is Tukey's
    twicing [2]_.

    References
    ----------
    .. [1] Katkovnik, V. (1999). A new method for varying adaptive bandwidth selection. IEEE Transactions on Signal Processing,
       47(9). doi:10.1109/78.782208
    .. [2] Tukey, J. W. (1977). Exploratory Data Analysis, chapter 16. Addison-Wesley. ISBN 978-0-201-07616-5

    Examples
    --------
    >>> random = np.random.default_rng(1)
    >>> ground = np.ones((64, 64, 3), np.float32)
    >>> noisy = (-0.5 + 0.1 * random.standard_normal((64, 64, 3))).astype(np.float32)
    >>> smooth = smooth_change(noisy, ground, np.ones((64, 64), bool))
    >>> bool(np.abs(smooth.relative + 0.5).mean() < 0.01)
    True
    """
    mask = where.astype(np.float32)
    weight = np.asarray(ground * mask[..., None], np.float32)
    relative = _without_spikes(relative, mask)
    width_px, error = _widths(relative, weight, mask)
    kept: FloatArray = np.zeros_like(relative)
    for _ in range(2):
        kept = kept + _mean_of(relative - kept, weight, width_px)
    return SmoothChange(kept * mask[..., None], _TWICE * error, width_px)


def _widths(relative: FloatArray, weight: FloatArray, mask: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The side (H, W) of the mean for each pixel, and its standard error (H, W, 3)."""
    noise = _noise(relative, mask)
    spreads: list[FloatArray] = []
    widest = np.zeros(mask.shape, np.uint8)
    low: FloatArray = np.full(mask.shape, -np.inf, np.float32)
    high: FloatArray = np.full(mask.shape, np.inf, np.float32)
    growing, grey = mask > 0, np.full(3, 1 / 3, np.float32)
    for index, (side, mean) in enumerate(_means(relative, weight)):
        share = np.float32(_variance_share(side)) / np.maximum(_box(mask, side), 1e-6)
        spreads.append(np.sqrt(noise * share[..., None]))
        estimate = mean @ grey
        deviation = CONFIDENCE.get(side, _CONFIDENCE_WIDE) * (spreads[-1] @ grey)
        low, high = np.maximum(low, estimate - deviation), np.minimum(high, estimate + deviation)
        growing &= low <= high
        if not growing.any():
            break
        np.copyto(widest, np.uint8(index), where=growing)
    # A pixel that alone among its neighbours refused a wider mean strayed; an edge is refused all along.
    widest = np.maximum(widest, np.asarray(cv2.medianBlur(widest, _MEDIAN_PX), np.uint8))
    error = np.select([(widest == index)[..., None] for index in range(len(spreads))], spreads)
    return np.asarray(np.asarray(WIDTHS_PX, np.float32)[widest] * mask), np.asarray(error, np.float32)


def _means(values: FloatArray, weight: FloatArray) -> Iterator[tuple[int, FloatArray]]:
    """For each width its side and the weighted mean (H, W, 3)."""
    height, width = values.shape[:2]
    for side in WIDTHS_PX:
        if side > 1 and 2 * side > min(height, width):
            return
        total = _box(weight, side)
        yield (
            side,
            np.divide(_box(values * weight, side), total, out=np.zeros_like(values), where=total > _TINY),
        )


def _mean_of(values: FloatArray, weight: FloatArray, width_px: FloatArray) -> FloatArray:
    """The mean (H, W, 3) over each pixel's own width."""
    found: FloatArray = np.zeros_like(values)
    for side, mean in _means(values, weight):
        np.copyto(found, mean, where=(width_px == side)[..., None])
    return found


def _variance_share(side: int) -> float:
    """Variance of a square mean applied twice over that of a pixel: the sum of its squared weights.

    Examples
    --------
    >>> _variance_share(1), round(_variance_share(3), 4)  # the weights 1 2 3 2 1 along an axis
    (1.0, 0.055)
    """
    along = (2 * side**2 + 1) / (3 * side**3)
    return along**2


def _box(values: FloatArray, side: int) -> FloatArray:
    """A square mean applied twice (a pyramid), the picture continued by its mirror image."""
    if side <= 1:
        return values
    once = cv2.blur(values, (side, side), borderType=cv2.BORDER_REFLECT)
    return np.asarray(cv2.blur(once, (side, side), borderType=cv2.BORDER_REFLECT))


def _without_spikes(relative: FloatArray, mask: FloatArray) -> FloatArray:
    """Each pixel brought between the least and the greatest of its eight neighbours: what a single path brought to one alone."""
    around = np.ones((3, 3), np.uint8)
    around[1, 1] = 0
    own = np.asarray(relative * mask[..., None], np.float32)
    return np.clip(own, cv2.erode(own, around), cv2.dilate(own, around))


def _noise(relative: FloatArray, mask: FloatArray) -> FloatArray:
    """Variance (H, W, 3) of the relative change of a pixel, from how neighbours differ.

    The mixed second difference is blind to slopes and to straight edges along the axes, and nearly so to those of a shadow.
    """
    kernel = np.outer([1.0, -2.0, 1.0], [1.0, -2.0, 1.0]).astype(np.float32) / 6.0
    rough = cv2.filter2D(relative, cv2.CV_32F, kernel, borderType=cv2.BORDER_REFLECT)
    whole = cv2.erode(mask, np.ones((3, 3), np.uint8), borderValue=1.0)
    size = np.abs(rough) * whole[..., None]
    near, far = (np.maximum(_box(whole, side), 1e-6)[..., None] for side in NOISE_PX)
    usual = np.float32(np.pi / 2) * np.square(_box(size, NOISE_PX[0]) / near)
    return np.asarray(np.maximum(usual, _box(np.square(size), NOISE_PX[1]) / far))

"""Noise taken out of the difference that objects make on the ground, without losing the edge of a shadow.

A render with and one without the objects share their samples, so their difference is exactly zero wherever no path met an
object. Elsewhere it is noise about a difference that is steep where the objects touch the ground and ever flatter, and fainter,
away from them. So each pixel gets the widest mean of its surroundings that does not contradict a narrower one (Lepski's rule).
The mean is of the difference *relative* to the ground, whose texture therefore stays.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from ..model import BoolArray, FloatArray

WIDTHS_PX = (1, 3, 5, 9, 17, 33, 65)
"""Sides of the square means, each applied twice; the first is the pixel itself."""

CONFIDENCE = {1: 6.0, 3: 3.5}
"""By side: standard errors by which a wider mean may differ and still count as the same. Light paths are no normal distribution:
single pixels, and means of few, stray far."""

_CONFIDENCE_WIDE = 2.0

NOISE_PX = (9, 33)
"""Sides of the surroundings in which the noise is measured; the larger of both counts, for rare bright paths may all lie outside
the smaller."""

_TEXTURE_PX = 9
_TEXTURE_DEPTH = 0.002
"""Contrast (relative to the ground, squared) of the plate below which the ground is taken as without texture."""

_TINY = 1e-12

type _Planes = tuple[FloatArray, FloatArray]


@dataclass(frozen=True)
class SmoothDifference:
    """The difference without its noise.

    `difference` (H, W, 3) float32; `standard_error` (H, W, 3) what is left of the noise; `width_px` (H, W) the side of the mean
    that each pixel got; `ground` (H, W, 3) the ground without its noise.
    """

    difference: FloatArray
    standard_error: FloatArray
    width_px: FloatArray
    ground: FloatArray


def smooth_difference(
    difference: FloatArray, ground: FloatArray, plate: FloatArray, where: BoolArray
) -> SmoothDifference:
    """Smooth the difference that objects make on the ground.

    Parameters
    ----------
    difference
        (H, W, 3) render with the objects less the one without.
    ground
        (H, W, 3) the render without them.
    plate
        (H, W, 3) the photograph: where the render shows its texture, the difference has that texture too.
    where
        (H, W) pixels that show nothing but ground; others are neither read nor changed.

    Returns
    -------
    SmoothDifference

    Notes
    -----
    The rule that chooses the means is Lepski's in the form of intersecting confidence intervals [1]_. The share of the plate's
    texture in the ground is a guided filter [2]_.

    References
    ----------
    .. [1] Katkovnik, V. (1999). A new method for varying adaptive bandwidth selection. IEEE Transactions on Signal Processing,
       47(9). doi:10.1109/78.782208
    .. [2] He, K., Sun, J., & Tang, X. (2013). Guided Image Filtering. IEEE TPAMI, 35(6). doi:10.1109/TPAMI.2012.213

    Examples
    --------
    >>> random = np.random.default_rng(1)
    >>> ground = np.ones((64, 64, 3), np.float32)
    >>> noisy = (-0.5 + 0.1 * random.standard_normal((64, 64, 3))).astype(np.float32)
    >>> smooth = smooth_difference(noisy, ground, ground, np.ones((64, 64), bool))
    >>> bool(np.abs(smooth.difference + 0.5).max() < 0.03)
    True
    """
    mask = where.astype(np.float32)
    texture = _textured(ground, plate, mask)
    difference = _without_spikes(difference, mask)
    # Least squares of the difference on the ground: sums of products over sums of squares.
    weight = np.square(texture) * mask[..., None]
    product = difference * texture * mask[..., None]
    noise = _noise(difference, texture, mask)
    kept: FloatArray = np.where(where[..., None], difference, 0).astype(np.float32)
    error: FloatArray = np.zeros_like(kept)
    width_px: FloatArray = np.where(where, 1, 0).astype(np.float32)
    low: FloatArray = np.full(mask.shape, -np.inf, np.float32)
    high: FloatArray = np.full(mask.shape, np.inf, np.float32)
    growing = where.copy()
    for side, mean, share in _means(product, weight, mask):
        spread = np.sqrt(noise * share[..., None])
        estimate, deviation = mean.mean(-1), CONFIDENCE.get(side, _CONFIDENCE_WIDE) * spread.mean(-1)
        low, high = np.maximum(low, estimate - deviation), np.minimum(high, estimate + deviation)
        growing &= low <= high
        if not growing.any():
            break
        taken = growing[..., None]
        np.copyto(kept, mean * texture, where=taken)
        np.copyto(error, spread * texture, where=taken)
        np.copyto(width_px, np.float32(side), where=growing)
    return SmoothDifference(kept, error, width_px, texture)


def _means(
    product: FloatArray, weight: FloatArray, mask: FloatArray
) -> Iterator[tuple[int, FloatArray, FloatArray]]:
    """For each width: its side, the relative difference (H, W, 3), and the variance of the mean over that of one pixel."""
    height, width = mask.shape
    for side in WIDTHS_PX:
        if side > 1 and 2 * side > min(height, width):
            return
        total = _box(weight, side)
        mean = np.divide(_box(product, side), total, out=np.zeros_like(product), where=total > _TINY)
        seen = np.maximum(_box(mask, side), 1e-6)
        yield side, mean, np.float32(_variance_share(side)) / seen


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


def _textured(ground: FloatArray, plate: FloatArray, mask: FloatArray) -> FloatArray:
    """The ground (H, W, 3) without its noise: locally the plate times a factor plus a constant, as far as the two go together."""
    seen = np.maximum(_box(mask, _TEXTURE_PX), 1e-6)[..., None]
    cover = mask[..., None]

    def mean(values: FloatArray) -> FloatArray:
        return _box(np.ascontiguousarray(values * cover, np.float32), _TEXTURE_PX) / seen

    shown, guide = mean(ground), mean(plate)
    together = mean(ground * plate) - shown * guide
    alone = mean(np.square(plate)) - np.square(guide)
    factor = together / (alone + np.float32(_TEXTURE_DEPTH) * np.square(guide) + np.float32(_TINY))
    textured = mean(factor) * plate + mean(shown - factor * guide)
    # Twice the mean, or a tenth of it, is as far as a texture is believed: beyond are lamps and their reflections.
    return np.asarray(np.clip(textured, 0.1 * np.maximum(shown, 0), 2.0 * np.maximum(shown, 0)), np.float32)


def _without_spikes(difference: FloatArray, mask: FloatArray) -> FloatArray:
    """Each pixel brought between the least and the greatest of its eight neighbours: what a single path brought to one alone."""
    around = np.ones((3, 3), np.uint8)
    around[1, 1] = 0
    own = np.asarray(difference * mask[..., None], np.float32)
    return np.clip(own, cv2.erode(own, around), cv2.dilate(own, around))


def _noise(difference: FloatArray, texture: FloatArray, mask: FloatArray) -> FloatArray:
    """Variance (H, W, 3) of the relative difference of a pixel, from how neighbours differ.

    The mixed second difference is blind to slopes and to straight edges along the axes, and nearly so to those of a shadow.
    """
    relative = np.divide(difference, texture, out=np.zeros_like(difference), where=texture > _TINY)
    relative *= mask[..., None]
    kernel = np.outer([1.0, -2.0, 1.0], [1.0, -2.0, 1.0]).astype(np.float32) / 6.0
    rough = cv2.filter2D(relative, cv2.CV_32F, kernel, borderType=cv2.BORDER_REFLECT)
    whole = cv2.erode(mask, np.ones((3, 3), np.uint8), borderValue=1.0)
    size = np.abs(rough) * whole[..., None]
    near, far = (np.maximum(_box(whole, side), 1e-6)[..., None] for side in NOISE_PX)
    usual = np.float32(np.pi / 2) * np.square(_box(size, NOISE_PX[0]) / near)
    return np.asarray(np.maximum(usual, _box(np.square(size), NOISE_PX[1]) / far))

"""A bracket of photographs merged into radiance, weighted by how much each pixel's noise lets it say."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from ..errors import PhotographError
from ..model import Exposure, FloatArray, Photograph, RadianceImage

FULL_WELL_ELECTRONS = 30000.0
"""Electrons at saturation and ISO 100; ISO 200 saturates at half. Cameras lie between 15,000 and 80,000."""

READ_NOISE = 2.0e-4
"""Read noise (standard deviation) as a share of saturation: some 3 levels of 14 bits, 6 electrons at ISO
100."""

TONE_CURVE_ERROR = 0.05
"""Relative error of a display-referred value in mid-tones, where sRGB is close to an in-camera tone curve."""

ROWS_AT_ONCE = 256


def merge(photographs: Iterable[Photograph], exposures: Sequence[Exposure]) -> RadianceImage:
    """Merge aligned photographs into relative radiance, one photograph at a time.

    With x = radiance times relative exposure t, every unclipped photograph is an estimate x / t of variance
    s^2(x) / t^2; the inverse variances are the weights. The variance is computed from the running estimate of
    the radiance and not from the photograph's own noisy value, which would favour values that are too low.

    Parameters
    ----------
    photographs
        Photographs of one size, aligned; an iterator that reads them on demand keeps the memory small.
    exposures
        One per photograph.

    Returns
    -------
    RadianceImage
        Radiance (H, W, 3) per unit of relative exposure, and its variance. Where every photograph is
        clipped, `valid` is False, the radiance the highest lower bound, and the variance infinite.

    Notes
    -----
    The noise model is shot noise plus read noise [1]_ with a typical sensor's constants; for display-referred
    photographs quantisation and the unknown tone curve take their place.

    References
    ----------
    .. [1] Hanji, P., Zhong, F., & Mantiuk, R. K. (2020). Noise-Aware Merging of High Dynamic Range Image
       Stacks without Camera Calibration. ECCV Workshops. doi:10.1007/978-3-030-67070-2_23
    """
    weighted: FloatArray | None = None
    weights: FloatArray | None = None
    first = ""
    for photograph, exposure in zip(photographs, exposures, strict=True):
        if weighted is None or weights is None:
            weighted = np.zeros(photograph.pixels.shape, np.float32)
            weights = np.zeros(photograph.pixels.shape, np.float32)
            first = photograph.path.name
        if photograph.pixels.shape != weighted.shape:
            raise PhotographError(
                f"{photograph.path.name} and {first} have different sizes. Use photographs of one bracket."
            )
        for start in range(0, len(weighted), ROWS_AT_ONCE):
            rows = slice(start, start + ROWS_AT_ONCE)
            _add(weighted[rows], weights[rows], photograph, rows, exposure)
    if weighted is None or weights is None:
        raise PhotographError("The view has no photographs. List them as photos in the capture file.")
    seen = weights > 0.0
    valid = seen.all(axis=-1)
    np.divide(weighted, weights, out=weighted, where=seen)
    variance = np.full_like(weights, np.inf)
    np.divide(1.0, weights, out=variance, where=seen)
    return RadianceImage(weighted, variance, valid)


def _add(
    weighted: FloatArray, weights: FloatArray, photograph: Photograph, rows: slice, exposure: Exposure
) -> None:
    """Add some rows of one photograph to the sums.

    Where nothing unclipped has come yet, `weighted` holds the lower bound instead of a sum.
    """
    import cv2

    relative = exposure.relative
    estimate = photograph.pixels[rows] / np.float32(relative)
    clipped = photograph.clipped[rows][..., None]
    unseen = weights <= 0.0
    running = np.where(unseen, estimate, weighted / np.where(unseen, 1.0, weights))
    # Averaged over neighbours: a weight that follows a pixel's own noise favours errors in one direction.
    running = cv2.blur(running, (5, 5), borderType=cv2.BORDER_REPLICATE)
    variance = _variance(running * np.float32(relative), photograph, exposure) / np.float32(relative**2)
    weight = np.where(clipped, 0.0, 1.0 / variance)
    np.maximum(weighted, estimate, out=weighted, where=unseen & clipped)
    np.copyto(weighted, 0.0, where=unseen & ~clipped)
    weighted += np.where(clipped, 0.0, weight * estimate)
    weights += weight


def _variance(values: FloatArray, photograph: Photograph, exposure: Exposure) -> FloatArray:
    """Variance of a photograph's values (any shape, 1 = saturation)."""
    level = np.maximum(values, 0.0)
    if photograph.scene_referred_float:
        # Radiance has no known noise: a relative error, so that equal pictures count equally.
        return (0.01 * level) ** 2 + READ_NOISE**2
    shot = level * np.float32(exposure.iso / (100.0 * FULL_WELL_ELECTRONS))
    if not photograph.display_referred:
        return np.asarray(shot + np.float32(READ_NOISE**2))
    return _display_variance(np.minimum(level, 1.0)) + shot


def _display_variance(level: FloatArray) -> FloatArray:
    """Variance of an sRGB-decoded value: 8-bit steps, and a camera's tone curve that sRGB only resembles.

    The tone curve's error grows towards both ends: in-camera curves lift or crush shadows (below about 5 %)
    and roll off highlights (above about 60 %).
    """
    slope = np.where(
        level <= 0.0031308, 1.0 / 12.92, 2.4 / 1.055 * np.maximum(level, 0.0031308) ** (1.4 / 2.4)
    )
    quantisation = (slope / 255.0) ** 2  # a code's width; twelve times the ideal 1/12, for JPEG's own losses
    ends = 1.0 + (0.05 / np.maximum(level, 1e-4)) + 4.0 * np.maximum(level - 0.6, 0.0)
    return np.asarray(quantisation + (TONE_CURVE_ERROR * level * ends) ** 2, np.float32)

"""From tristimulus values to pixels on a screen: one exposure and one view transform for all pictures.

Up to the knee the transform is exact sRGB, so that colours can be compared; only highlights are rolled off.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from ..errors import FileFormatError
from ..files.atomic import written_whole
from ..large import TEXELS_A_STRIP, strips
from ..model import BoolArray, FloatArray, IntArray

KNEE = 0.8
"""Linear display value from which highlights are rolled off."""

type Picture = npt.NDArray[np.uint8]


def exposure_for_white(white_luminance: float) -> float:
    """The exposure that shows a luminance as the last tone below the knee.

    Examples
    --------
    >>> exposure_for_white(4.0)
    0.2
    """
    return KNEE / white_luminance


def exposure_for_key(luminance: FloatArray, valid: BoolArray, weights: FloatArray | None = None) -> float:
    """The exposure that brings the typical luminance of a scene with lamps in it to a middle grey.

    Parameters
    ----------
    luminance
        (H, W).
    valid
        (H, W) the pixels that count.
    weights
        (H, W) their weights, such as solid angles; by default all the same.

    Returns
    -------
    float
        0.18 over the weighted median of the luminances above zero: lamps, however bright, do not move it.
        1 for a black picture.
    """
    counted = valid & (luminance > 0)
    if not counted.any():
        return 1.0
    weight = np.broadcast_to(
        np.ones((1, 1), luminance.dtype) if weights is None else weights, luminance.shape
    )
    before = None
    if luminance.size > TEXELS_A_STRIP:  # sorting all would take eight times their memory
        before, counted = _about_median(luminance, counted, weight)
    values, shares = luminance[counted], weight[counted]
    order = np.argsort(values)
    cumulative = np.cumsum(shares[order], dtype=float)
    half = cumulative[-1] / 2 if before is None else before
    median = values[order][min(int(np.searchsorted(cumulative, half)), len(order) - 1)]
    return 0.18 / float(median)


def _about_median(luminance: FloatArray, counted: BoolArray, weight: FloatArray) -> tuple[float, BoolArray]:
    """Of positive float32 luminances: which lie near the weighted median (H, W), and how much of their weight lies before it.

    Positive floats are in the order of their bits, so the upper 16 sort them into bins without sorting them.
    """
    sums = np.zeros(1 << 16)
    blocks = strips(*luminance.shape)

    def bins(rows: slice) -> IntArray:
        return np.ascontiguousarray(luminance[rows], np.float32).view(np.uint32) >> 16

    for rows in blocks:
        which = counted[rows]
        sums += np.bincount(bins(rows)[which], weights=weight[rows][which], minlength=len(sums))
    cumulative = np.cumsum(sums)
    half = float(cumulative[-1] / 2)
    chosen = int(np.searchsorted(cumulative, half))
    near = np.zeros(luminance.shape, bool)
    for rows in blocks:
        near[rows] = counted[rows] & (bins(rows) == chosen)
    return half - float(cumulative[chosen] - sums[chosen]), near


def tone_map(xyz: FloatArray, exposure: float) -> Picture:
    """Tristimulus values to sRGB pixels.

    Parameters
    ----------
    xyz
        (..., 3) tristimulus values, D65 is neutral.
    exposure
        Factor that scales them to linear display values, where 1 is the screen's white.

    Returns
    -------
    ndarray
        (..., 3) uint8. Values that are not finite are black.

    Notes
    -----
    Colours outside the gamut of sRGB move towards the grey of their luminance until they are inside. Above
    the knee of 0.8 the largest channel approaches 1 exponentially; hue is kept, and saturation falls with
    every stop above it.

    Examples
    --------
    >>> white = np.array([0.9505, 1.0, 1.0891])
    >>> tone_map(white, 0.18).tolist(), bool((tone_map(white, 1000.0) >= 254).all())
    ([118, 118, 118], True)
    """
    from ..spectra.colorimetry import xyz_to_rec709  # seconds, which developing a photograph does without

    finite = np.where(np.isfinite(xyz).all(-1, keepdims=True), xyz, 0.0).astype(np.float32)
    rgb = xyz_to_rec709(finite * np.float32(exposure))
    luminance = np.maximum(finite[..., 1:2] * np.float32(exposure), 0)
    rgb = into_gamut(rgb, luminance)
    peak = rgb.max(-1, keepdims=True)
    rolled = np.where(
        peak > KNEE, 1 - (1 - KNEE) * np.exp((KNEE - np.maximum(peak, KNEE)) / (1 - KNEE)), peak
    )
    shown = rgb * (rolled / np.where(peak > 0, peak, 1))
    whiteness = 1 - np.exp2(-np.maximum(np.log2(np.maximum(peak, KNEE) / KNEE), 0) / 3)
    shown = shown + (rolled - shown) * whiteness
    return np.asarray(np.rint(srgb_encoded(np.clip(shown, 0, 1)) * 255), np.uint8)


def write_png(path: Path, picture: Picture, *, quick: bool = False) -> None:
    """Write sRGB pixels (H, W, 3) uint8 as PNG; `quick` is several times faster, and the file somewhat larger."""
    from PIL import Image

    with written_whole(path) as temporary:
        Image.fromarray(np.ascontiguousarray(picture), "RGB").save(
            temporary, format="PNG", optimize=not quick, compress_level=2
        )


def read_png(path: Path) -> Picture:
    """Read an sRGB picture (H, W, 3), such as `write_png` wrote.

    Raises
    ------
    FileFormatError
        If there is no such picture.
    """
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(path) as image:
            return np.asarray(image.convert("RGB"))
    except (OSError, UnidentifiedImageError, Image.DecompressionBombError, ValueError, SyntaxError):
        raise FileFormatError(
            f"There is no picture {path}, or it cannot be read. Compare the renders again."
        ) from None


def into_gamut(rgb: FloatArray, luminance: FloatArray) -> FloatArray:
    """Negative channels lifted to 0 by mixing with grey of the same luminance."""
    lowest = rgb.min(-1, keepdims=True)
    distance = luminance - lowest
    keep = np.where(lowest < 0, luminance / np.where(distance > 0, distance, 1), 1)
    return np.asarray(np.maximum(luminance + (rgb - luminance) * keep, 0))


def srgb_encoded(linear: FloatArray) -> FloatArray:
    """IEC 61966-2-1 encoding of linear values in 0..1."""
    return np.asarray(
        np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055)
    )

"""A spectral and an RGB render as pictures: one exposure and one view transform for both, and both in one with a divider."""

from __future__ import annotations

import numpy as np

from ..model import FloatArray
from ..render.compare import Comparison
from ..spectra.colorimetry import adapted_to_d65
from .display import Picture, exposure_for_white, tone_map

_LIGHT, _DARK = 255, 40


def shown_pair(
    comparison: Comparison,
    xyz_spectral: FloatArray,
    xyz_rgb: FloatArray,
    adapted_white: FloatArray | None = None,
) -> tuple[Picture, Picture]:
    """The two renders (H, W, 3) as sRGB pictures, exposed for the white of their comparison.

    `adapted_white` is the XYZ (3,) of the light that the eye is adapted to: both are white-balanced to it.
    """
    exposure = exposure_for_white(float(comparison.white_xyz[1]))
    balanced = [
        xyz if adapted_white is None else adapted_to_d65(xyz, adapted_white)
        for xyz in (xyz_spectral, xyz_rgb)
    ]
    return tone_map(balanced[0], exposure), tone_map(balanced[1], exposure)


def wipe_picture(left: Picture, right: Picture, split: float = 0.5) -> Picture:
    """One picture of two (H, W, 3): the first up to a share of the width, the second from there on, a divider between.

    Beside the divider, a light line between two dark ones, every pixel is that of its picture.

    Examples
    --------
    >>> black, white = np.zeros((1, 9, 3), np.uint8), np.full((1, 9, 3), 255, np.uint8)
    >>> wipe_picture(black, white, 0.5)[0, :, 0].tolist()
    [0, 0, 0, 40, 255, 40, 255, 255, 255]
    """
    width = left.shape[1]
    column = int(np.clip(round(split * width), 0, width))
    wiped = np.concatenate([left[:, :column], right[:, column:]], axis=1)
    if 0 < column < width:
        half = max(width // 1200, 0)  # of the light line
        wiped[:, max(column - half - 1, 0) : column + half + 2] = _DARK
        wiped[:, max(column - half, 0) : column + half + 1] = _LIGHT
    return wiped

"""How noisy a render is, measured against a converged render of the same kind.

Noise is split into what changes a pixel's luminance and what changes its colour at its luminance. With tristimulus
values relative to a D65 white (X/Xn, Y, Z/Zn), t of the noisy and c of the converged image,

    luminance noise = (t_Y - c_Y) / c_Y,
    chroma noise    = |(t_X - c_X t_Y / c_Y, t_Z - c_Z t_Y / c_Y)| / c_Y:

a pixel that is only too bright or too dark has no chroma noise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import FileFormatError
from ..model import FloatArray
from ..spectra.colorimetry import white_xyz

_DARK = 0.02
"""Luminance, relative to the converged image's 95th percentile, below which a pixel's relative noise is not counted."""


@dataclass(frozen=True)
class Noise:
    """Noise of a render relative to luminance.

    Parameters
    ----------
    luminance_rms
        Root mean square of the luminance noise.
    luminance_median
        Median of its magnitude: without the fireflies.
    chroma_rms, chroma_p95
        Root mean square and 95th percentile of the chroma noise.
    """

    luminance_rms: float
    luminance_median: float
    chroma_rms: float
    chroma_p95: float


def noise(xyz: FloatArray, converged: FloatArray) -> Noise:
    """Noise of an image (H, W, 3) of tristimulus values against a converged one; pixels darker than 2 % of white are left out.

    Raises
    ------
    FileFormatError
        If the images differ in size or the converged one is black.

    Examples
    --------
    >>> converged = np.ones((2, 2, 3)) * white_xyz()
    >>> measured = noise(converged * np.array([1.1, 0.9])[:, None], converged)
    >>> round(measured.luminance_rms, 3), round(measured.chroma_p95, 3)
    (0.1, 0.0)
    """
    if xyz.shape != converged.shape:
        raise FileFormatError(
            "The noisy and the converged image differ in size. Render them in one resolution."
        )
    measured, truth = (np.asarray(image, float) / white_xyz() for image in (xyz, converged))
    luminance = truth[..., 1]
    bright = luminance > _DARK * np.percentile(luminance, 95)
    if not bright.any():
        raise FileFormatError("The converged image is black. Render it with more light.")
    measured, truth, luminance = measured[bright], truth[bright], luminance[bright]
    relative = measured[:, 1] / luminance
    shifted = (measured - truth * relative[:, None])[:, [0, 2]] / luminance[:, None]
    chroma = np.linalg.norm(shifted, axis=-1)
    return Noise(
        luminance_rms=float(np.sqrt(((relative - 1) ** 2).mean())),
        luminance_median=float(np.median(np.abs(relative - 1))),
        chroma_rms=float(np.sqrt((chroma**2).mean())),
        chroma_p95=float(np.percentile(chroma, 95)),
    )

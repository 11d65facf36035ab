"""Reflectance spectra from RGB: a linear basis of three primaries that sum to one.

Mallett & Yuksel, "Spectral Primary Decomposition for Rendering with sRGB Reflectance", EGSR 2019
(doi:10.2312/sr.20191216), as distributed by colour-science. White stays white and RGB in 0..1 gives
reflectances in 0..1.

The basis was made for 380-780 nm, where sRGB colours come back under D65 to dE2000 0.01. On our grid, 400-700 nm, the light
beyond is missing: a thousand random colours come back to 0.03 in the mean and 0.17 at most, white taken for white.
"""

from __future__ import annotations

from functools import cache

from ..model import FloatArray
from .colorimetry import on_grid
from .colour_science import colour


@cache
def reflectance_basis() -> FloatArray:
    """The three reflectance primaries, (61, 3), summing to one at every wavelength.

    Examples
    --------
    >>> reflectance_basis().sum(-1).round(6).min().item(), reflectance_basis().sum(-1).round(6).max().item()
    (1.0, 1.0)
    """
    basis = on_grid(colour.recovery.MSDS_BASIS_FUNCTIONS_sRGB_MALLETT2019)
    basis = basis / basis.sum(-1, keepdims=True)  # the table is rounded: restore its partition of unity
    basis.flags.writeable = False
    return basis


def uplift(rgb: FloatArray) -> FloatArray:
    """Reflectance spectra of linear Rec.709 colours, (..., 3) -> (..., 61)."""
    return rgb @ reflectance_basis().T.astype(rgb.dtype)

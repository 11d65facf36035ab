"""Spectra of light that is known by its colour only: lamps, emitting materials, worlds and skies of an RGB scene.

A colour is taken as the sum of three spectra, one unit of which has exactly the tristimulus values of a Rec.709 primary: in a
spectral render the light looks as it does in RGB.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from ..errors import SpectralDataError
from ..model import FloatArray
from .colorimetry import illuminant, on_grid, rec709_to_xyz, spectra_to_xyz
from .colour_science import colour
from .uplift import reflectance_basis


@cache
def rgb_illuminants() -> FloatArray:
    """Spectral radiance per nm of one unit of red, green and blue light, (3, 61), in the unit of image.exr.

    D65 times the reflectance primaries of Mallett & Yuksel 2019 (doi:10.2312/sr.20191216), mixed so that the tristimulus
    values are exact; white is D65.

    Examples
    --------
    >>> bool(np.allclose(spectra_to_xyz(rgb_illuminants()), rec709_to_xyz(np.eye(3))))
    True
    """
    return _as_primaries(reflectance_basis().T * illuminant("D65"))


@cache
def rgb_daylights() -> FloatArray:
    """The same for light of the sky, (3, 61): combinations of the mean and the two variations S0, S1, S2 of CIE daylight.

    Their sum for a colour on the daylight locus is that phase of daylight. Single channels have negative parts. Judd,
    MacAdam & Wyszecki, J. Opt. Soc. Am. 54, 1031 (1964), doi:10.1364/JOSA.54.001031.

    Examples
    --------
    >>> from .library import daylight
    >>> from .colorimetry import xyz_to_rec709
    >>> phase = daylight(9000.0)
    >>> mixed = xyz_to_rec709(spectra_to_xyz(phase)) @ rgb_daylights()
    >>> bool(np.abs(mixed - phase).max() < 0.01)
    True
    """
    parts = colour.colorimetry.SDS_BASIS_FUNCTIONS_CIE_ILLUMINANT_D_SERIES
    return _as_primaries(np.stack([on_grid(part) for part in parts.values()]))


def of_unit_luminance(spectrum: FloatArray) -> FloatArray:
    """A spectrum (61,) scaled to luminance 1: the sum over nm of it times y-bar.

    Raises
    ------
    SpectralDataError
        If it is dark to the eye.

    Examples
    --------
    >>> float(spectra_to_xyz(of_unit_luminance(illuminant("FL11")))[1].round(12))
    1.0
    """
    luminance = float(spectra_to_xyz(np.asarray(spectrum, float))[1])
    if not luminance > 0:
        raise SpectralDataError(
            "The lamp's spectrum has no luminance within 400-700 nm. Choose another spectrum."
        )
    return np.asarray(spectrum, float) / luminance


def radiance_of_unit_luminance() -> float:
    """Spectral radiance per nm of equal-energy light of luminance 1: what turns a Rec.709 value into about a radiance.

    Examples
    --------
    >>> round(1 / radiance_of_unit_luminance(), 1)
    106.8
    """
    return float(1.0 / spectra_to_xyz(np.ones(61))[1])


def _as_primaries(spectra: FloatArray) -> FloatArray:
    """The three mixtures of spectra (3, 61) whose tristimulus values are those of the Rec.709 primaries."""
    mixed: FloatArray = rec709_to_xyz(np.eye(3)) @ np.linalg.inv(spectra_to_xyz(spectra)) @ spectra
    mixed.flags.writeable = False
    return mixed

"""How well one spectrum fits another: goodness of fit, relative RMSE, correlated colour temperature."""

from __future__ import annotations

import numpy as np

from ..model import FloatArray
from .colorimetry import spectra_to_xyz
from .colour_science import colour
from .grid import WAVELENGTHS_NM, resample


def goodness_of_fit(estimated: FloatArray, measured: FloatArray) -> FloatArray:
    """Goodness-of-fit coefficient: the cosine between two spectra, 1 for the same shape whatever the level.

    Parameters
    ----------
    estimated, measured
        (..., L) spectra on the same wavelengths.

    Returns
    -------
    ndarray
        (...) in -1..1; 0 where one of the spectra is black.

    Notes
    -----
    Defined by Romero, Garcia-Beltran & Hernandez-Andres, "Linear bases for representation of natural and
    artificial illuminants", J. Opt. Soc. Am. A 14, 1007 (1997). Hernandez-Andres, Romero, Nieves & Lee,
    "Color and spectral analysis of daylight in southern Europe", J. Opt. Soc. Am. A 18, 1325 (2001), call a
    fit good from 0.999 and excellent from 0.9999.

    Examples
    --------
    >>> float(goodness_of_fit(np.array([2.0, 4.0]), np.array([1.0, 2.0])).round(6))
    1.0
    >>> float(goodness_of_fit(np.array([1.0, 0.0]), np.array([1.0, 1.0])).round(4))
    0.7071
    """
    estimated, measured = np.asarray(estimated, float), np.asarray(measured, float)
    lengths = np.linalg.norm(estimated, axis=-1) * np.linalg.norm(measured, axis=-1)
    product = (estimated * measured).sum(-1)
    return np.asarray(np.where(lengths > 0, product / np.where(lengths > 0, lengths, 1.0), 0.0))


def relative_rmse(estimated: FloatArray, measured: FloatArray, *, same_energy: bool = True) -> FloatArray:
    """Root-mean-square difference of two spectra over the root mean square of the measured one.

    Parameters
    ----------
    estimated, measured
        (..., L) spectra on the same wavelengths.
    same_energy
        Scale the estimate to the measured spectrum's sum first, so that only the shape counts.

    Returns
    -------
    ndarray
        (...), 0 for a perfect fit; not a number where the measured spectrum is black.

    Examples
    --------
    >>> float(relative_rmse(np.array([2.0, 4.0]), np.array([1.0, 2.0])))
    0.0
    >>> float(relative_rmse(np.array([2.0, 4.0]), np.array([1.0, 2.0]), same_energy=False))
    1.0
    """
    estimated, measured = np.asarray(estimated, float), np.asarray(measured, float)
    if same_energy:
        estimated = scaled_to_energy(estimated, measured)
    level = np.linalg.norm(measured, axis=-1)
    error = np.linalg.norm(estimated - measured, axis=-1)
    return np.asarray(np.where(level > 0, error / np.where(level > 0, level, 1.0), np.nan))


def scaled_to_energy(spectra: FloatArray, reference: FloatArray) -> FloatArray:
    """Spectra (..., L) scaled to the sum of the reference (..., L); those without energy stay as they are."""
    total = np.asarray(spectra, float).sum(-1, keepdims=True)
    wanted = np.asarray(reference, float).sum(-1, keepdims=True)
    return np.asarray(spectra * np.where(total > 0, wanted / np.where(total > 0, total, 1.0), 1.0))


def colour_temperature(
    spectrum: FloatArray, wavelengths_nm: FloatArray = WAVELENGTHS_NM
) -> tuple[float, float] | None:
    """Correlated colour temperature in kelvin and distance Duv from the Planckian locus of one spectrum (L,).

    By Ohno, "Practical use and calculation of CCT and Duv", Leukos 10, 47 (2014), as colour-science has it.

    Returns
    -------
    tuple or None
        (kelvin, Duv); None where the light is black, or farther than 0.05 from the locus, where the CIE
        defines no correlated colour temperature.

    Notes
    -----
    From 400-700 nm only: what lies outside moves CIE illuminant A by +8 K and D65 by less than 1 K. Spectra
    that are compared are cut alike.

    Examples
    --------
    >>> kelvin, duv = colour_temperature(np.ones(61))  # equal energy
    >>> round(kelvin), round(duv, 4)
    (5456, -0.0042)
    """
    xyz = spectra_to_xyz(resample(np.asarray(wavelengths_nm), np.asarray(spectrum, float)))
    if not xyz[1] > 0:
        return None
    uv = colour.UCS_to_uv(colour.XYZ_to_UCS(xyz / xyz[1]))
    kelvin, duv = (float(value) for value in colour.temperature.uv_to_CCT_Ohno2013(uv))
    return (kelvin, duv) if abs(duv) <= 0.05 else None

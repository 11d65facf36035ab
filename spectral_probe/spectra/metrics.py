"""How well one spectrum fits another: goodness of fit, relative RMSE, colour temperature, colour differences, rendering.

Everything is computed from 400-700 nm, of spectra that are compared alike.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from ..model import FloatArray
from .colorimetry import chromaticity, delta_e_2000, spectra_to_xyz
from .colour_science import colour
from .grid import WAVELENGTHS_NM, resample
from .library import surface_reflectances
from .metals import metal_reflectance

COMPARED_METALS = ("Au", "Ag", "Cu")
"""Metals whose colour under the estimated and under the measured light is compared: gold, silver, copper."""

_LIGHT_LUMINANCE = 0.6  # of a light whose colour is compared, relative to the white
_RENDERING_NM = np.arange(380.0, 781.0, 5.0)


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
    if not (np.isfinite(xyz).all() and xyz[1] > 0):
        return None
    uv = colour.UCS_to_uv(colour.XYZ_to_UCS(xyz / xyz[1]))
    try:
        with _doubts_as_errors():
            kelvin, duv = (float(value) for value in colour.temperature.uv_to_CCT_Ohno2013(uv))
    except (colour.utilities.ColourRuntimeWarning, RuntimeWarning):  # beyond the table of the locus
        return None
    return (kelvin, duv) if abs(duv) <= 0.05 else None


@contextmanager
def _doubts_as_errors() -> Iterator[None]:
    """Where colour-science doubts its own result inside the block, it raises; what it says of its own tables is dropped."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", colour.utilities.ColourRuntimeWarning)
        warnings.simplefilter("error", RuntimeWarning)
        warnings.filterwarnings("ignore", message='Aligning "')
        yield


# ---------------------------------------------------------------- differences that an eye sees


def light_difference(estimated: FloatArray, measured: FloatArray) -> FloatArray:
    """CIEDE2000 between the colours of two lights at the same luminance: what their shapes, not their levels, differ by.

    Parameters
    ----------
    estimated, measured
        (..., 61) spectra. Both are scaled to Y = 0.6 of a white of the chromaticity of D65 (0.3127, 0.3290).

    Returns
    -------
    ndarray
        (...); not a number where a light is black.

    Examples
    --------
    >>> light = np.linspace(1.0, 2.0, 61)
    >>> round(float(light_difference(3 * light, light)), 6)
    0.0
    """
    both = (_at_luminance(light) * _LIGHT_LUMINANCE for light in (estimated, measured))
    return np.asarray(colour.delta_E(*(colour.XYZ_to_Lab(xyz) for xyz in both), method="CIE 2000"))


def surface_differences(estimated: FloatArray, measured: FloatArray, reflectances: FloatArray) -> FloatArray:
    """CIEDE2000 of surfaces under two lights of the same luminance, for an eye adapted to the measured one.

    Parameters
    ----------
    estimated, measured
        (61,) spectra of the lights.
    reflectances
        (N, 61).

    Returns
    -------
    ndarray
        (N,); not a number where a light is black, or lacks one of X, Y, Z as a single red line does. A perfect diffuser
        differs by the colours of the two lights.
    """
    lights = np.stack([_scaled_to_luminance(estimated), _scaled_to_luminance(measured)])
    xyz = spectra_to_xyz(lights[:, None] * reflectances)
    white = spectra_to_xyz(lights[1])
    if not (np.isfinite(lights).all() and (white > 0).all()):
        return np.full(len(reflectances), np.nan)
    return delta_e_2000(xyz[0], xyz[1], white)


def _at_luminance(spectra: FloatArray) -> FloatArray:
    """Tristimulus values (..., 3) of spectra (..., 61) scaled to Y = 1; not a number where they are black."""
    xyz = spectra_to_xyz(np.asarray(spectra, float))
    luminance = xyz[..., 1:2]
    return np.asarray(np.where(luminance > 0, xyz / np.where(luminance > 0, luminance, 1.0), np.nan))


def _scaled_to_luminance(spectrum: FloatArray) -> FloatArray:
    luminance = spectra_to_xyz(np.asarray(spectrum, float))[1]
    return np.asarray(spectrum, float) / luminance if luminance > 0 else np.full(len(spectrum), np.nan)


@cache
def _metals() -> FloatArray:
    """Reflectances (3, 61) of `COMPARED_METALS` at normal incidence."""
    return np.stack([metal_reflectance(name, np.array(1.0)) for name in COMPARED_METALS])


# ---------------------------------------------------------------- all the numbers of a light, and of two


@dataclass(frozen=True)
class LightNumbers:
    """Numbers of one light. Those that are not defined for it are None.

    Parameters
    ----------
    xy
        Chromaticity, CIE 1931 2 degree observer.
    cct_kelvin, duv
        `colour_temperature`.
    ra
        CIE general colour rendering index (CIE 13.3-1995).
    rf, rg
        Colour fidelity and gamut index of ANSI/IES TM-30-18.
    """

    xy: tuple[float, float] | None
    cct_kelvin: float | None = None
    duv: float | None = None
    ra: float | None = None
    rf: float | None = None
    rg: float | None = None


def light_numbers(spectrum: FloatArray, wavelengths_nm: FloatArray = WAVELENGTHS_NM) -> LightNumbers:
    """Chromaticity, colour temperature and colour rendering of a light, (L,) on wavelengths that cover 400-700 nm.

    Notes
    -----
    The rendering indices are defined on 380-780 nm; beyond 400 and 700 nm the light is taken to be what it is there. For the
    107 lights of the library known on 380-780 nm that changes Ra by at most 0.27, Rf by 0.12 and Rg by 0.07 (zeros
    there: 0.45, 0.47, 0.16). They are None where there is no colour temperature: no reference light is defined then.

    Examples
    --------
    >>> from .colorimetry import illuminant
    >>> fluorescent = light_numbers(illuminant("FL11"))
    >>> round(fluorescent.cct_kelvin), round(fluorescent.ra), round(fluorescent.rf)
    (4000, 83, 80)
    """
    light = resample(np.asarray(wavelengths_nm), np.asarray(spectrum, float))
    xyz = spectra_to_xyz(light)
    if not (np.isfinite(xyz).all() and xyz[1] > 0):
        return LightNumbers(None)
    x, y = (float(value) for value in chromaticity(xyz))
    temperature = colour_temperature(light)
    if temperature is None:
        return LightNumbers((x, y))
    return LightNumbers((x, y), *temperature, _rendering_index(light), *_fidelity(light))


def _distribution(light: FloatArray) -> Any:
    wide = np.interp(_RENDERING_NM, WAVELENGTHS_NM, light)
    return colour.SpectralDistribution(wide, _RENDERING_NM, name="light")


def _rendering_index(light: FloatArray) -> float | None:
    try:
        with _doubts_as_errors():
            return _finite(colour.colour_rendering_index(_distribution(light)))
    except (colour.utilities.ColourRuntimeWarning, RuntimeWarning):
        return None


def _fidelity(light: FloatArray) -> tuple[float | None, float | None]:
    try:
        with _doubts_as_errors():
            found = colour.colour_fidelity_index(
                _distribution(light), method="ANSI/IES TM-30-18", additional_data=True
            )
    except (colour.utilities.ColourRuntimeWarning, RuntimeWarning):
        return None, None
    return _finite(found.R_f), _finite(found.R_g)


@dataclass(frozen=True)
class SpectrumComparison:
    """An estimated spectrum against a measured one. What is not defined, such as of black light, is None.

    Parameters
    ----------
    estimated, measured
        The numbers of each.
    gfc
        `goodness_of_fit`.
    relative_rmse
        `relative_rmse` at the same energy.
    delta_cct_kelvin
        CCT of the estimate less that of the measured light.
    de2000_light
        `light_difference`.
    de2000_colorchecker, de2000_metals
        (mean, largest) `surface_differences` of the 24 patches of the ColorChecker, and of gold, silver and copper at
        normal incidence.
    """

    estimated: LightNumbers
    measured: LightNumbers
    gfc: float | None
    relative_rmse: float | None
    delta_cct_kelvin: float | None
    de2000_light: float | None
    de2000_colorchecker: tuple[float, float] | None
    de2000_metals: tuple[float, float] | None


def compare_spectra(
    estimated: FloatArray, measured: FloatArray, wavelengths_nm: FloatArray = WAVELENGTHS_NM
) -> SpectrumComparison:
    """All the numbers of an estimated spectrum (L,) against a measured one (L,), both on the same wavelengths.

    Examples
    --------
    >>> from .colorimetry import illuminant
    >>> compared = compare_spectra(2 * illuminant("D65"), illuminant("D50"))
    >>> round(compared.gfc, 3), round(compared.delta_cct_kelvin, -1), round(compared.de2000_light, 1)
    (0.981, 1500.0, 11.3)
    """
    known = np.asarray(wavelengths_nm)
    estimate, truth = (resample(known, np.asarray(light, float)) for light in (estimated, measured))
    ours, theirs = light_numbers(estimate), light_numbers(truth)
    both = ours.cct_kelvin is not None and theirs.cct_kelvin is not None
    return SpectrumComparison(
        estimated=ours,
        measured=theirs,
        gfc=None if ours.xy is None or theirs.xy is None else _finite(goodness_of_fit(estimate, truth)),
        relative_rmse=_finite(relative_rmse(estimate, truth)),
        delta_cct_kelvin=ours.cct_kelvin - theirs.cct_kelvin if both else None,  # type: ignore[operator]  # both are numbers
        de2000_light=_finite(light_difference(estimate, truth)),
        de2000_colorchecker=_mean_and_largest(surface_differences(estimate, truth, surface_reflectances())),
        de2000_metals=_mean_and_largest(surface_differences(estimate, truth, _metals())),
    )


def _mean_and_largest(differences: FloatArray) -> tuple[float, float] | None:
    if not np.isfinite(differences).all():
        return None
    return float(differences.mean()), float(differences.max())


def _finite(value: Any) -> float | None:
    return float(value) if np.isfinite(value) else None

"""The lights that may be in the scene, by lamp family: the training set of the spectral basis (eq. 7).

Measured lights are those colour-science carries (CIE illuminants, RIT and NIST light sources); Planck radiators and
the CIE daylight series are computed.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np

from ..errors import SpectralDataError
from ..model import FloatArray
from .colorimetry import illuminant, on_grid
from .colour_science import colour
from .grid import WAVELENGTHS_NM

FAMILIES: Mapping[str, tuple[str, ...]] = {
    "incandescent": ("A", "SA", "Incandescent", "Neodimium Incandescent", "60 A/W (Soft White)"),
    "daylight": ("B", "C", "D50", "D55", "D60", "D65", "D75", "ID65", "ID50", "SC"),
    "fluorescent-halophosphate": (
        "FL1", "FL2", "FL3", "FL4", "FL5", "FL6", "FL3.1", "FL3.2", "FL3.3", "Cool White FL", "Daylight FL",
        "F34/CW/RS/EW (Cool White FL)", "F34T12/LW/RS/EW", "F34T12WW/RS/EW (Warm White FL)",
    ),
    "fluorescent-broadband": (
        "FL7", "FL8", "FL9", "FL3.4", "FL3.5", "FL3.6", "FL3.12", "FL3.13", "FL3.14", "FL3.15", "Natural",
        "Thorn Kolor-rite", "F40/C50 (Broadband FL)", "F40/C75 (Broadband FL)", "F40/CWX (Broadband FL)",
        "F40/DX (Broadband FL)", "F40/DXTP (Delux FL)", "F40/N (Natural FL)",
    ),
    "fluorescent-triband": (
        "FL10", "FL11", "FL12", "FL3.7", "FL3.8", "FL3.9", "FL3.10", "FL3.11", "Philips TL-84",
        "T8 Luxline Plus White", "T8 Polylux 3000", "T8 Polylux 4000", "Triphosphor FL",
        "F32T8/TL830 (Triphosphor)", "F32T8/TL835 (Triphosphor)", "F32T8/TL841 (Triphosphor)",
        "F32T8/TL850 (Triphosphor)", "F32T8/TL865/PLUS (Triphosphor)",
    ),
    "led-phosphor": (
        "LED-B1", "LED-B2", "LED-B3", "LED-B4", "LED-B5", "LED-BH1", "LED-V1", "LED-V2", "Luxeon WW 2880",
        "PHOS-1", "PHOS-2", "PHOS-3", "PHOS-4", "Phosphor LED YAG",
    ),
    "led-rgb": (
        "LED-RGB1", "3-LED-1 (457/540/605)", "3-LED-2 (473/545/616)", "3-LED-2 Yellow",
        "3-LED-3 (465/546/614)", "3-LED-4 (455/547/623)", "4-LED No Yellow", "4-LED Yellow",
        "4-LED-1 (461/526/576/624)", "4-LED-2 (447/512/573/627)",
    ),
    "discharge": (
        "HP1", "HP2", "HP3", "HP4", "HP5", "HPS", "LPS", "Mercury", "Metal Halide", "Super HPS",
        "C100S54 (HPS)", "C100S54C (HPS)", "H38HT-100 (Mercury)", "H38JA-100/DX (Mercury DX)",
        "MHC100/U/MP/3K", "MHC100/U/MP/4K", "SDW-T 100W/LV (Super HPS)", "Kinoton 75P",
    ),
}  # fmt: skip
"""Lamp families, and the lights of colour-science that belong to each."""

AUTOMATIC = "automatic"
"""The word that stands for every family."""

_PLANCK_KELVIN = tuple(range(2000, 3700, 100))
_DAYLIGHT_KELVIN = (*range(4000, 8000, 250), 8000, 8500, 9000, 10000, 12000, 15000, 20000)


def check_families(families: Sequence[str]) -> tuple[str, ...]:
    """The families asked for, "automatic" spelt out.

    Raises
    ------
    SpectralDataError
        If a family is unknown or none is given; the message suggests the nearest.

    Examples
    --------
    >>> check_families(["daylight"])
    ('daylight',)
    """
    if not families:
        raise SpectralDataError(f"Name at least one lamp family: {', '.join(FAMILIES)}.")
    for family in families:
        if family not in FAMILIES and family != AUTOMATIC:
            near = difflib.get_close_matches(family, FAMILIES, n=1, cutoff=0.4)
            hint = f'Did you mean "{near[0]}"? ' if near else ""
            raise SpectralDataError(
                f'There is no lamp family "{family}". {hint}Known are {", ".join(FAMILIES)}.'
            )
    return tuple(FAMILIES) if AUTOMATIC in families else tuple(dict.fromkeys(families))


def planck(temperature_kelvin: float, wavelengths_nm: FloatArray = WAVELENGTHS_NM) -> FloatArray:
    """Relative spectral radiance of a black body, 1 at 560 nm, (L,).

    Examples
    --------
    >>> float(planck(2856.0)[32])
    1.0
    """
    second_radiation_constant = 1.438776877e7  # nm K, CODATA 2018

    def radiance(nm: FloatArray) -> FloatArray:
        return nm**-5.0 / np.expm1(second_radiation_constant / (nm * temperature_kelvin))

    return radiance(np.asarray(wavelengths_nm, float)) / float(radiance(np.array(560.0)))


def daylight(correlated_temperature_kelvin: float, wavelengths_nm: FloatArray = WAVELENGTHS_NM) -> FloatArray:
    """Relative spectral power of CIE daylight of a correlated colour temperature in 4000-25000 K, 1 at 560 nm, (L,).

    Wavelengths are 360-830 nm.
    """
    xy = colour.temperature.CCT_to_xy_CIE_D(correlated_temperature_kelvin)
    series = colour.sd_CIE_illuminant_D_series(xy, shape=colour.SpectralShape(360, 830, 5))
    known, values = np.asarray(series.wavelengths, float), np.asarray(series.values, float)
    power = np.interp(wavelengths_nm, known, values)
    return np.asarray(power / np.interp(560.0, known, values))


_COMPUTED = re.compile(r"(planck|daylight)\s*(\d+(?:\.\d+)?)\s*k?", re.IGNORECASE)
_DAYLIGHT_RANGE_KELVIN = (4000.0, 25000.0)
_PLANCK_RANGE_KELVIN = (500.0, 100000.0)


def lamp_names() -> tuple[str, ...]:
    """Names of the lights that were measured or tabulated; "Planck 3200 K" and "Daylight 6500 K" are computed as well.

    Examples
    --------
    >>> "FL11" in lamp_names(), len(lamp_names()) > 100
    (True, True)
    """
    names = (*colour.SDS_ILLUMINANTS, *colour.SDS_LIGHT_SOURCES)
    return tuple(name for name in names if name != "ISO 7589 Sensitometric Printer")  # it ends at 560 nm


def lamp_spectrum(name: str) -> FloatArray:
    """Relative spectral power of a lamp by name, (61,), 1 at 560 nm (peak 1 where that is dark).

    Parameters
    ----------
    name
        One of `lamp_names`, capitals or not; "Planck 3200 K" for a black body; "Daylight 6500 K" for the CIE daylight of
        a correlated colour temperature.

    Raises
    ------
    SpectralDataError
        If there is no such lamp, or the temperature is out of range; the message suggests the nearest name.

    Examples
    --------
    >>> bool(abs(lamp_spectrum("Planck 2856 K") - lamp_spectrum("A")).max() < 2e-3)
    True
    """
    computed = _COMPUTED.fullmatch(name.strip())
    if computed:
        kelvin, is_planck = float(computed[2]), computed[1].lower() == "planck"
        first, last = _PLANCK_RANGE_KELVIN if is_planck else _DAYLIGHT_RANGE_KELVIN
        if not first <= kelvin <= last:
            raise SpectralDataError(
                f"{computed[1].title()} of {kelvin:g} K is not defined here. Give {first:g} to {last:g} K."
            )
        return planck(kelvin) if is_planck else daylight(kelvin)
    by_lower = {known.lower(): known for known in lamp_names()}
    if name.lower() not in by_lower:
        near = difflib.get_close_matches(name.lower(), by_lower, n=1, cutoff=0.4)
        hint = f'Did you mean "{by_lower[near[0]]}"? ' if near else ""
        raise SpectralDataError(
            f'There is no lamp called "{name}" in the library. {hint}'
            'Others are computed: "Planck 3200 K", "Daylight 6500 K".'
        )
    return _unit(illuminant(by_lower[name.lower()]))


def training_lights(families: Sequence[str]) -> FloatArray:
    """Spectra of every light of the lamp families, (N, 61), each 1 at 560 nm (peak 1 where that is dark)."""
    return np.concatenate([_family(family) for family in check_families(families)])


@cache
def _family(family: str) -> FloatArray:
    lights = [_unit(illuminant(name)) for name in FAMILIES[family]]
    if family == "incandescent":
        lights += [planck(kelvin) for kelvin in _PLANCK_KELVIN]
    elif family == "daylight":
        lights += [daylight(kelvin) for kelvin in _DAYLIGHT_KELVIN]
    return np.stack(lights)


def _unit(spectrum: FloatArray) -> FloatArray:
    """A spectrum scaled to 1 at 560 nm, or to a peak of 1 where it is dark there."""
    at_560 = float(np.interp(560.0, WAVELENGTHS_NM, spectrum))
    peak = float(spectrum.max())
    return spectrum / (at_560 if at_560 > 0.02 * peak else peak)


@cache
def surface_reflectances() -> FloatArray:
    """Reflectances of the 24 patches of the ColorChecker (Ohta), (24, 61): the surfaces that light is reflected by."""
    patches = colour.SDS_COLOURCHECKERS["ColorChecker N Ohta"]
    return np.stack([on_grid(patch) for patch in patches.values()])

"""A stated white, to which a picture is adapted: by name, correlated colour temperature or chromaticity."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from ..errors import SpectralDataError
from ..model import FloatArray
from .colorimetry import adapted_to_d65, illuminant, spectra_to_xyz
from .colour_science import colour

ADAPTATION = "CAT16"
"""Chromatic adaptation transform (Li et al., Comprehensive color solutions: CAM16, CAT16, and CAM16-UCS, Color Research &
Application 42(6), 2017, doi:10.1002/col.22131), complete adaptation."""

_NUMBER = r"\d*\.?\d+"
_KELVIN = re.compile(rf"\s*({_NUMBER})\s*K\s*", re.IGNORECASE)
_NOTE = re.compile(rf"adapted from white (.+?) \(x ({_NUMBER}), y ({_NUMBER})\) to D65")
_XY = re.compile(rf"\s*({_NUMBER})\s*[,;\s]\s*({_NUMBER})\s*")
_DAYLIGHT_FROM_K = 4000.0
_COLDEST_K, _HOTTEST_K = 1667.0, 25000.0


@dataclass(frozen=True)
class White:
    """A white as it was stated, and its chromaticity (2,)."""

    stated: str
    xy: tuple[float, float]

    @property
    def note(self) -> str:
        """A sentence for headers and reports."""
        x, y = self.xy
        return f"adapted from white {self.stated} (x {x:.4f}, y {y:.4f}) to D65 by {ADAPTATION}"

    def adapted(self, xyz: FloatArray) -> FloatArray:
        """Tristimulus values (..., 3) as under D65; the luminance of the white stays."""
        x, y = self.xy
        return adapted_to_d65(xyz, np.array([x / y, 1.0, (1.0 - x - y) / y]))


def parse_white(text: str) -> White | None:
    """The white that a text states; None for an empty text: no adaptation.

    Parameters
    ----------
    text
        A CIE illuminant or light source of the library ("A", "D50", "FL2"), a correlated colour temperature ("5000 K":
        the daylight locus from 4000 K up, the Planckian locus below), or a chromaticity "x,y".

    Raises
    ------
    SpectralDataError
        If it is none of these.

    Examples
    --------
    >>> parse_white("5000 K").xy
    (0.3457, 0.3587)
    >>> parse_white("0.4476, 0.4074").xy
    (0.4476, 0.4074)
    >>> parse_white("") is None
    True
    """
    stated = text.strip()
    if not stated:
        return None
    if match := _KELVIN.fullmatch(stated):
        return White(stated, _rounded(_of_temperature(float(match[1]))))
    if match := _XY.fullmatch(stated):
        x, y = float(match[1]), float(match[2])
        if not (0 < x < 1 and 0 < y < 1 and x + y < 1):
            raise SpectralDataError(f'"{stated}" is no chromaticity: x, y and x + y lie between 0 and 1.')
        return White(stated, (x, y))
    try:
        xyz = spectra_to_xyz(illuminant(stated))
    except SpectralDataError:
        raise SpectralDataError(
            f'There is no white called "{stated}". Give an illuminant such as A or D50, a temperature such as 5000 K, or x,y.'
        ) from None
    return White(stated, _rounded(xyz[:2] / xyz.sum()))


def white_of_note(text: str) -> White | None:
    """The white that a header's note says a picture was adapted from; None where it says none.

    Examples
    --------
    >>> white = parse_white("A")
    >>> white_of_note(f"scene-linear ACEScg; {white.note}") == white
    True
    >>> white_of_note("scene-linear ACEScg; no chromatic adaptation") is None
    True
    """
    found = _NOTE.search(text)
    return None if found is None else White(found[1], (float(found[2]), float(found[3])))


def _rounded(xy: FloatArray) -> tuple[float, float]:
    """Four digits, as chromaticities are quoted."""
    return round(float(xy[0]), 4), round(float(xy[1]), 4)


def _of_temperature(kelvin: float) -> FloatArray:
    if not _COLDEST_K <= kelvin <= _HOTTEST_K:
        raise SpectralDataError(
            f"A white of {kelvin:g} K is out of range. Give {_COLDEST_K:.0f} to {_HOTTEST_K:.0f} K."
        )
    if kelvin >= _DAYLIGHT_FROM_K:
        return np.asarray(colour.temperature.CCT_to_xy_CIE_D(kelvin))
    return np.asarray(colour.temperature.CCT_to_xy_Kang2002(kelvin))

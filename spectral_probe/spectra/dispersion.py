"""Refractive indices of clear glasses over wavelength: by page of refractiveindex.info, or by a formula's coefficients."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence

import numpy as np

from ..errors import SpectralDataError
from ..model import FloatArray
from .grid import WAVELENGTHS_NM
from .refractive import is_page_name, optical_constants

CLEAR_PAGES: Mapping[str, str] = {
    "BK7": "popular_glass/BK7/SCHOTT",
    "SF10": "popular_glass/SF10/SCHOTT",
    "SF11": "popular_glass/SF11/SCHOTT",
    "fused silica": "main/SiO2/Malitson",
    "water": "main/H2O/Daimon-20.0C",
    "diamond": "main/C/Phillip",
    "sapphire": "main/Al2O3/Malitson-o",
}
"""Clear materials by the names people use, and their pages."""


def page_index(name: str, wavelengths_nm: FloatArray = WAVELENGTHS_NM) -> FloatArray:
    """Refractive index n (L,) of a clear material: one of `CLEAR_PAGES` or a page "shelf/book/page".

    Raises
    ------
    SpectralDataError
        If there is no such material; the message suggests the nearest.

    Examples
    --------
    >>> float(page_index("BK7", np.array([587.6]))[0].round(4))
    1.5168
    """
    page = name.strip().rpartition(": ")[2]
    if not is_page_name(page):
        by_name = {known.casefold(): known for known in CLEAR_PAGES}
        known = by_name.get(page.casefold())
        if known is None:
            near = difflib.get_close_matches(page.casefold(), by_name, n=1, cutoff=0.5)
            hint = f'Did you mean "{by_name[near[0]]}"? ' if near else ""
            raise SpectralDataError(
                f'There is no clear material called "{name}". {hint}Known are {", ".join(CLEAR_PAGES)}; others by their page '
                "of refractiveindex.info, shelf/book/page."
            )
        page = CLEAR_PAGES[known]
    return optical_constants(page, np.asarray(wavelengths_nm, float))[0]


def cauchy_index(coefficients: Sequence[float], wavelengths_nm: FloatArray = WAVELENGTHS_NM) -> FloatArray:
    """Refractive index by Cauchy's formula, n = A + B / um^2 + C / um^4, of coefficients (A, B, C).

    Raises
    ------
    SpectralDataError
        If the index falls below 1 in 400-700 nm.

    Examples
    --------
    >>> float(cauchy_index((1.5046, 0.0042, 0.0), np.array([500.0]))[0].round(4))
    1.5214
    """
    square = (np.asarray(wavelengths_nm, float) / 1000.0) ** 2
    a, b, c = coefficients
    return _possible(a + b / square + c / square**2, "Cauchy")


def sellmeier_index(
    strengths: Sequence[float], resonances_um2: Sequence[float], wavelengths_nm: FloatArray = WAVELENGTHS_NM
) -> FloatArray:
    """Refractive index by Sellmeier's formula, n^2 = 1 + sum of B um^2 / (um^2 - C), C in square micrometres.

    Raises
    ------
    SpectralDataError
        If it has a resonance within 400-700 nm or gives an index below 1 there.

    Examples
    --------
    >>> schott_bk7 = (1.03961212, 0.231792344, 1.01046945), (0.00600069867, 0.0200179144, 103.560653)
    >>> float(sellmeier_index(*schott_bk7, np.array([587.6]))[0].round(4))
    1.5168
    """
    square = (np.asarray(wavelengths_nm, float) / 1000.0) ** 2
    first, last = (WAVELENGTHS_NM[[0, -1]] / 1000.0) ** 2
    if any(b and first <= c <= last for b, c in zip(strengths, resonances_um2, strict=True)):
        raise SpectralDataError(
            "The Sellmeier coefficients have a resonance within 400-700 nm. Give C in square micrometres."
        )
    total = 1.0 + sum(b * square / (square - c) for b, c in zip(strengths, resonances_um2, strict=True))
    return _possible(np.sqrt(np.maximum(total, 0.0)), "Sellmeier")


def _possible(n: FloatArray, formula: str) -> FloatArray:
    if not (np.isfinite(n).all() and n.min() >= 1.0 and n.max() < 6.0):
        raise SpectralDataError(
            f"The {formula} coefficients give a refractive index of {n.min():.3g} to {n.max():.3g}. "
            "Give those for wavelengths in micrometres."
        )
    return np.asarray(n)


def internal_transmittance(transmittance: FloatArray, n: FloatArray) -> FloatArray:
    """Transmittance of a pane without its two surfaces, from that with them, at normal incidence.

    Both surfaces reflect R = ((n - 1) / (n + 1))^2, over and over: T = (1 - R)^2 t / (1 - R^2 t^2), solved for t.

    Parameters
    ----------
    transmittance
        (L,) of the whole pane.
    n
        (L,) or a number: its refractive index.

    Examples
    --------
    >>> clear = (1 - 0.04) ** 2 / (1 - 0.04**2)  # a pane of index 1.5 that absorbs nothing
    >>> float(internal_transmittance(np.array([clear]), np.array(1.5))[0].round(9))
    1.0
    """
    reflected = ((n - 1.0) / (n + 1.0)) ** 2
    square = reflected**2
    through = (1.0 - reflected) ** 2
    total = np.asarray(transmittance, float)
    inner = 2.0 * total / (through + np.sqrt(through**2 + 4.0 * square * total**2))
    return np.asarray(np.clip(inner, 0.0, 1.0))

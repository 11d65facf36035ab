"""Metals: complex refractive indices by name, Fresnel reflectance, and the reflectance of the ball (eq. 11).

The defaults are Johnson & Christy where they measured a metal: one laboratory for all metals of the paper. Any other page
of refractiveindex.info goes by its own name, "shelf/book/page" (`refractive`).
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ..errors import SpectralDataError
from ..files.spectrum_file import is_spectrum_file
from ..model import FloatArray
from .grid import WAVELENGTHS_NM
from .measured_ball import measured_ball_reflectance
from .refractive import optical_constants

METAL_PAGES: Mapping[str, str] = {
    "Ag": "main/Ag/Johnson",
    "Al": "main/Al/Rakic",
    "Au": "main/Au/Johnson",
    "Cr": "main/Cr/Johnson",
    "Cu": "main/Cu/Johnson",
    "Fe": "main/Fe/Johnson",
    "Hg": "main/Hg/Inagaki",
    "Ni": "main/Ni/Johnson",
    "Pt": "main/Pt/Rakic-BB",
    "Ti": "main/Ti/Johnson",
    "TiN": "main/TiN/Beliaev-sputtering",
    "W": "main/W/Weaver",
    "Zn": "main/Zn/Querry",
    "brass": "other/Cu-Zn/Querry-Cu70Zn30",
    "stainless steel": "other/stainless_steel/Karlsson-austenitic",
}
"""Page of refractiveindex.info behind each metal's symbol or name."""

METAL_NAMES: Mapping[str, str] = {
    "Ag": "Silver", "Al": "Aluminium", "Au": "Gold", "Cr": "Chromium", "Cu": "Copper", "Fe": "Iron", "Hg": "Mercury",
    "Ni": "Nickel", "Pt": "Platinum", "Ti": "Titanium", "TiN": "Titanium nitride", "W": "Tungsten", "Zn": "Zinc",
    "brass": "Brass", "stainless steel": "Stainless steel",
}  # fmt: skip
"""English name of each metal, by symbol."""

BALL_MATERIALS: Mapping[str, Mapping[str, float]] = {
    "SUS304": {"Fe": 0.74, "Cr": 0.18, "Ni": 0.08},
    "stainless steel": {"stainless steel": 1.0},
    "chrome": {"Cr": 1.0},
    "silver": {"Ag": 1.0},
    "aluminium": {"Al": 1.0},
    "ideal": {},
}
"""Fractions of metals in the balls known by name; an ideal ball reflects everything."""


def refractive_index(name: str, wavelengths_nm: FloatArray = WAVELENGTHS_NM) -> tuple[FloatArray, FloatArray]:
    """Complex refractive index n + ik of a metal.

    Parameters
    ----------
    name
        A symbol of `METAL_PAGES`, an English name, or "shelf/book/page" of refractiveindex.info.
    wavelengths_nm
        (L,) wavelengths.

    Returns
    -------
    n, k
        (L,) each, dimensionless.

    Raises
    ------
    SpectralDataError
        If the metal is unknown, its page has no k, or its data do not cover the wavelengths.

    Examples
    --------
    >>> n, k = refractive_index("Au", np.array([550.0]))
    >>> float(fresnel_reflectance(n, k, np.array([1.0]))[0].round(2))
    0.79
    """
    page = metal_page(name)
    n, k = optical_constants(page, wavelengths_nm)
    if k is None:
        raise SpectralDataError(f'"{page}" of refractiveindex.info has no k, so it is no metal we can use.')
    return n, k


def metal_page(name: str) -> str:
    """The page "shelf/book/page" behind a metal's symbol or English name; a page's name stands for itself.

    Raises
    ------
    SpectralDataError
        If the metal is unknown; the message suggests the nearest.

    Examples
    --------
    >>> metal_page("Gold")
    'main/Au/Johnson'
    """
    page = name.rpartition(": ")[2]  # "Gold: main/Au/Johnson" will do
    if page.count("/") == 2:
        return page
    by_word = {word.lower(): symbol for symbol, word in METAL_NAMES.items()} | {
        symbol.lower(): symbol for symbol in METAL_PAGES
    }
    symbol = by_word.get(name.lower())
    if symbol is None:
        near = difflib.get_close_matches(name.lower(), by_word, n=1, cutoff=0.4)
        hint = f'Did you mean "{by_word[near[0]]}"? ' if near else ""
        raise SpectralDataError(
            f'There is no metal called "{name}". {hint}Known are {", ".join(METAL_PAGES)}, '
            'and "shelf/book/page" of refractiveindex.info.'
        )
    return METAL_PAGES[symbol]


def fresnel_reflectance(n: FloatArray, k: FloatArray, cos_incidence: FloatArray) -> FloatArray:
    """Fresnel reflectance of a metal for unpolarised light, F(theta, lambda) of eq. 11.

    Parameters
    ----------
    n, k
        Complex refractive index; broadcast against `cos_incidence`.
    cos_incidence
        Cosine of the incidence angle.

    Returns
    -------
    ndarray
        Reflectance in 0..1, of the broadcast shape.

    Examples
    --------
    >>> float(fresnel_reflectance(np.array(1.5), np.array(0.0), np.array(1.0)).round(3))
    0.04
    """
    n, k, cosine = (np.asarray(a, float) for a in (n, k, cos_incidence))
    sine_squared = 1.0 - cosine**2
    t = n**2 - k**2 - sine_squared
    a2_b2 = np.sqrt(t**2 + 4 * n**2 * k**2)
    a = np.sqrt(np.maximum((a2_b2 + t) / 2, 0))
    s_polarised = (a2_b2 + cosine**2 - 2 * a * cosine) / (a2_b2 + cosine**2 + 2 * a * cosine)
    numerator = cosine**2 * a2_b2 + sine_squared**2 - 2 * a * cosine * sine_squared
    denominator = cosine**2 * a2_b2 + sine_squared**2 + 2 * a * cosine * sine_squared
    p_polarised = s_polarised * numerator / np.where(denominator > 0, denominator, 1.0)
    return np.asarray((s_polarised + p_polarised) / 2)


def metal_reflectance(
    name: str, cos_incidence: FloatArray, wavelengths_nm: FloatArray = WAVELENGTHS_NM
) -> FloatArray:
    """Fresnel reflectance of a metal by name, (..., L) for incidence angles of any shape (...)."""
    n, k = refractive_index(name, wavelengths_nm)
    return fresnel_reflectance(n, k, np.asarray(cos_incidence, float)[..., None])


def ball_reflectance(
    material: str | Mapping[str, float],
    cos_incidence: FloatArray,
    wavelengths_nm: FloatArray = WAVELENGTHS_NM,
) -> FloatArray:
    """Reflectance S(theta, lambda) of the mirrored ball: its metals' reflectances mixed by their fractions (eq. 11).

    Parameters
    ----------
    material
        A name of `BALL_MATERIALS`; a metal as in `refractive_index`; the fractions of its metals, which are normalised to
        sum to one; or the path of a file with the ball's own measured reflectance (`measured_ball`).
    cos_incidence
        (...) cosine of the incidence angle.
    wavelengths_nm
        (L,).

    Returns
    -------
    ndarray
        (..., L) in 0..1.

    Raises
    ------
    SpectralDataError
        If the material or one of its metals is unknown, the fractions are not positive, or the file cannot be used.

    Notes
    -----
    The radiance a mirror returns is S times the incoming radiance: eq. 11, without the division by cos(theta) of
    eq. 9. Photographs agree (measured radiance does not change with the incidence angle as 1/cos would).
    Steel measured as such ("stainless steel") reflects 0.08-0.12 more than eq. 11 makes of its metals ("SUS304"): a
    quarter of a stop in absolute radiance, while the spectral shapes differ by no more than 3.1 %.

    Examples
    --------
    >>> ball_reflectance("SUS304", np.array(1.0))[[10, 30, 50]].round(3).tolist()  # 450, 550, 650 nm
    [0.512, 0.53, 0.549]
    """
    if isinstance(material, str) and is_spectrum_file(material):
        return measured_ball_reflectance(Path(material), cos_incidence, wavelengths_nm)
    fractions = ball_fractions(material)
    shape = (*np.shape(cos_incidence), len(wavelengths_nm))
    if not fractions:
        return np.ones(shape)
    total = sum(fractions.values())
    mixed = np.zeros(shape)
    for metal, fraction in fractions.items():
        mixed += fraction / total * metal_reflectance(metal, cos_incidence, wavelengths_nm)
    return mixed


def ball_fractions(material: str | Mapping[str, float]) -> Mapping[str, float]:
    """Fractions of the metals in a ball, by name or as given; empty for the ideal ball.

    Raises
    ------
    SpectralDataError
        If the name is unknown, or a fraction is not positive.
    """
    if isinstance(material, str):
        by_name = {name.lower(): name for name in BALL_MATERIALS}
        if material.lower() in by_name:
            return BALL_MATERIALS[by_name[material.lower()]]
        metals = {name.lower() for name in (*METAL_PAGES, *METAL_NAMES.values())}
        if material.lower() in metals or material.count("/") == 2:
            return {material: 1.0}
        near = difflib.get_close_matches(material.lower(), by_name, n=1, cutoff=0.4)
        hint = f'Did you mean "{by_name[near[0]]}"? ' if near else ""
        raise SpectralDataError(
            f'There is no ball material called "{material}". {hint}Known are {", ".join(BALL_MATERIALS)}, '
            "or give fractions of metals such as { Fe = 0.74, Cr = 0.18, Ni = 0.08 }, or a file: my_ball.csv."
        )
    if not material or any(not fraction > 0 for fraction in material.values()):
        raise SpectralDataError(
            "The fractions of the ball's metals must be positive numbers, for example { Cr = 1 }."
        )
    return material

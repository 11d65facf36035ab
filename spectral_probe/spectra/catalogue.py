"""Everything spectral the library knows, in one list: to look through, to search, and to take curves from.

A folder of the user's own files can be looked through together with it.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path

import numpy as np

from ..errors import SpectralDataError
from ..model import FloatArray
from . import passports
from .camera import camera_sensitivities
from .colorimetry import on_grid
from .colour_science import colour
from .glass import glass_transmittance
from .grid import WAVELENGTHS_NM
from .library import daylight, lamp_spectrum, planck
from .metals import METAL_NAMES, ball_reflectance, metal_page
from .own_files import own_entries
from .passports import KINDS, Passport
from .refractive import is_page_name, optical_constants, page_of, search_pages

_BUILT_IN: Mapping[str, Callable[[], Iterator[Passport]]] = {
    "lamp": passports.lamps,
    "camera": passports.cameras,
    "metal": passports.metals,
    "glass": passports.glasses,
    "reflectance": passports.reflectances,
    "ball": passports.balls,
}
_COMPUTED = re.compile(r"(planck|daylight)\s*(\d+(?:\.\d+)?)\s*k?", re.IGNORECASE)


def catalogue(kind: str | None = None, folder: Path | None = None) -> tuple[Passport, ...]:
    """Passports of what is known, of one kind or of all; those of a folder of the user's go first.

    Raises
    ------
    SpectralDataError
        If there is no such kind, or no such folder.

    Examples
    --------
    >>> [ball.name for ball in catalogue("ball")]
    ['SUS304', 'stainless steel', 'chrome', 'silver', 'aluminium', 'ideal']
    """
    if kind is not None and kind not in KINDS:
        near = difflib.get_close_matches(kind, KINDS, n=1, cutoff=0.4)
        hint = f'Did you mean "{near[0]}"? ' if near else ""
        raise SpectralDataError(f'There is no kind "{kind}". {hint}Kinds are {", ".join(KINDS)}.')
    own = () if folder is None else tuple(entry.passport for entry in own_entries(folder)[0])
    return tuple(p for p in (*own, *_built_in()) if kind in {None, p.kind})


@cache
def _built_in() -> tuple[Passport, ...]:
    return tuple(passport for kind in KINDS if kind in _BUILT_IN for passport in _BUILT_IN[kind]())


def find(name: str, kind: str | None = None, folder: Path | None = None) -> Passport:
    """The passport of a name, capitals or not: of the list, a computed lamp, or a page of refractiveindex.info.

    Raises
    ------
    SpectralDataError
        If there is none of that name; the message suggests the nearest.

    Examples
    --------
    >>> find("gold").family
    'Gold, main/Au/Johnson'
    >>> find("Planck 3200 K").family
    'incandescent'
    """
    known = catalogue(kind, folder)
    by_name = {passport.name.casefold(): passport for passport in reversed(known)}
    wanted = name.strip().casefold()
    if wanted in by_name:
        return by_name[wanted]
    if _COMPUTED.fullmatch(wanted) and kind in {None, "lamp"}:
        lamp_spectrum(name)  # is its temperature one?
        return passports.computed_lamp(name.strip())
    page = name.strip().rpartition(": ")[2]
    if is_page_name(page) and kind in {None, "metal"}:
        return passports.metal_of_page(page_of(page))
    other_names = {alias: passport for passport in reversed(known) for alias in _other_names(passport)}
    if wanted in other_names:
        return other_names[wanted]
    near = difflib.get_close_matches(wanted, by_name | other_names, n=1, cutoff=0.5)
    hint = f"Look for it with: library search {name}."
    if near:
        hint = f'Did you mean "{(by_name | other_names)[near[0]].name}"?'
    raise SpectralDataError(f'There is no {kind or "entry"} called "{name}" in the library. {hint}')


def _other_names(passport: Passport) -> tuple[str, ...]:
    """What people call an entry besides its name: a metal in English, a patch without its chart."""
    english = METAL_NAMES.get(passport.name, "") if passport.kind == "metal" else ""
    patch = passport.name.partition(": ")[2]
    return tuple(alias.casefold() for alias in (english, patch) if alias)


def search(words: Sequence[str], folder: Path | None = None) -> tuple[Passport, ...]:
    """Passports that have every word anywhere in them, all of refractiveindex.info among them.

    Examples
    --------
    >>> [found.name for found in search(["karlsson", "ferritic"])]
    ['other/stainless_steel/Karlsson-ferritic']
    """
    wanted = [word.casefold() for word in words]

    def text(passport: Passport) -> str:
        return f"{passport.name} {passport.kind} {passport.family} {passport.source} {passport.remark}".casefold()

    listed = [p for p in catalogue(None, folder) if all(word in text(p) for word in wanted)]
    pages = [passports.metal_of_page(page) for page in search_pages(words)]
    return (*listed, *pages)


def curves_of(passport: Passport, folder: Path | None = None) -> dict[str, FloatArray]:
    """The curves of an entry on the exchange grid, (61,) each, by the name of what they are.

    Examples
    --------
    >>> list(curves_of(find("Au"))), list(curves_of(find("Canon EOS 5D Mark II")))
    (['n', 'k', 'reflectance'], ['r', 'g', 'b'])
    """
    for own in () if folder is None else own_entries(folder)[0]:
        if own.passport == passport:
            return own.curves()
    return _CURVES[passport.kind](passport.name)


def as_tabulated(passport: Passport, folder: Path | None = None) -> tuple[FloatArray, FloatArray]:
    """Wavelengths and values of the first curve of an entry over its whole table, which may be wider than our grid.

    A lamp that is computed is computed for 360-830 nm, where the eye's response ends.
    """
    for own in () if folder is None else own_entries(folder)[0]:
        if own.passport == passport:
            return own.as_tabulated()
    for known in (colour.SDS_ILLUMINANTS, colour.SDS_LIGHT_SOURCES):
        if passport.kind == "lamp" and passport.name in known:
            return np.asarray(known[passport.name].wavelengths, float), np.asarray(
                known[passport.name].values, float
            )
    computed = _COMPUTED.fullmatch(passport.name)
    if passport.kind == "lamp" and computed:
        wide_nm = np.arange(360.0, 831.0, 5.0)
        kelvin = float(computed[2])
        return wide_nm, planck(kelvin, wide_nm) if computed[1].lower() == "planck" else daylight(
            kelvin, wide_nm
        )
    return WAVELENGTHS_NM, next(iter(curves_of(passport, folder).values()))


def _metal_curves(name: str) -> dict[str, FloatArray]:
    """Index and reflectance at normal incidence; a clear glass has no k, and reflects by its n alone."""
    n, k = optical_constants(metal_page(name), WAVELENGTHS_NM)
    absorbing = np.zeros_like(n) if k is None else k
    reflectance = ((n - 1) ** 2 + absorbing**2) / ((n + 1) ** 2 + absorbing**2)
    return {"n": n, **({} if k is None else {"k": k}), "reflectance": reflectance}


def _reflectance_curve(name: str) -> dict[str, FloatArray]:
    chart, patch = name.split(": ", 1)
    return {"reflectance": np.clip(on_grid(passports.reflectance_set(chart)[patch]), 0.0, 1.0)}


def _ball_curves(name: str) -> dict[str, FloatArray]:
    at_angles = ball_reflectance(name, np.cos(np.radians([0.0, 60.0, 80.0])))
    return {f"reflectance_{deg}deg": row for deg, row in zip((0, 60, 80), at_angles, strict=True)}


_CURVES: Mapping[str, Callable[[str], dict[str, FloatArray]]] = {
    "lamp": lambda name: {"relative_power": lamp_spectrum(name)},
    "camera": lambda name: dict(zip("rgb", camera_sensitivities(name).T, strict=True)),
    "metal": _metal_curves,
    "glass": lambda name: {"transmittance": glass_transmittance(name)},
    "reflectance": _reflectance_curve,
    "ball": _ball_curves,
}

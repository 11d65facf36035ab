"""What everything spectral in the library is, where it comes from and under which licence: a passport each."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from ..files.spectrum_file import read_samples
from .camera import REC709, camera_curves, camera_names, camera_sensitivities, gains_remark
from .colorimetry import on_grid
from .colour_science import colour
from .glass import GLASSES, SHORT_NAMES
from .library import FAMILIES, lamp_names
from .metals import BALL_MATERIALS, METAL_NAMES, METAL_PAGES
from .refractive import Page, page_of, visible_range_nm

KINDS = ("lamp", "camera", "metal", "glass", "reflectance", "ball")

_DATA = Path(__file__).resolve().parents[1] / "data"

_COLOUR = "BSD-3-Clause (colour-science)"
_CIE = f"{_COLOUR}; tables of the CIE under CC BY-SA 4.0"
_COMPUTED = "computed here, no licence needed"
_PAGES = "CC0 1.0 (refractiveindex.info)"

_RAWTOACES = f"{_COLOUR}, from the Academy's rawtoaces"

_CIE_2018 = "CIE 015:2018 Colorimetry, doi 10.25039/TR.015.2018"
_ISO_7589 = "ISO 7589:2002 Photography - Illuminants for sensitometry"
_POINTER = "Pointer, M. R. (1980), Pointer's Gamut Data, RIT"
_NIST = "Ohno, Y. & Davis, W. (2008), NIST CQS simulation 7.4"
_KINOTON = "Borer, T. (2017), private communication to the authors of colour-science"
_POINTERS_LIGHTS = (
    "Natural", "Philips TL-84", "SA", "SC", "T8 Luxline Plus White", "T8 Polylux 3000", "T8 Polylux 4000",
    "Thorn Kolor-rite",
)  # fmt: skip

_NPL = "Darrodi et al., J. Opt. Soc. Am. A 32, 381 (2015), doi 10.1364/JOSAA.32.000381"

REFLECTANCE_SETS: Mapping[str, str] = {
    "ColorChecker N Ohta": "Ohta, N. (1997), The basis of color reproduction engineering; the same as ISO 17321-1",
    "BabelColor Average": "Danny Pascale, BabelColor (2012), average of 30 charts; used by permission",
    "rawtoaces": "Academy of Motion Picture Arts and Sciences, rawtoaces, its 190 training patches",
    "PMC": "Luo, M. R. (2024), The new preferred memory color chart, doi 10.1002/col.22940",
}
"""Charts of measured surfaces that colour-science carries, and where each comes from."""


@dataclass(frozen=True)
class Passport:
    """What one entry of the library is.

    `first_nm` and `last_nm` are the wavelengths it was tabulated for, before it came onto the exchange grid. `remark` is what
    somebody about to use it must know; mostly empty.
    """

    name: str
    kind: str
    family: str
    quantity: str
    unit: str
    first_nm: float
    last_nm: float
    licence: str
    source: str
    remark: str = ""


def lamps() -> Iterator[Passport]:
    """Lights of colour-science, by family, and the two series that are computed for any temperature."""
    family_of = {name: family for family, names in FAMILIES.items() for name in names}
    quantity = "relative spectral power"
    known = set(lamp_names())
    ordered = [name for names in FAMILIES.values() for name in names]
    ordered += [name for name in lamp_names() if name not in family_of]
    for name in ordered:
        if name not in known:
            continue
        is_cie = name in colour.SDS_ILLUMINANTS
        distribution = (colour.SDS_ILLUMINANTS if is_cie else colour.SDS_LIGHT_SOURCES)[name]
        first, last = _ends(distribution)
        iso = name.startswith("ISO 7589")
        yield Passport(
            name,
            "lamp",
            family_of.get(name, "photographic (ISO 7589)" if iso else "equal energy"),
            quantity,
            "1, relative",
            first,
            last,
            _COLOUR if iso or not is_cie else _CIE,
            _ISO_7589 if iso else _CIE_2018 if is_cie else _lamp_source(name),
            f"Its table ends at {last:g} nm; its last value is taken beyond." if last < 700 else "",
        )
    yield computed_lamp("Planck 2856 K")
    yield computed_lamp("Daylight 6500 K")


def _lamp_source(name: str) -> str:
    if name == "Kinoton 75P":
        return _KINOTON
    return _POINTER if name in _POINTERS_LIGHTS else _NIST


def computed_lamp(name: str) -> Passport:
    """Passport of a lamp that is computed from its temperature, "Planck 3200 K" or "Daylight 6500 K"."""
    is_planck = name.lower().startswith("planck")
    source = "Planck's law, c2 = 1.438776877e7 nm K (CODATA 2018)" if is_planck else _CIE_2018
    remark = f"Computed; any temperature will do: {'Planck 3200 K' if is_planck else 'Daylight 5000 K'}."
    family = "incandescent" if is_planck else "daylight"
    return Passport(
        name, "lamp", family, "relative spectral power", "1, relative", 360, 830, _COMPUTED, source, remark
    )


def cameras() -> Iterator[Passport]:
    """The cameras whose curves colour-science carries, and linear Rec.709."""
    for name in camera_names():
        family, licence, source, remark = (
            "camera raw",
            _COLOUR,
            _NPL,
            gains_remark(name, camera_sensitivities(name)),
        )
        first, last = (360.0, 830.0) if name == REC709 else camera_curves(name).range_nm
        if name == REC709:
            family, licence = "display-referred pictures", _CIE
            source = "CIE 1931 colour-matching functions through XYZ to Rec.709 (ITU-R BT.709, D65)"
        elif not name.endswith("(NPL)"):
            licence = _RAWTOACES
            source = "Academy of Motion Picture Arts and Sciences, rawtoaces"
        quantity = "relative spectral sensitivity"
        yield Passport(
            name, "camera", family, quantity, "1, relative", first, last, licence, source, remark or ""
        )


def metals() -> Iterator[Passport]:
    """The metals known by name; every other page of refractiveindex.info goes by its own."""
    for symbol, page in METAL_PAGES.items():
        yield metal_of_page(page_of(page), symbol, METAL_NAMES[symbol])


def metal_of_page(page: Page, name: str | None = None, english: str | None = None) -> Passport:
    """Passport of a page of refractiveindex.info, under its own name or another."""
    first, last = visible_range_nm(page.name)
    family = f"{english}, {page.name}" if english else page.title or page.book
    return Passport(
        name or page.name,
        "metal",
        family,
        "complex refractive index n + ik",
        "1",
        first,
        last,
        _PAGES,
        _source(page),
        page.remark,
    )


def _source(page: Page) -> str:
    return page.reference + (f", doi {page.doi}" if page.doi and page.doi not in page.reference else "")


def glasses() -> Iterator[Passport]:
    """The stained glasses that come with the program; their passports stand in data/SOURCES.toml."""
    sources = tomllib.loads((_DATA / "SOURCES.toml").read_text(encoding="utf-8"))
    for name, path in GLASSES.items():
        passport = sources[path.relative_to(_DATA).as_posix()]
        first, last = read_samples(path).range_nm
        yield Passport(
            name,
            "glass",
            f"stands for {SHORT_NAMES[name]}" if name in SHORT_NAMES else "stained glass",
            passport["quantity"],
            passport["unit"],
            first,
            last,
            passport["licence"],
            passport["source"],
        )


def reflectances() -> Iterator[Passport]:
    """Surfaces that colour-science carries, set by set; named "set: patch"."""
    for family, source in REFLECTANCE_SETS.items():
        for patch, distribution in reflectance_set(family).items():
            first, last = _ends(distribution)
            highest = float(on_grid(distribution).max())
            remark = f"Its table reaches {highest:.3f}; it is limited to 1." if highest > 1 else ""
            quantity = "reflectance factor"
            yield Passport(
                f"{family}: {patch}",
                "reflectance",
                family,
                quantity,
                "1, fraction",
                first,
                last,
                _RAWTOACES if family == "rawtoaces" else _COLOUR,
                source,
                remark,
            )


@cache
def reflectance_set(family: str) -> Mapping[str, Any]:
    """Spectral distributions of colour-science by name of the patch, for a set of `REFLECTANCE_SETS`."""
    if family != "rawtoaces":
        return dict(colour.SDS_COLOURCHECKERS[family])
    patches = colour.characterisation.read_training_data_rawtoaces_v1()
    return dict(zip(patches.labels, patches.to_sds(), strict=True))


def balls() -> Iterator[Passport]:
    """The materials of mirrored balls known by name."""
    for name, fractions in BALL_MATERIALS.items():
        pages = [page_of(METAL_PAGES[metal]) for metal in fractions]
        ranges = [visible_range_nm(page.name) for page in pages] or [(400.0, 700.0)]
        composition = " + ".join(f"{fraction:g} {metal}" for metal, fraction in fractions.items())
        if len(pages) == 1:
            composition = pages[0].name
        remark = ""
        if name == "SUS304":
            remark = 'Its metals mixed by eq. 11; steel measured as such ("stainless steel") reflects 0.08-0.12 more.'
        yield Passport(
            name,
            "ball",
            composition or "reflects everything",
            "reflectance at any incidence (Fresnel, eq. 11)",
            "1, fraction",
            max(first for first, _ in ranges),
            min(last for _, last in ranges),
            _PAGES if pages else _COMPUTED,
            "; ".join(dict.fromkeys(map(_source, pages))) or "by definition",
            remark,
        )


def _ends(distribution: Any) -> tuple[float, float]:
    return float(distribution.wavelengths[0]), float(distribution.wavelengths[-1])

"""Swatches: the colours by which metals, glasses, measured surfaces and lamps are told apart in a list, under a light.

A metal shows its reflectance at normal incidence (F0), a surface its diffuse reflectance, a pane what passes it at normal
incidence, clear glass what passes a plate of it. A perfect white is white whatever the light: swatches are seen beside the white
of a screen, to which the eye is adapted, so they are adapted from the light to it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import SpectralDataError
from ..figures.display import into_gamut, srgb_encoded
from ..model import FloatArray, Job, Progress
from .catalogue import catalogue, curves_of
from .colorimetry import spectra_to_xyz, white_xyz, xyz_to_rec709
from .colour_science import colour
from .dispersion import CLEAR_PAGES
from .glass import glass_transmittance
from .grid import WAVELENGTHS_NM
from .metals import METAL_NAMES, fresnel_reflectance
from .passports import Passport
from .refractive import ENGLISH, Page, optical_constants, page_of, search_pages

SURFACES = ("METAL", "GLASS", "DISPERSIVE", "REFLECTANCE")
"""What a material can be, by the words of `Material.spectral_probe.kind`."""

LAMP = "LAMP"

_OPAQUE_K = 0.05
"""Mean extinction coefficient from which a page counts as a metal: its light is gone after about a wavelength."""

_CLEAR_K = 5e-6
"""Largest extinction coefficient of clear glass: a millimetre of it absorbs less than a tenth."""

_PAGES_A_STEP = 400

_DARK_CONE = 0.02
"""Below this share of a white's luminance a light does not excite a kind of cone enough to say anything by it."""


@dataclass(frozen=True)
class Swatch:
    """An entry of a list of spectra.

    Parameters
    ----------
    kind
        A word of `SURFACES`, or "LAMP".
    name
        What the settings of a material or a lamp call it.
    label
        What people call it.
    detail
        What it is: the page of refractiveindex.info, the chart, the family of lamps.
    source, licence, remark
        As in its passport.
    rgb
        Its colour on a screen, sRGB as encoded, 0..1.
    """

    kind: str
    name: str
    label: str
    detail: str
    source: str
    licence: str
    remark: str
    rgb: tuple[float, float, float]

    @property
    def key(self) -> str:
        """Kind and name: no two have the same."""
        return f"{self.kind}|{self.name}"

    @property
    def searched(self) -> str:
        """The text by which it is found."""
        return f"{self.label} {self.name} {self.detail} {self.source}".replace("_", " ").casefold()


def reflected_colours(curves: FloatArray, light: FloatArray) -> FloatArray:
    """Screen colours of surfaces or panes under a light, a perfect white being white.

    Parameters
    ----------
    curves
        (..., 61) reflectance or transmittance.
    light
        (61,) spectral power of the light, in any unit.

    Returns
    -------
    ndarray
        (..., 3) sRGB as encoded, 0..1: CIE 1931 2 degree observer, complete adaptation from the light to D65 (von Kries in the
        space of CAT16). Colours outside of sRGB move towards the grey of their luminance.

    Raises
    ------
    SpectralDataError
        If the light is dark.

    Notes
    -----
    Under a light that leaves a kind of cone dark, such as a sodium lamp, nothing is told by that cone: it follows the luminance,
    and swatches come out in greys, as things do in such light to an eye adapted to it.

    Examples
    --------
    >>> half = np.full(61, 0.5)
    >>> reflected_colours(half, np.linspace(1.0, 5.0, 61)).round(1).tolist()
    [0.7, 0.7, 0.7]
    """
    to_cones = np.asarray(colour.adaptation.CHROMATIC_ADAPTATION_TRANSFORMS["CAT16"], float)
    white = spectra_to_xyz(np.asarray(light, float))
    if not (np.isfinite(white).all() and white[1] > 0):
        raise SpectralDataError("The light for the swatches is dark. Choose another light.")
    xyz = spectra_to_xyz(np.asarray(curves, float) * light) / white[1]
    white_cones, cones = to_cones @ (white / white[1]), xyz @ to_cones.T
    excited = white_cones > _DARK_CONE
    relative = np.where(excited, cones / np.where(excited, white_cones, 1.0), xyz[..., 1:2])
    adapted = (relative * (to_cones @ white_xyz())) @ np.linalg.inv(to_cones).T
    return _on_screen(adapted)


def lamp_colours(spectra: FloatArray) -> FloatArray:
    """Screen colours (..., 3) of lamps (..., 61), each as bright as the screen can show it; D65 is white."""
    xyz = spectra_to_xyz(np.asarray(spectra, float))
    rgb = xyz_to_rec709(xyz)
    rgb = into_gamut(rgb, np.maximum(xyz[..., 1:2], 0.0))
    peak = rgb.max(-1, keepdims=True)
    return srgb_encoded(np.clip(rgb / np.where(peak > 0, peak, 1.0), 0.0, 1.0))


def _on_screen(xyz: FloatArray) -> FloatArray:
    rgb = into_gamut(xyz_to_rec709(xyz), np.maximum(xyz[..., 1:2], 0.0))
    return srgb_encoded(np.clip(rgb, 0.0, 1.0))


def library_swatches(light: FloatArray, folder: Path | None = None) -> tuple[Swatch, ...]:
    """Swatches of what the library names itself, and of the user's own folder: metals, glasses, clear glasses, surfaces, lamps.

    Parameters
    ----------
    light
        (61,) the light they are seen under; lamps have their own.
    folder
        The user's own files.
    """
    surfaces = [entry for kind in SURFACES for entry in _ENTRIES[kind](folder)]
    colours = reflected_colours(np.stack([curve for *_, curve in surfaces]), light)
    swatches = [
        _swatch(kind, passport, label, detail, rgb)
        for (kind, passport, label, detail, _), rgb in zip(surfaces, colours, strict=True)
    ]
    lamps = catalogue("lamp")
    shown = lamp_colours(np.stack([curves_of(p)["relative_power"] for p in lamps]))
    swatches += [_swatch(LAMP, p, p.name, p.family, rgb) for p, rgb in zip(lamps, shown, strict=True)]
    return tuple(swatches)


def page_swatches(light: FloatArray) -> Job[tuple[Swatch, ...]]:
    """Swatches of the metals and the clear glasses among all pages of refractiveindex.info that cover 400-700 nm: a job.

    Pages that are neither, such as dyes, are left out; what speaks against a page is in its remark.
    """
    pages = search_pages([])
    found: list[tuple[str, Page, FloatArray]] = []
    for first in range(0, len(pages), _PAGES_A_STEP):
        yield Progress(first / len(pages), "Reading refractiveindex.info")
        for page in pages[first : first + _PAGES_A_STEP]:
            seen = _of_page(page.name)
            if seen is not None:
                found.append((seen[0], page, seen[1]))
    colours = reflected_colours(np.stack([curve for *_, curve in found]), light)
    return tuple(
        Swatch(
            kind,
            page.name,
            f"{_english(page)}: {page.page}",
            page.name,
            page.reference,
            "CC0 1.0 (refractiveindex.info)",
            page.remark,
            (float(rgb[0]), float(rgb[1]), float(rgb[2])),
        )
        for (kind, page, _), rgb in zip(found, colours, strict=True)
    )


def matching(swatches: Sequence[Swatch], typed: str) -> tuple[Swatch, ...]:
    """Those that have every word typed somewhere in their text."""
    words = typed.casefold().split()
    return tuple(swatch for swatch in swatches if all(word in swatch.searched for word in words))


def plate_transmittance(n: FloatArray) -> FloatArray:
    """What passes a clear plate, reflections between its surfaces included, 2n / (n^2 + 1), of the shape of n.

    Examples
    --------
    >>> float(plate_transmittance(np.array(1.5)).round(3))
    0.923
    """
    return np.asarray(2.0 * n / (n**2 + 1.0))


def _english(page: Page) -> str:
    return ENGLISH[page.book].split()[0] if page.book in ENGLISH else page.book.replace("_", " ")


def _of_page(name: str) -> tuple[str, FloatArray] | None:
    """What a page is, and the curve (61,) that it shows; None where it is neither metal nor clear."""
    try:
        n, k = optical_constants(name, WAVELENGTHS_NM)
    except SpectralDataError:
        return None
    if not np.isfinite(n).all() or (k is not None and not np.isfinite(k).all()):
        return None
    if k is None or k.max() < _CLEAR_K:
        return "DISPERSIVE", plate_transmittance(n)
    if k.mean() < _OPAQUE_K:
        return None
    return "METAL", fresnel_reflectance(n, k, np.array(1.0))


def _swatch(kind: str, passport: Passport, label: str, detail: str, rgb: FloatArray) -> Swatch:
    red, green, blue = map(float, rgb)
    return Swatch(
        kind,
        passport.name,
        label,
        detail,
        passport.source,
        passport.licence,
        passport.remark,
        (red, green, blue),
    )


type _Entry = tuple[str, Passport, str, str, FloatArray]


def _metals(_folder: Path | None) -> list[_Entry]:
    return [
        ("METAL", p, METAL_NAMES[p.name], p.family.rpartition(", ")[2], curves_of(p)["reflectance"])
        for p in catalogue("metal")
    ]


def _glasses(_folder: Path | None) -> list[_Entry]:
    return [
        ("GLASS", p, p.name.replace("-", " ").capitalize(), p.family, glass_transmittance(p.name))
        for p in catalogue("glass")
    ]


def _clear(_folder: Path | None) -> list[_Entry]:
    entries: list[_Entry] = []
    for name, page in CLEAR_PAGES.items():
        about = page_of(page)
        n, _ = optical_constants(page, WAVELENGTHS_NM)
        passport = Passport(
            name, "clear", about.title, "refractive index n", "1", 400.0, 700.0,
            "CC0 1.0 (refractiveindex.info)", about.reference, about.remark,
        )  # fmt: skip
        label = name if name.isupper() else name.capitalize()
        entries.append(("DISPERSIVE", passport, label, page, plate_transmittance(n)))
    return entries


def _reflectances(folder: Path | None) -> list[_Entry]:
    return [
        ("REFLECTANCE", p, p.name.partition(": ")[2] or p.name, p.family, curves_of(p, folder)["reflectance"])
        for p in catalogue("reflectance", folder)
    ]


_ENTRIES: Mapping[str, Callable[[Path | None], list[_Entry]]] = {
    "METAL": _metals,
    "GLASS": _glasses,
    "DISPERSIVE": _clear,
    "REFLECTANCE": _reflectances,
}

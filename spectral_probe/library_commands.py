"""The verb `library`: what is known of lamps, cameras, metals, glasses, reflectances and balls, and of the user's own files."""

from __future__ import annotations

import argparse
import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .errors import FileFormatError, SpectralDataError
from .files.atomic import written_whole
from .files.spectrum_file import is_spectrum_file
from .model import FloatArray, Job, Progress
from .spectra.grid import WAVELENGTHS_NM

if TYPE_CHECKING:
    from .spectra.passports import Passport

type Numbers = dict[str, Any]

_AT_NM = (450, 550, 650)
EXAMPLE = """library list lamp
         spectral-probe library show FL11 -o fl11.png
         spectral-probe library show Planck 3200 K
         spectral-probe library show my_lamp.csv
         spectral-probe library search steel"""


def add_words(parser: argparse.ArgumentParser) -> None:
    """The words that the verb takes."""
    parser.add_argument("action", choices=("list", "show", "search"), help="what to do")
    parser.add_argument(
        "words",
        nargs="*",
        metavar="WORDS",
        help="list: a kind (lamp, camera, metal, glass, reflectance, ball) or nothing; show: a name, its kind before it "
        "where two share it, or a file of your own; search: words, looked for in all of refractiveindex.info too",
    )
    parser.add_argument("--folder", type=Path, metavar="DIR", help="a folder of your own spectra and cameras")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="show: write a .csv, .png or .svg")


def library(arguments: argparse.Namespace) -> Job[Numbers]:
    """List, show or search; the numbers to print.

    Raises
    ------
    SpectralDataError
        If there is no such kind, name or folder, or nothing was asked for.
    """
    yield Progress(0.0, "Opening the library")
    from .spectra import catalogue, passports
    from .spectra.own_files import own_entries, own_entry

    words: list[str] = arguments.words
    if arguments.action == "show":
        if not words:
            raise SpectralDataError("Say what to show: library show FL11.")
        kind = words[0] if len(words) > 1 and words[0] in passports.KINDS else None
        name = " ".join(words[1:] if kind else words)
        if is_spectrum_file(name):
            own = own_entry(Path(name), kind)
            passport, curves, wide = own.passport, own.curves(), own.as_tabulated()
        else:
            passport = catalogue.find(name, kind, arguments.folder)
            curves = catalogue.curves_of(passport, arguments.folder)
            wide = catalogue.as_tabulated(passport, arguments.folder)
        numbers = described(passport, curves, wide)
        if arguments.output is not None:
            write_entry(arguments.output, passport, curves)
            numbers["written"] = str(arguments.output)
        return numbers
    if arguments.action == "search":
        if not words:
            raise SpectralDataError("Say what to search for: library search steel.")
        found = catalogue.search(words, arguments.folder)
        if not found:
            raise SpectralDataError(f'Nothing in the library has "{" ".join(words)}". Try fewer words.')
    else:
        found = catalogue.catalogue(" ".join(words) or None, arguments.folder)
    numbers = {"entries": [asdict(entry) for entry in found]} if arguments.json else _lines(found)
    complaints = own_entries(arguments.folder)[1] if arguments.folder else []
    return {**numbers, **({"not_usable": complaints} if complaints else {})}


def _lines(found: Sequence[Passport]) -> Numbers:
    """Passports as lines of text, kind by kind."""
    width = max((len(passport.name) for passport in found), default=0)
    lines: dict[str, list[str]] = {}
    for p in found:
        line = f"{p.name:<{width}}  {p.family}, {p.first_nm:g}-{p.last_nm:g} nm"
        lines.setdefault(p.kind, []).append(line + (" (see its remark)" if p.remark else ""))
    return dict(lines)


def described(
    passport: Passport, curves: Mapping[str, FloatArray], wide: tuple[FloatArray, FloatArray]
) -> Numbers:
    """The passport of an entry, and the numbers somebody chooses it by.

    `wide` is the first curve as tabulated, wavelengths and values: a lamp's colour is that of its whole table.
    """
    known = asdict(passport)
    first, last = known.pop("first_nm"), known.pop("last_nm")
    remark = known.pop("remark")
    numbers: Numbers = {**known, "range_nm": [first, last]}
    if remark:
        numbers["remark"] = remark
    match passport.kind:
        case "lamp":
            numbers.update(_colour_of_light(*wide))
        case "camera":
            numbers["peaks_nm"] = {
                name: float(WAVELENGTHS_NM[curve.argmax()]) for name, curve in curves.items()
            }
            numbers["peak_ratios"] = _rounded(
                np.array([curve.max() for curve in curves.values()]) / _largest(curves)
            )
        case "glass" | "reflectance":
            numbers.update(_colour_under_d65(next(iter(curves.values()))))
        case _:
            numbers.update({name: _at(curve) for name, curve in curves.items()})
    return numbers


def _at(curve: FloatArray) -> dict[str, float]:
    values = np.interp(_AT_NM, WAVELENGTHS_NM, curve)
    return {f"{nm}_nm": round(float(value), 4) for nm, value in zip(_AT_NM, values, strict=True)}


def _largest(curves: Mapping[str, FloatArray]) -> float:
    return float(max(curve.max() for curve in curves.values()))


def _colour_of_light(wavelengths_nm: FloatArray, values: FloatArray) -> Numbers:
    """Chromaticity, correlated colour temperature and Duv by the 1 nm observer over what the table covers."""
    from .spectra.colour_science import colour

    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    power = np.interp(observer.wavelengths, wavelengths_nm, values, left=0.0, right=0.0)
    xyz = power @ np.asarray(observer.values)
    kelvin, duv = (
        float(v)
        for v in colour.temperature.uv_to_CCT_Ohno2013(colour.UCS_to_uv(colour.XYZ_to_UCS(xyz / xyz[1])))
    )
    defined = abs(duv) <= 0.05  # the CIE defines no correlated colour temperature farther off
    return {
        "xy": _rounded(xyz[:2] / xyz.sum()),
        "cct_kelvin": round(kelvin, 1) if defined else None,
        "duv": round(duv, 5) + 0.0 if defined else None,
    }


def _colour_under_d65(fraction: FloatArray) -> Numbers:
    from .spectra.colorimetry import chromaticity, illuminant, spectra_to_xyz

    white, seen = spectra_to_xyz(illuminant("D65")), spectra_to_xyz(fraction * illuminant("D65"))
    return {
        "xy_d65": _rounded(chromaticity(seen)),
        "y_d65": round(float(seen[1] / white[1]), 4),
        "at": _at(fraction),
    }


def _rounded(values: FloatArray) -> list[float]:
    return [round(float(value), 4) for value in values]


def write_entry(path: Path, passport: Passport, curves: Mapping[str, FloatArray]) -> None:
    """Write the curves of an entry as CSV with its passport above, or draw them as PNG or SVG.

    Raises
    ------
    FileFormatError
        If the ending is another, or the folder cannot be written to.
    """
    from .files.atomic import check_folder

    suffix = path.suffix.lower()
    if suffix not in {".csv", ".png", ".svg"}:
        raise FileFormatError(
            f'"{path.name}": an entry is written as .csv, .png or .svg. Choose one of these endings.'
        )
    check_folder(path.parent)
    if suffix == ".csv":
        text = io.StringIO()
        for key in ("name", "kind", "quantity", "unit", "licence", "source"):
            text.write(f"# {key}: {getattr(passport, key)}\n")
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["wavelength_nm", *curves])
        writer.writerows(
            [f"{value:.7g}" for value in row] for row in zip(WAVELENGTHS_NM, *curves.values(), strict=True)
        )
        with written_whole(path) as temporary:
            temporary.write_text(text.getvalue(), encoding="utf-8")
        return
    from .figures.catalogue import entry_figure
    from .figures.style import save_figure

    save_figure(entry_figure(passport.name, f"{passport.quantity}; {passport.family}", curves), path)

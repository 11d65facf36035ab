"""Spectra, reflectances, transmittances and sensitivities out of users' own files, whatever kind of file it is."""

from __future__ import annotations

import codecs
import json
import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ..errors import SpectralDataError
from ..model import FloatArray
from ..spectra.curves import SampledCurves, on_grid
from .spectrum_text import parse_text

SUFFIXES = (".csv", ".txt", ".tsv", ".dat", ".spd", ".spdx", ".xml", ".json", ".xls")
"""Endings of files that may hold spectra. `.xls` is what UPRtek's instruments call a text."""


_LARGEST_FILE_BYTES = 32_000_000


def is_spectrum_file(text: str) -> bool:
    """Whether a word is the name of a file of spectra rather than a name of the library.

    Examples
    --------
    >>> is_spectrum_file("my ball.csv"), is_spectrum_file("SUS304"), is_spectrum_file("3-LED-1 (457/540/605)")
    (True, False, False)
    """
    return text.lower().endswith(SUFFIXES)


def read_samples(path: Path) -> SampledCurves:
    """The curves of a file as tabulated, unchecked.

    Parameters
    ----------
    path
        CSV or other text (`spectrum_text`), IES TM-27 (.spdx), or AMPAS JSON.

    Raises
    ------
    SpectralDataError
        If the file is missing, cannot be read, or is none of these.
    """
    path = Path(path)
    if path.is_dir():
        raise SpectralDataError(f"{path} is a folder. Give the name of a file in it.")
    try:
        if path.exists() and not path.is_file():  # a pipe would be waited for
            raise SpectralDataError(f"{path} is no file but a device. Give a file with a spectrum.")
        if path.stat().st_size > _LARGEST_FILE_BYTES:
            raise SpectralDataError(f"{path.name} is larger than any table of spectra. Give another file.")
        data = path.read_bytes()
    except FileNotFoundError:
        raise SpectralDataError(f"There is no file at {path}. Check the path.") from None
    except OSError as problem:
        raise SpectralDataError(f"{path} cannot be read ({problem.strerror}). Check the file.") from None
    text = _decoded(data)
    if path.suffix.lower() == ".json":
        return _ampas_json(text, path.name)
    if text.lstrip().startswith("<"):
        return _tm27(text, path.name)
    return parse_text(text, path.name)


def _decoded(data: bytes) -> str:
    """Text in UTF-8, in UTF-16 with its mark as Windows programs write it, or else in Latin-1, which reads anything."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.decode("utf-16", errors="replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def read_curves(path: Path, quantity: str, columns: int = 1) -> FloatArray:
    """The first curves of a file on the exchange grid, (columns, 61).

    Parameters
    ----------
    path
        As in `read_samples`.
    quantity
        What the values must be: a word of `curves`, such as `curves.REFLECTANCE`.
    columns
        How many curves are wanted; what a file has beyond them (a standard error, say) is passed over.

    Raises
    ------
    SpectralDataError
        If the file cannot be read, has too few columns, or `curves.checked` finds it wanting.
    """
    return on_grid(first_columns(read_samples(path), columns), quantity)


def first_columns(samples: SampledCurves, columns: int) -> SampledCurves:
    """The first so many curves of a table."""
    if len(samples.values) < columns:
        raise SpectralDataError(
            f"{samples.name} has {len(samples.values)} column(s) of values, but {columns} are needed. "
            "Give rows of a wavelength in nm and the values."
        )
    return replace(samples, values=samples.values[:columns], columns=samples.columns[:columns])


def _tm27(text: str, name: str) -> SampledCurves:
    """IES TM-27-14 / TM-27-20: `SpectralData` elements with a wavelength each, in any namespace.

    Entities are not expanded: a document that declares its own is refused before it is parsed.
    """
    if re.search(r"<!\s*(DOCTYPE|ENTITY)", text, re.IGNORECASE):
        raise SpectralDataError(f"{name} declares a document type, which no IES TM-27 file needs. Remove it.")
    try:
        root = ElementTree.fromstring(re.sub(r"^\s*<\?xml[^>]*\?>", "", text))  # noqa: S314  # no entities, see above
        rows = sorted(
            (float(element.attrib["wavelength"]), float(element.text or "nan"))
            for element in root.iter()
            if element.tag.rpartition("}")[2] == "SpectralData"
        )
    except (ElementTree.ParseError, KeyError, ValueError) as problem:
        raise SpectralDataError(
            f"{name} is not valid IES TM-27 ({problem}). Export it again, or give a CSV file."
        ) from None
    if not rows:
        raise SpectralDataError(f"{name} is XML without SpectralData. Give an IES TM-27 file.")
    table = np.array(rows)

    def said(tag: str) -> str:
        texts = (element.text for element in root.iter() if element.tag.rpartition("}")[2] == tag)
        found = next((text.strip() for text in texts if text and text.strip()), "")
        return "" if found in {"N/A", "Unknown"} else found

    source = ", ".join(word for word in map(said, ("Manufacturer", "CatalogNumber", "Description")) if word)
    column = said("SpectralQuantity") or "value"
    return SampledCurves(name, table[:, 0], table[:, 1:].T, (column,), source=source)


def _ampas_json(text: str, name: str) -> SampledCurves:
    """AMPAS JSON: {"spectral_data": {"index": {"main": [...]}, "data": {"main": {"380": [r, g, b], ...}}}}."""
    try:
        document = json.loads(text)
        spectral = document["spectral_data"]
        columns = tuple(str(column) for column in spectral["index"]["main"])
        rows = sorted(
            (float(nm), *(np.nan if value is None else float(value) for value in values))
            for nm, values in spectral["data"]["main"].items()
        )
        header = document.get("header") or {}
        said = {key: str(value) for key, value in header.items() if isinstance(value, str)}
        if not rows or any(len(row) != len(columns) + 1 for row in rows):
            raise ValueError(name)
    except (KeyError, TypeError, ValueError, OverflowError, AttributeError, RecursionError):
        raise SpectralDataError(
            f"{name} is not a file in AMPAS JSON (spectral_data with index and data, a value a column)."
        ) from None
    table = np.array(rows, float)
    source = ", ".join(
        said[key] for key in ("laboratory", "document_creator", "catalog_number") if said.get(key)
    )
    title = " ".join(said[key] for key in ("manufacturer", "model") if said.get(key))
    return SampledCurves(name, table[:, 0], table[:, 1:].T, columns, said.get("license", ""), source, title)

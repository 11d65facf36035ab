"""Tables of spectra as plain text: CSV of every country, two-column SPD, spectrometers' own exports, CGATS.

Commas, semicolons, tabs or blanks stand between the cells, and a comma may be the decimal mark. What comes before the
first row of numbers is heading, what comes after the last is not read.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Sequence

import numpy as np

from ..errors import SpectralDataError
from ..spectra.curves import SampledCurves

_COMMENTS = ("#", "//", "!")
_MISSING = frozenset({"", "-", "--", "na", "n/a", "#n/a", "nan", "inf", "-inf", "+inf", "null", "none"})
_LABELLED = re.compile(r"(?:spectral data\s+)?(\d+(?:\.\d+)?)\s*\[?nm\]?", re.IGNORECASE)  # Sekonic, UPRtek
_CGATS_FIELD = re.compile(r"(?:spectral_|spectral_nm_?|nm_?)(\d{3,4})|(\d{3,4})nm", re.IGNORECASE)

type Split = Callable[[str], list[str]]


def parse_text(text: str, name: str) -> SampledCurves:
    r"""Curves of a text; `name` is what error messages call it.

    Raises
    ------
    SpectralDataError
        If there are no rows of numbers, or what stands between them is none.

    Examples
    --------
    >>> curves = parse_text("nm;Klarglas\n400;0,91\n405;0,92\n", "glas.csv")
    >>> curves.columns, curves.values.tolist()
    (('Klarglas',), [[0.91, 0.92]])
    """
    if "BEGIN_DATA_FORMAT" in text:
        return _cgats(text, name)
    lines = [line.strip() for line in text.splitlines()]
    lines = [line for line in lines if line and not line.startswith(_COMMENTS)]
    split = _layout(lines, name)
    parsed = [_row(split(line)) for line in lines]
    is_row = [row is not None for row in parsed]
    first, last = is_row.index(True), len(is_row) - is_row[::-1].index(True)
    rows = []
    for line, row in zip(lines[first:last], parsed[first:last], strict=True):
        if row is not None:
            rows.append(row)
        elif not _LABELLED.match(lines[first]):  # an instrument may put headings between its tables
            raise SpectralDataError(
                f'{name} has a line among its numbers that is none: "{line[:60]}". Correct or delete it.'
            )
    rows = _last_table(rows) if _LABELLED.match(lines[first]) else rows
    table = _rectangular(rows, name)
    heading = split(lines[first - 1]) if first and not _LABELLED.match(lines[first]) else []
    columns = [cell.strip().strip('"') for cell in heading[1:]]
    if len(columns) != table.shape[1] - 1 or not all(columns):
        columns = [f"value {number}" for number in range(1, table.shape[1])]
    return SampledCurves(name, table[:, 0], table[:, 1:].T, tuple(columns), *_passport(text))


def _layout(lines: Sequence[str], name: str) -> Split:
    """How cells are separated, from the first line that is a row of numbers."""

    def comma(line: str) -> list[str]:
        try:
            return next(csv.reader([line], skipinitialspace=True))
        except csv.Error:  # a cell longer than any number
            return []

    for line in lines:
        blanks = [] if re.search(r",\s|\s,", line) else [str.split]
        for split in (lambda text: text.split(";"), lambda text: text.split("\t"), *blanks, comma):
            row = _row(split(line))
            if row is not None and np.isfinite(row[1]):
                return split
    raise SpectralDataError(
        f"{name} has no table of a spectrum. Give rows of a wavelength in nm and a value, separated by commas."
    )


def _row(cells: Sequence[str]) -> list[float] | None:
    """Numbers of a row, not-a-number for a cell that is missing; None where it is no row of numbers."""
    cells = [
        cell.strip().strip('"').strip().replace(",", ".") for cell in cells
    ]  # what is left is a decimal comma
    if len(cells) < 2:
        return None
    labelled = _LABELLED.fullmatch(cells[0])
    wavelength = _number(labelled[1] if labelled else cells[0])
    if wavelength is None or not np.isfinite(wavelength):
        return None
    values = [_number(cell) for cell in cells[1:]]
    return (
        None
        if any(value is None for value in values)
        else [wavelength, *(v for v in values if v is not None)]
    )


def _number(cell: str) -> float | None:
    if cell.lower() in _MISSING:
        return np.nan
    try:
        return float(cell)
    except ValueError:
        return None


def _last_table(rows: list[list[float]]) -> list[list[float]]:
    """The last of several tables in one export: Sekonic's 1 nm table follows its 5 nm table."""
    starts = [at for at in range(1, len(rows)) if rows[at][0] < rows[at - 1][0]]
    return rows[starts[-1] :] if starts else rows


def _rectangular(
    rows: Sequence[Sequence[float]], name: str
) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    if all(np.isnan(row[-1]) and len(row) > 2 for row in rows):  # every line ends in a separator
        rows = [row[:-1] for row in rows]
    width = len(rows[0])
    for row in rows:
        if len(row) != width:
            raise SpectralDataError(
                f"{name} has {len(row) - 1} value(s) at {row[0]:g} nm, but {width - 1} at {rows[0][0]:g} nm. "
                "Give every row the same columns."
            )
    return np.array(rows, float)


def _cgats(text: str, name: str) -> SampledCurves:
    """Samples of a CGATS table (X-Rite's exports): one row a sample, one field a wavelength."""

    def block(begin: str, end: str) -> list[list[str]]:
        inside = re.search(rf"^{begin}\s*$(.*?)^{end}\s*$", text, re.MULTILINE | re.DOTALL)
        lines = inside[1].splitlines() if inside else []
        return [re.findall(r'"[^"]*"|\S+', line) for line in lines if line.strip()]

    fields = [field for line in block("BEGIN_DATA_FORMAT", "END_DATA_FORMAT") for field in line]
    bands = [(at, _CGATS_FIELD.fullmatch(field)) for at, field in enumerate(fields)]
    spectral = [(at, float(match[1] or match[2])) for at, match in bands if match]
    samples = block("BEGIN_DATA", "END_DATA")
    if not spectral or not samples or any(len(sample) != len(fields) for sample in samples):
        raise SpectralDataError(
            f"{name} has no spectral fields, or rows that do not have them all. Export it with spectra (nm380, nm390, ...)."
        )
    named = next((at for at, field in enumerate(fields) if field.upper() == "SAMPLE_NAME"), 0)
    values = [[_number(sample[at]) for at, _ in spectral] for sample in samples]
    table = np.array([[np.nan if value is None else value for value in row] for row in values])
    return SampledCurves(
        name,
        np.array([nm for _, nm in spectral]),
        table,
        tuple(sample[named].strip('"') for sample in samples),
    )


def _passport(text: str) -> tuple[str, str]:
    """What the comments at the top say of licence and source ("# licence: ...")."""

    def said(key: str) -> str:
        found = re.search(rf"^\s*(?:#|//|!)\s*{key}\s*[:=]\s*(.+)$", text, re.MULTILINE | re.IGNORECASE)
        return found[1].strip() if found else ""

    return said("licen[cs]e"), said("source")

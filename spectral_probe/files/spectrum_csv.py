"""Tables of spectra as text: a column of wavelengths in nm and one or more columns of values."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from ..errors import SpectralDataError
from ..model import FloatArray
from ..spectra.grid import WAVELENGTHS_NM, resample


def read_spectrum_csv(path: Path, columns: int = 1) -> FloatArray:
    """Read values of a table at `WAVELENGTHS_NM`.

    Parameters
    ----------
    path
        Rows of wavelength in nm and values, separated by commas, semicolons or tabs. Lines that do not start with a number
        (headings, comments) are passed over.
    columns
        Number of value columns wanted.

    Returns
    -------
    ndarray
        (columns, 61), piecewise linear between the rows.

    Raises
    ------
    SpectralDataError
        If the file cannot be read, has too few columns, or does not cover 400-700 nm.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError):
        raise SpectralDataError(
            f"{path} cannot be read. Give a CSV file with wavelengths in nm and values."
        ) from None
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    numeric = next((line for line in lines if line.lstrip()[:1].isdigit()), "")
    separator = next((mark for mark in (";", "\t") if mark in numeric), ",")
    rows = []
    for row in csv.reader(lines, delimiter=separator):
        try:
            numbers = [float(cell) for cell in row[: columns + 1]]
        except ValueError:
            continue
        if len(numbers) == columns + 1:
            rows.append(numbers)
    if len(rows) < 2 or not np.isfinite(rows).all():
        raise SpectralDataError(
            f"{path.name} needs rows of a wavelength in nm and {columns} value(s), separated by commas."
        )
    table = np.array(rows)
    return resample(table[:, 0], table[:, 1:].T, WAVELENGTHS_NM, name=path.name)

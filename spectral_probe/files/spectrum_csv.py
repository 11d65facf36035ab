"""Columns of numbers over wavelength, on the exchange grid; any file that `spectrum_file` reads will do."""

from __future__ import annotations

from pathlib import Path

from ..model import FloatArray
from ..spectra.curves import NUMBER
from .spectrum_file import read_curves


def read_spectrum_csv(path: Path, columns: int = 1, quantity: str = NUMBER) -> FloatArray:
    """Read values of a table at `WAVELENGTHS_NM`.

    Parameters
    ----------
    path
        Rows of wavelength in nm and values, or another file of `spectrum_file.read_samples`.
    columns
        Number of value columns wanted.
    quantity
        What the values are: `LIGHT`, `REFLECTANCE`, `TRANSMITTANCE`, `SENSITIVITY` of `spectra.curves`, which are checked, or
        `NUMBER`, which may be anything finite.

    Returns
    -------
    ndarray
        (columns, 61): band means of a table finer than 5 nm, straight lines between the rows of a coarser one.

    Raises
    ------
    SpectralDataError
        If the file cannot be read, has too few columns, does not cover 400-700 nm without gaps, or its values cannot be.
    """
    return read_curves(path, quantity, columns)

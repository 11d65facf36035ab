"""Spectra as somebody tabulated them: what a table must be to be used, and how it comes onto the exchange grid.

A table finer than the grid is averaged over each band, so that a line keeps its power; a coarser one is interpolated.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..errors import SpectralDataError
from ..model import FloatArray
from .grid import STEP_NM, WAVELENGTHS_NM

LIGHT, REFLECTANCE, TRANSMITTANCE = "spectral power", "reflectance", "transmittance"
SENSITIVITY, NUMBER = "sensitivity", "number"
"""What the values of a table are. A number is anything else, a refractive index for example: only its wavelengths and
its being finite are checked."""

LARGEST_GAP_NM = 25.0
"""Rows of a table may be this far apart within 400-700 nm, unless it is as coarse throughout: then somebody wrote it so.
ASTM E308 has no weights for tables coarser than 20 nm."""

_NOISE = 0.02
"""Values below zero, or above a reflectance of one, by up to this share of the scale are an instrument's noise."""

_SCALES = (1e-20, 1e20)
"""Powers and sensitivities peak between these, whatever their unit; beyond lie broken exponents."""

_PERCENT = 2.0
"""No passive surface comes near a fraction of this; a table in percent of anything but soot goes beyond."""


@dataclass(frozen=True)
class SampledCurves:
    """Curves as tabulated: `values` (M, N) at `wavelengths_nm` (N,), called `columns` (M,), from the table `name`.

    `licence`, `source` and `title` (a camera's manufacturer and model) are what the file says of itself, empty where it says
    nothing.
    """

    name: str
    wavelengths_nm: FloatArray
    values: FloatArray
    columns: tuple[str, ...]
    licence: str = ""
    source: str = ""
    title: str = ""

    @property
    def range_nm(self) -> tuple[float, float]:
        """First and last wavelength."""
        return float(self.wavelengths_nm.min()), float(self.wavelengths_nm.max())


def checked(curves: SampledCurves, quantity: str) -> SampledCurves:
    """The curves with ascending wavelengths, noise below zero or above one taken off.

    Parameters
    ----------
    curves
        As read from a file.
    quantity
        `LIGHT`, `REFLECTANCE`, `TRANSMITTANCE`, `SENSITIVITY` or `NUMBER`.

    Raises
    ------
    SpectralDataError
        If wavelengths are not in nm, not ascending, listed twice, do not cover 400-700 nm or leave a gap there; or if
        values are missing, negative, in percent, above one where they are fractions, or zero throughout.

    Examples
    --------
    >>> glass = SampledCurves("red.csv", np.array([400.0, 700.0]), np.array([[2.0, 91.0]]), ("T",))
    >>> checked(glass, TRANSMITTANCE)  # doctest: +IGNORE_EXCEPTION_DETAIL
    Traceback (most recent call last):
    ...
    spectral_probe.errors.SpectralDataError: red.csv seems to be in percent (91 at 700 nm). ...
    """
    curves = _ascending(curves)
    _check_wavelengths(curves)
    if quantity == SENSITIVITY:
        curves = _with_dark_end(curves)
    _check_cover(curves)
    _check_finite(curves)
    return curves if quantity == NUMBER else _checked_values(curves, quantity)


def on_grid(curves: SampledCurves, quantity: str) -> FloatArray:
    """The curves at `WAVELENGTHS_NM`, (M, 61), after `checked`."""
    curves = checked(curves, quantity)
    return to_grid(curves.wavelengths_nm, curves.values)


def to_grid(wavelengths_nm: FloatArray, values: FloatArray) -> FloatArray:
    """Tabulated curves at `WAVELENGTHS_NM`: band means of a table finer than the grid, else interpolated.

    Parameters
    ----------
    wavelengths_nm
        (N,) ascending, without repetition; constant continuation is taken beyond the ends.
    values
        (..., N).

    Returns
    -------
    ndarray
        (..., 61). From a finer table, the mean over 2.5 nm on both sides of each wavelength of the straight lines between
        the rows: the sum over the grid times 5 nm is the integral, however narrow a line is.

    Examples
    --------
    >>> fine = np.arange(390.0, 711.0)
    >>> line = np.where(fine == 546, 10.0, 0.0)  # 10 units in 1 nm
    >>> float((to_grid(fine, line) * STEP_NM).sum().round(9))
    10.0
    """
    known, values = np.asarray(wavelengths_nm, float), np.asarray(values, float)
    rows = values.reshape(-1, len(known))
    inside = (known >= WAVELENGTHS_NM[0] - STEP_NM) & (known <= WAVELENGTHS_NM[-1] + STEP_NM)
    steps = np.diff(known[inside])
    if steps.size and np.median(steps) < 0.9 * STEP_NM:
        edges = np.append(WAVELENGTHS_NM - STEP_NM / 2, WAVELENGTHS_NM[-1] + STEP_NM / 2)
        means = [_band_means(known, row, edges) for row in rows]
    else:
        means = [np.interp(WAVELENGTHS_NM, known, row) for row in rows]
    return np.stack(means).reshape((*values.shape[:-1], len(WAVELENGTHS_NM)))


def _band_means(known: FloatArray, row: FloatArray, edges: FloatArray) -> FloatArray:
    """Means of straight lines through (N,) samples over bands, taken over the part of a band that the table covers."""
    cumulative = np.append(0.0, np.cumsum(np.diff(known) * (row[1:] + row[:-1]) / 2))
    at = np.clip(edges, known[0], known[-1])
    below = np.clip(np.searchsorted(known, at, side="right") - 1, 0, len(known) - 2)
    integral = cumulative[below] + (at - known[below]) * (row[below] + np.interp(at, known, row)) / 2
    width = np.diff(at)
    return np.where(
        width > 0,
        np.diff(integral) / np.where(width > 0, width, 1.0),
        row[[0, -1]][(edges[:-1] > known[0]).astype(int)],
    )


# ---------------------------------------------------------------- wavelengths


def _ascending(curves: SampledCurves) -> SampledCurves:
    """A table that runs down from the longest wavelength is turned round; one that runs up and down is not guessed at."""
    nm = curves.wavelengths_nm
    if len(nm) < 2:
        raise SpectralDataError(
            f"{curves.name} has no table of a spectrum. Give rows of a wavelength in nm and a value."
        )
    if not np.isfinite(nm).all():
        raise SpectralDataError(f"{curves.name} has a row without a wavelength. Complete or delete it.")
    values, counts = np.unique(nm, return_counts=True)
    if (counts > 1).any():
        raise SpectralDataError(
            f"{curves.name} lists a wavelength twice ({values[counts > 1][0]:g} nm). Keep one row a wavelength."
        )
    if (np.diff(nm) < 0).all():
        return replace(curves, wavelengths_nm=nm[::-1], values=curves.values[:, ::-1])
    back = np.flatnonzero(np.diff(nm) < 0)
    if back.size:
        here = back[0] if len(back) < len(nm) / 2 else np.flatnonzero(np.diff(nm) > 0)[0]
        raise SpectralDataError(
            f"The wavelengths of {curves.name} do not ascend: after {nm[here]:g} comes {nm[here + 1]:g}. "
            "Sort the rows, and where two scans overlap keep one."
        )
    return curves


def _check_wavelengths(curves: SampledCurves) -> None:
    first, last = curves.range_nm
    for smallest, largest, unit, remedy in (
        (0.0, 1e-6, "metres", "multiply them by 1e9"),
        (0.0, 1.0, "micrometres", "multiply them by 1000"),
        (3000.0, np.inf, "angstroms", "divide them by 10"),
    ):
        if smallest < first < largest and last < 10 * largest:
            raise SpectralDataError(
                f"The wavelengths of {curves.name} run from {first:g} to {last:g}, which looks like {unit}. "
                f"Give them in nm: {remedy}."
            )


def _with_dark_end(curves: SampledCurves) -> SampledCurves:
    """Sensitivities that end short of 400 or 700 nm below 1 % of their peak go on as zero."""
    nm, values = curves.wavelengths_nm, curves.values
    peaks = np.nanmax(values, axis=1, initial=0.0)
    if nm[0] > WAVELENGTHS_NM[0] and (values[:, 0] < 0.01 * peaks).all():
        nm = np.append([WAVELENGTHS_NM[0], nm[0] - 1e-3], nm)
        values = np.pad(values, ((0, 0), (2, 0)))
    if nm[-1] < WAVELENGTHS_NM[-1] and (values[:, -1] < 0.01 * peaks).all():
        nm = np.append(nm, [nm[-1] + 1e-3, WAVELENGTHS_NM[-1]])
        values = np.pad(values, ((0, 0), (0, 2)))
    return replace(curves, wavelengths_nm=nm, values=values)


def _check_cover(curves: SampledCurves) -> None:
    """The first and last band may be half covered: within them the end of the table stands for the rest."""
    first, last = float(WAVELENGTHS_NM[0]), float(WAVELENGTHS_NM[-1])
    known = curves.wavelengths_nm
    if known[0] > first + STEP_NM / 2 or known[-1] < last - STEP_NM / 2:
        raise SpectralDataError(
            f"{curves.name} covers {known[0]:g}-{known[-1]:g} nm, but {first:g}-{last:g} nm is needed. "
            "Give a file that covers it."
        )
    left, right = known[:-1], known[1:]
    inside = (right > first) & (left < last)
    gaps = np.where(inside, right - left, 0.0)
    widest = int(gaps.argmax())
    if gaps[widest] > max(LARGEST_GAP_NM, 1.1 * float(gaps[inside].min())):
        raise SpectralDataError(
            f"{curves.name} has no row between {left[widest]:g} and {right[widest]:g} nm. "
            f"Give rows at most {LARGEST_GAP_NM:g} nm apart; nobody knows what lies between."
        )


# ---------------------------------------------------------------- values


def _check_finite(curves: SampledCurves) -> None:
    missing = ~np.isfinite(curves.values)
    if missing.any():
        column, row = np.argwhere(missing)[0]
        raise SpectralDataError(
            f"{curves.name} has no number at {curves.wavelengths_nm[row]:g} nm{_of(curves, column)}. "
            "Complete or delete that row."
        )


def _of(curves: SampledCurves, column: int) -> str:
    return f' in column "{curves.columns[column]}"' if len(curves.values) > 1 else ""


def _checked_values(curves: SampledCurves, quantity: str) -> SampledCurves:
    """Values that can be: not negative, not dark throughout, fractions where they must be."""
    fraction = quantity in {REFLECTANCE, TRANSMITTANCE}
    values = curves.values
    if fraction:
        _check_fractions(curves, quantity)
    peaks = values.max(1)
    for column, peak in enumerate(peaks):
        lowest = int(values[column].argmin())
        if values[column, lowest] < -_NOISE * (1.0 if fraction else max(peak, 0.0)):
            raise SpectralDataError(
                f"{curves.name} has a negative {quantity} at {curves.wavelengths_nm[lowest]:g} nm"
                f"{_of(curves, column)} ({values[column, lowest]:g}). Correct the file; noise of up to 2 % is taken as 0."
            )
        if peak <= 0 and not fraction:  # black paint is legal, a lamp that is off is not a lamp
            raise SpectralDataError(
                f"{curves.name} has a {'channel' if quantity == SENSITIVITY else 'spectrum'} without any {quantity}"
                f"{_of(curves, column)}. Check its columns."
            )
        if not fraction and not _SCALES[0] < peak < _SCALES[1]:
            raise SpectralDataError(
                f"{curves.name} has values up to {peak:.3g}{_of(curves, column)}, which no unit of {quantity} gives. "
                "Scale them to about 1."
            )
    return replace(curves, values=np.clip(values, 0.0, 1.0 if fraction else None))


def _check_fractions(curves: SampledCurves, quantity: str) -> None:
    column, row = np.unravel_index(curves.values.argmax(), curves.values.shape)
    largest, at_nm = float(curves.values[column, row]), curves.wavelengths_nm[row]
    if largest > _PERCENT:
        raise SpectralDataError(
            f"{curves.name} seems to be in percent ({largest:g} at {at_nm:g} nm). "
            f"Divide it by 100: a {quantity} is a fraction from 0 to 1."
        )
    if largest > 1.0 + _NOISE:
        raise SpectralDataError(
            f"{curves.name} has a {quantity} above 1 ({largest:g} at {at_nm:g} nm): it would give more light than it "
            "gets. Correct the file, or divide it by 100 if it is in percent."
        )
    for name in curves.columns:
        if "%" in name or "percent" in name.lower():
            raise SpectralDataError(
                f'{curves.name} calls its values "{name}". Give a {quantity} as a fraction from 0 to 1.'
            )

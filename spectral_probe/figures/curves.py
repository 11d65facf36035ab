"""Plots of sets of curves: a basis (fig. 7 of the paper) and a camera's sensitivities (fig. 2)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..errors import SpectralDataError
from ..model import FloatArray
from .numbers import wrapped
from .spectrum import wavelength_axis
from .style import CURVE_COLOURS, RGB_COLOURS, RULE, axes_at, house_style, new_figure

_STROKES: Sequence[Any] = ("solid", (0, (4.2, 1.6)), (0, (1.3, 1.1)))
"""Line styles of the shots through filters."""

_SIDE_LEGEND_FROM = 5  # so many curves have their names beside the plot, where they hide nothing


def basis_figure(
    wavelengths_nm: FloatArray, basis: FloatArray, *, title: str = "Basis of the light's spectra"
) -> Figure:
    """The basis functions E_1 .. E_K of eq. 7 (fig. 7 of the paper); `basis` is (K, L).

    More than four are drawn three to a panel, in their order, with one scale: more in one would hide each other.
    """
    basis = np.asarray(basis, float)
    looks = [(f"E{subscript(index + 1)}", CURVE_COLOURS[index % 3], "solid") for index in range(len(basis))]
    if len(basis) <= 4:
        looks = [(name, CURVE_COLOURS[index], "solid") for index, (name, *_) in enumerate(looks)]
        return _curves_figure(wavelengths_nm, basis, looks, title, "basis function")
    return _panels_figure(np.asarray(wavelengths_nm), basis, looks, title)


def _panels_figure(
    wavelengths_nm: FloatArray, basis: FloatArray, looks: Sequence[tuple[str, str, Any]], title: str
) -> Figure:
    """Basis functions three to a panel, two panels a row."""
    panels = [range(first, min(first + 3, len(basis))) for first in range(0, len(basis), 3)]
    width_in, plot_in, row_in = 8.4, (3.55, 1.45), 2.0
    with house_style():
        heading = wrapped(title.split(" "), width_in - 0.82, " ", fontsize=11, fontweight="bold")
        top_in = 0.55 + 0.2 * (len(heading) - 1)
        height_in = top_in + row_in * ((len(panels) + 1) // 2) + 0.1
        figure = new_figure(width_in, height_in)
        lowest, highest = _limits(basis)
        limits = (lowest, highest + 0.16 * (highest - lowest))  # room for the names
        for number, panel in enumerate(panels):
            row, column = divmod(number, 2)
            axes = axes_at(figure, 0.62 + 4.02 * column, top_in + row_in * row, *plot_in)
            for index in panel:
                name, colour, stroke = looks[index]
                axes.plot(wavelengths_nm, basis[index], color=colour, label=name, linestyle=stroke)
            axes.set_ylim(limits)
            axes.axhline(0, color=RULE, linewidth=0.6, zorder=0)
            axes.legend(loc="upper left", ncols=3, handlelength=1.6, borderaxespad=0.0, columnspacing=1.2)
            if column == 0:
                axes.set_ylabel("basis function")
            last = number >= len(panels) - 2
            wavelength_axis(axes, wavelengths_nm, label=last)
        _heading(figure, heading)
    return figure


def _heading(figure: Figure, lines: Sequence[str]) -> None:
    width_in, height_in = figure.get_size_inches()
    for index, line in enumerate(lines):
        baseline = 1 - (0.32 + 0.2 * index) / height_in
        figure.text(0.62 / width_in, baseline, line, fontsize=11, fontweight="bold", va="baseline")


def _limits(curves: FloatArray) -> tuple[float, float]:
    """The range of curves with a margin; from 0 where none is negative."""
    lowest, highest = min(0.0, float(np.min(curves))), float(np.max(curves))
    margin = 0.06 * (highest - lowest or 1.0)
    return lowest - (margin if lowest < 0 else 0.0), highest + margin


def sensitivities_figure(
    wavelengths_nm: FloatArray,
    sensitivities: FloatArray,
    *,
    shots: Sequence[str] = (),
    title: str = "Spectral sensitivities of the camera",
) -> Figure:
    """A camera's spectral sensitivities (fig. 2 of the paper), alone and through filters.

    Parameters
    ----------
    wavelengths_nm
        (L,).
    sensitivities
        (L, 3) for R, G, B; (L, 6) or (L, 9) with those through one or two filters after them.
    shots
        What each three were taken through, such as ["no filter", "Wratten 58"].
    title
        The heading.

    Raises
    ------
    SpectralDataError
        If there are not 3, 6 or 9 channels.
    """
    curves = np.asarray(sensitivities, float).T
    if len(curves) not in (3, 6, 9):
        raise SpectralDataError(
            f"A camera has 3, 6 or 9 channels, not {len(curves)}. Give R, G, B for each filter."
        )
    shot_count = len(curves) // 3
    names = [*shots, *(f"filter {number}" for number in range(len(shots), shot_count))][:shot_count]
    if not shots:
        names[0] = "no filter"
    looks = [
        (letter if shot_count == 1 else f"{letter}  {name}", colour, _STROKES[shot])
        for shot, name in enumerate(names)
        for letter, colour in zip("RGB", RGB_COLOURS, strict=True)
    ]
    peak = float(curves.max())
    return _curves_figure(
        wavelengths_nm, curves / (peak if peak > 0 else 1.0), looks, title, "relative sensitivity"
    )


def subscript(number: int) -> str:
    """A whole number in subscript digits.

    Examples
    --------
    >>> subscript(10)
    '₁₀'
    """
    return "".join(chr(0x2080 + int(digit)) for digit in str(number))


def _curves_figure(
    wavelengths_nm: FloatArray,
    curves: FloatArray,
    looks: Sequence[tuple[str, str, Any]],
    title: str,
    ylabel: str,
) -> Figure:
    """Curves (N, L) in one plot; `looks` are their names, colours and line styles."""
    with house_style():
        heading = wrapped(title.split(" "), 5.18, " ", fontsize=11, fontweight="bold")
        top_in = 0.55 + 0.2 * (len(heading) - 1)
        beside = len(looks) >= _SIDE_LEGEND_FROM
        side_in = _legend_width_in(looks) if beside else 0.0
        width_in, height_in = 6.0 + max(0.0, side_in - 0.6), top_in + 3.05
        figure = new_figure(width_in, height_in)
        axes = axes_at(figure, 0.62, top_in, width_in - 0.82 - side_in, 2.38)
        for curve, (label, colour, stroke) in zip(curves, looks, strict=True):
            axes.plot(wavelengths_nm, curve, color=colour, label=label, linestyle=stroke)
        axes.set_ylim(_limits(curves))
        if float(np.min(curves)) < 0:
            axes.axhline(0, color=RULE, linewidth=0.6, zorder=0)
        axes.set_ylabel(ylabel)
        where = {"loc": "upper left", "bbox_to_anchor": (1.02, 1.02)} if beside else {"loc": "best"}
        axes.legend(handlelength=2.3, borderaxespad=0.2, labelspacing=0.34, **where)
        wavelength_axis(axes, np.asarray(wavelengths_nm))
        _heading(figure, heading)
    return figure


def _legend_width_in(looks: Sequence[tuple[str, str, Any]]) -> float:
    """Width that the names need beside the plot, with the strokes before them."""
    sample = new_figure(1.0, 1.0)
    widths = [sample.text(0, 0, name, fontsize=7.5).get_window_extent().width for name, *_ in looks]
    return 0.55 + max(widths) / sample.dpi

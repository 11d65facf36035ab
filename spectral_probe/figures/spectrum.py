"""Plots of spectra, estimated against measured, with the band of uncertainty: figs. 10 and 11 of the paper."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, MultipleLocator

from ..model import FloatArray
from ..spectra.colorimetry import colour_matching_functions, xyz_to_rec709
from ..spectra.grid import WAVELENGTHS_NM
from ..spectra.metrics import scaled_to_energy
from .display import Picture, srgb_encoded
from .numbers import comparison_lines, spectrum_numbers, wrapped
from .style import BLUE, INK, RULE, SOFT_INK, axes_at, house_style, new_figure

__all__ = ["SpectrumPlot", "draw_spectrum", "spectrum_figure", "spectrum_numbers", "wavelength_axis"]

WIDTH_IN = 6.0
_LEFT_IN = 0.62
_PLOT_IN = (5.18, 2.42)
_LINE_IN = 0.19
_FAMILY_IN = 0.17
_FAMILIES_SHOWN = 4
_TALLEST_BAND = (
    2.2  # times the curves: a band that reaches higher leaves the plot, so that the curves stay legible
)


@dataclass(frozen=True)
class SpectrumPlot:
    """What one plot of a spectrum shows.

    `estimated` (L,) is the recovered spectrum, `measured` (L,) the true or measured one, `band` (2, L) the
    lower and upper bound of the estimate; all on `wavelengths_nm` (L,). `bearing_deg` is the (azimuth,
    elevation) it was read at, as a compass bearing. `measured_label` says what the measured spectrum is, such
    as "true", and `band_label` what the band is, such as "95 % band".
    """

    title: str
    wavelengths_nm: FloatArray
    estimated: FloatArray
    measured: FloatArray | None = None
    band: FloatArray | None = None
    bearing_deg: tuple[float, float] | None = None
    measured_label: str = "measured"
    band_label: str = "uncertainty"


def spectrum_figure(
    wavelengths_nm: FloatArray,
    estimated: FloatArray,
    measured: FloatArray | None = None,
    band: FloatArray | None = None,
    *,
    title: str = "",
    band_label: str = "uncertainty",
    numbers: Iterable[Mapping[str, str]] | None = None,
    families: Mapping[str, float] | None = None,
) -> Figure:
    """Estimated spectrum against the measured one, as figs. 10 and 11 of the paper.

    Parameters
    ----------
    wavelengths_nm
        (L,).
    estimated
        (L,) recovered spectrum, in any unit.
    measured
        (L,) measured spectrum. The estimate is scaled to its energy and its peak becomes 1.
    band
        (2, L) lower and upper bound of the estimate, in its unit.
    title
        What was measured.
    band_label
        What the band is, such as "95 % band".
    numbers
        Lines of text by name for below the title; by default `comparison_lines`.
    families
        Probabilities of lamp families; the likeliest are shown as bars below the plot.

    Returns
    -------
    Figure
    """
    plot = SpectrumPlot(title, wavelengths_nm, estimated, measured, band, band_label=band_label)
    groups = comparison_lines(wavelengths_nm, estimated, measured) if numbers is None else numbers
    shown = _likeliest(families or {})
    families_in = 0.42 + _FAMILY_IN * len(shown) if shown else 0.0
    with house_style():
        heading = wrapped([*title.split(" ")], _PLOT_IN[0], " ", fontsize=11, fontweight="bold")
        lines = [
            line
            for group in groups
            for line in wrapped(
                [f"{name}\N{NO-BREAK SPACE} {value}" for name, value in group.items()], _PLOT_IN[0], "    "
            )
        ]
        top_in = 0.30 + 0.2 * (len(heading) - 1) + 0.24 + _LINE_IN * len(lines)
        height_in = top_in + _PLOT_IN[1] + 0.62 + families_in
        figure = new_figure(WIDTH_IN, height_in)
        for index, line in enumerate(heading):
            _text(figure, 0.30 + 0.2 * index, line, fontsize=11, fontweight="bold")
        for index, line in enumerate(lines):
            _text(figure, 0.30 + 0.2 * (len(heading) - 1) + 0.24 + _LINE_IN * index, line, color=SOFT_INK)
        draw_spectrum(axes_at(figure, _LEFT_IN, top_in, *_PLOT_IN), plot)
        if shown:
            _draw_families(figure, shown, top_in + _PLOT_IN[1] + 0.62)
    return figure


def _text(figure: Figure, top_in: float, text: str, **style: object) -> None:
    height_in = figure.get_size_inches()[1]
    figure.text(_LEFT_IN / WIDTH_IN, 1 - top_in / height_in, text, va="baseline", **style)  # type: ignore[arg-type]  # matplotlib's own


def _likeliest(families: Mapping[str, float]) -> dict[str, float]:
    """The likeliest families, and the others together.

    Examples
    --------
    >>> _likeliest({"a": 0.5, "b": 0.2, "c": 0.1, "d": 0.1, "e": 0.06, "f": 0.04})
    {'a': 0.5, 'b': 0.2, 'c': 0.1, 'd': 0.1, 'others': 0.1}
    """
    ordered = sorted(families.items(), key=lambda item: -item[1])
    others = sum(share for _, share in ordered[_FAMILIES_SHOWN:])
    return dict(ordered[:_FAMILIES_SHOWN]) | (
        {"others": round(others, 9)} if len(ordered) > _FAMILIES_SHOWN else {}
    )


def _draw_families(figure: Figure, shares: Mapping[str, float], top_in: float) -> None:
    """Bars of the probabilities of lamp families, from 0 to 1."""
    names_in = 1.6
    _text(figure, top_in + 0.1, "What kind of light this probably is", color=SOFT_INK)
    axes = axes_at(
        figure, _LEFT_IN + names_in, top_in + 0.2, _PLOT_IN[0] - names_in - 0.5, _FAMILY_IN * len(shares)
    )
    rows = np.arange(len(shares))
    values = np.clip(list(shares.values()), 0.0, 1.0)
    axes.barh(rows, np.ones(len(shares)), height=0.55, color=RULE, alpha=0.45, linewidth=0)
    axes.barh(rows, values, height=0.55, color=BLUE, linewidth=0)
    for row, value in enumerate(values):
        axes.text(1.012, row, _percent(float(value)), va="center", fontsize=7.5)
    axes.set_xlim(0, 1)
    axes.set_ylim(len(shares) - 0.5, -0.5)
    axes.set_xticks([])
    axes.set_yticks(rows, list(shares))
    axes.tick_params(length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)


def _percent(share: float) -> str:
    """A probability in percent, with the sign of the limit where it rounds to none or all.

    Examples
    --------
    >>> _percent(0.125), _percent(0.0003), _percent(0.9999)
    ('12 %', '< 1 %', '> 99 %')
    """
    if 0 < share < 0.005:
        return "< 1 %"
    return "> 99 %" if 0.995 < share < 1 else f"{100 * share:.0f} %"


def draw_spectrum(axes: Axes, plot: SpectrumPlot, *, axis_labels: bool = True) -> None:
    """Draw one spectrum into axes: estimated, measured, band, and the wavelengths' colours under them."""
    estimated, measured, band = _normalised(plot)
    nm = plot.wavelengths_nm
    if band is not None:
        axes.fill_between(nm, band[0], band[1], color=BLUE, alpha=0.16, linewidth=0, label=plot.band_label)
    if measured is not None:
        axes.plot(nm, measured, color=INK, linewidth=3.4, alpha=0.28, label=plot.measured_label)
    axes.plot(nm, estimated, color=BLUE, linewidth=1.5, label="estimated")
    lowest, highest = _limits(estimated, measured, band)
    axes.set_ylim(1.06 * lowest, 1.06 * highest)
    if lowest < 0:
        axes.axhline(0, color=RULE, linewidth=0.6, zorder=0)
    axes.legend(loc="best", handlelength=1.6, borderaxespad=0.2, labelspacing=0.3)
    axes.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 2.5, 5, 10]))
    if axis_labels:
        axes.set_ylabel("relative spectral radiance")
    wavelength_axis(axes, nm, label=axis_labels)


def _limits(
    estimated: FloatArray, measured: FloatArray | None, band: FloatArray | None
) -> tuple[float, float]:
    """The lowest and the highest value shown: all of the curves, and the band as far as it lets them be seen."""
    curves = np.concatenate([estimated, [0.0, 1.0], [] if measured is None else measured])
    lowest, highest = float(np.nanmin(curves)), float(np.nanmax(curves))
    if band is not None and np.isfinite(band).any(axis=-1).all():
        lowest = min(lowest, max(float(np.nanmin(band[0])), (1 - _TALLEST_BAND) * highest))
        highest = max(highest, min(float(np.nanmax(band[1])), _TALLEST_BAND * highest))
    return lowest, highest


def _normalised(plot: SpectrumPlot) -> tuple[FloatArray, FloatArray | None, FloatArray | None]:
    """Estimate, measurement and band on one scale: the measured peak, else the estimated one, is 1."""
    estimated = np.asarray(plot.estimated, float)
    reference = estimated if plot.measured is None else np.asarray(plot.measured, float)
    matched = scaled_to_energy(estimated, reference)
    peak = float(reference.max())
    unit = 1 / peak if peak > 0 else 1.0
    total = float(estimated.sum())
    factor = unit * (float(matched.sum()) / total if total > 0 else 1.0)
    band = None if plot.band is None else np.asarray(plot.band, float) * factor
    return estimated * factor, None if plot.measured is None else reference * unit, band


def wavelength_axis(axes: Axes, wavelengths_nm: FloatArray, *, label: bool = True) -> None:
    """The horizontal axis in nm, with a strip of the wavelengths' colours under it."""
    first, last = float(wavelengths_nm.min()), float(wavelengths_nm.max())
    axes.set_xlim(first, last)
    axes.tick_params(axis="x", length=0, labelbottom=False)
    axes.spines["bottom"].set_visible(False)
    height_in = axes.get_position().height * axes.get_figure(root=True).get_size_inches()[1]  # type: ignore[union-attr]
    thickness = 0.075 / height_in
    strip = axes.inset_axes((0.0, -thickness, 1.0, thickness))
    strip.imshow(
        wavelength_colours(first, last), extent=(first, last, 0, 1), aspect="auto", interpolation="nearest"
    )
    strip.set_yticks([])
    strip.xaxis.set_major_locator(MultipleLocator(50))
    strip.tick_params(axis="x", pad=2.0)
    for spine in strip.spines.values():
        spine.set_visible(False)
    if label:
        strip.set_xlabel("wavelength (nm)", labelpad=2.0)


def wavelength_colours(first_nm: float, last_nm: float) -> Picture:
    """The colours of monochromatic light from one wavelength to another, (1, 4 per nm, 3) sRGB pixels.

    Their brightness follows the square root of the eye's response, so that the ends are dark but visible.
    """
    nm = np.linspace(first_nm, last_nm, max(2, round(4 * (last_nm - first_nm))))
    xyz = np.stack(
        [np.interp(nm, WAVELENGTHS_NM, row, left=0, right=0) for row in colour_matching_functions().T], -1
    )
    rgb = np.maximum(xyz_to_rec709(xyz), 0)  # no screen shows monochromatic light: the edge of its gamut
    peak = rgb.max(-1, keepdims=True)
    rgb = 0.85 * rgb + 0.15 * peak  # paler, so that the curves stay the loudest
    rgb = rgb / np.sqrt(np.maximum(peak, 1e-6) * peak.max())
    return np.asarray(np.rint(255 * srgb_encoded(np.clip(rgb, 0, 1))), np.uint8)[None]

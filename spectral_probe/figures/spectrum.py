"""Plots of spectra: estimated against measured, a basis, a camera's sensitivities.

They are figs. 10 and 11, 7 and 2 of the paper.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, MultipleLocator

from ..model import FloatArray
from ..spectra.colorimetry import colour_matching_functions, xyz_to_rec709
from ..spectra.grid import WAVELENGTHS_NM
from ..spectra.metrics import colour_temperature, goodness_of_fit, relative_rmse, scaled_to_energy
from .display import Picture, srgb_encoded
from .style import BLUE, CURVE_COLOURS, INK, RGB_COLOURS, RULE, SOFT_INK, axes_at, house_style, new_figure

MINUS, THIN_SPACE = "\N{MINUS SIGN}", "\N{THIN SPACE}"


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


def spectrum_numbers(
    wavelengths_nm: FloatArray,
    estimated: FloatArray,
    measured: FloatArray | None = None,
    measured_label: str = "measured",
) -> dict[str, str]:
    """The numbers beside a plot, as text: GFC, relative RMSE and correlated colour temperature.

    Examples
    --------
    >>> light = np.linspace(1.0, 2.0, 61)
    >>> spectrum_numbers(WAVELENGTHS_NM, 3 * light, light)["GFC"]
    '1.0000'
    """
    numbers = {}
    temperature = _kelvin(wavelengths_nm, estimated)
    if measured is not None:
        numbers["GFC"] = _goodness_text(float(goodness_of_fit(estimated, measured)))
        numbers["relative RMSE"] = f"{100 * float(relative_rmse(estimated, measured)):.1f}{THIN_SPACE}%"
        temperature += f" ({measured_label} {_kelvin(wavelengths_nm, measured)})"
    numbers["CCT"] = temperature
    return numbers


def _goodness_text(goodness: float) -> str:
    """Four decimals, rounded down: 1.0000 is said of no imperfect fit."""
    return f"{np.floor(goodness * 1e4 + 1e-6) / 1e4:.4f}"


def _kelvin(wavelengths_nm: FloatArray, spectrum: FloatArray) -> str:
    temperature = colour_temperature(spectrum, wavelengths_nm)
    return "undefined" if temperature is None else f"{temperature[0]:.0f}{THIN_SPACE}K"


def spectrum_figure(
    wavelengths_nm: FloatArray,
    estimated: FloatArray,
    measured: FloatArray | None = None,
    band: FloatArray | None = None,
    *,
    title: str = "",
    band_label: str = "uncertainty",
    numbers: Mapping[str, str] | None = None,
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
        What the band is, such as "± 1 standard error".
    numbers
        Text by name for the line below the title; by default GFC, relative RMSE and CCT.

    Returns
    -------
    Figure
    """
    plot = SpectrumPlot(title, wavelengths_nm, estimated, measured, band, band_label=band_label)
    with house_style():
        figure = new_figure(6.0, 3.9)
        axes = axes_at(figure, 0.62, 0.78, 5.18, 2.42)
        draw_spectrum(axes, plot)
        figure.text(0.62 / 6.0, 1 - 0.30 / 3.9, title, fontsize=11, fontweight="bold", va="baseline")
        shown = spectrum_numbers(wavelengths_nm, estimated, measured) if numbers is None else numbers
        figure.text(0.62 / 6.0, 1 - 0.55 / 3.9, numbers_line(shown), color=SOFT_INK, va="baseline")
    return figure


def numbers_line(numbers: Mapping[str, str]) -> str:
    """Numbers by name as one line of text."""
    return "     ".join(f"{name}  {value}" for name, value in numbers.items())


def draw_spectrum(axes: Axes, plot: SpectrumPlot, *, axis_labels: bool = True) -> None:
    """Draw one spectrum into axes: estimated, measured, band, and the wavelengths' colours under them."""
    estimated, measured, band = _normalised(plot)
    nm = plot.wavelengths_nm
    if band is not None:
        axes.fill_between(nm, band[0], band[1], color=BLUE, alpha=0.16, linewidth=0, label=plot.band_label)
    if measured is not None:
        axes.plot(nm, measured, color=INK, linewidth=3.4, alpha=0.28, label=plot.measured_label)
    axes.plot(nm, estimated, color=BLUE, linewidth=1.5, label="estimated")
    tops = [1.0, float(estimated.max())] + ([] if band is None else [float(band[1].max())])
    lowest = min(0.0, float(estimated.min()), 0.0 if band is None else float(band[0].min()))
    axes.set_ylim(1.06 * lowest, 1.06 * max(tops))
    if lowest < 0:
        axes.axhline(0, color=RULE, linewidth=0.6, zorder=0)
    axes.legend(loc="best", handlelength=1.6, borderaxespad=0.2, labelspacing=0.3)
    axes.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 2.5, 5, 10]))
    if axis_labels:
        axes.set_ylabel("relative spectral radiance")
    wavelength_axis(axes, nm, label=axis_labels)


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


def basis_figure(
    wavelengths_nm: FloatArray, basis: FloatArray, *, title: str = "Basis of the light's spectra"
) -> Figure:
    """The basis functions E_1 .. E_K of eq. 7 (fig. 7 of the paper); `basis` is (K, L)."""
    looks = [
        (f"E{subscript(index + 1)}", CURVE_COLOURS[index % len(CURVE_COLOURS)]) for index in range(len(basis))
    ]
    return _curves_figure(wavelengths_nm, basis, looks, title, "basis function")


def sensitivities_figure(
    wavelengths_nm: FloatArray,
    sensitivities: FloatArray,
    *,
    title: str = "Spectral sensitivities of the camera",
) -> Figure:
    """A camera's spectral sensitivities (fig. 2 of the paper); `sensitivities` is (L, 3) for R, G, B."""
    peak = float(np.max(sensitivities))
    curves = np.asarray(sensitivities, float).T / (peak if peak > 0 else 1.0)
    looks = list(zip("RGB", RGB_COLOURS, strict=True))
    return _curves_figure(wavelengths_nm, curves, looks, title, "relative sensitivity")


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
    looks: Sequence[tuple[str, str]],
    title: str,
    ylabel: str,
) -> Figure:
    """Curves (N, L) in one plot; `looks` are their names and colours."""
    with house_style():
        figure = new_figure(6.0, 3.6)
        axes = axes_at(figure, 0.62, 0.55, 5.18, 2.38)
        for curve, (label, colour) in zip(curves, looks, strict=True):
            axes.plot(wavelengths_nm, curve, color=colour, label=label)
        lowest, highest = min(0.0, float(np.min(curves))), float(np.max(curves))
        margin = 0.06 * (highest - lowest or 1.0)
        axes.set_ylim(lowest - (margin if lowest < 0 else 0), highest + margin)
        if lowest < 0:
            axes.axhline(0, color=RULE, linewidth=0.6, zorder=0)
        axes.set_ylabel(ylabel)
        axes.legend(loc="best", handlelength=1.6, ncols=min(3, len(looks)))
        wavelength_axis(axes, np.asarray(wavelengths_nm))
        figure.text(0.62 / 6.0, 1 - 0.32 / 3.6, title, fontsize=11, fontweight="bold", va="baseline")
    return figure

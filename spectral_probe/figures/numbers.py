"""The numbers beside a plot of a spectrum, as text, and text broken into lines that fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..model import FloatArray
from ..spectra.grid import resample
from ..spectra.metrics import (
    LightNumbers,
    SpectrumComparison,
    colour_temperature,
    compare_spectra,
    goodness_of_fit,
    light_difference,
    light_numbers,
    relative_rmse,
)
from .style import new_figure

MINUS, THIN_SPACE = "\N{MINUS SIGN}", "\N{THIN SPACE}"


def spectrum_numbers(
    wavelengths_nm: FloatArray,
    estimated: FloatArray,
    measured: FloatArray | None = None,
    measured_label: str = "measured",
) -> dict[str, str]:
    """The numbers that fit beside a small plot, as text: GFC, relative RMSE, dE2000 and correlated colour temperature.

    Examples
    --------
    >>> from ..spectra.grid import WAVELENGTHS_NM
    >>> light = np.linspace(1.0, 2.0, 61)
    >>> spectrum_numbers(WAVELENGTHS_NM, 3 * light, light)["GFC"]
    '1.0000'
    """
    numbers = {}
    temperature = _kelvin(_cct(wavelengths_nm, estimated))
    if measured is not None:
        numbers["GFC"] = _goodness(float(goodness_of_fit(estimated, measured)))
        numbers["rel. RMSE"] = _percent(float(relative_rmse(estimated, measured)))
        both = (resample(wavelengths_nm, light) for light in (estimated, measured))
        numbers["ΔE₀₀"] = _decimal(float(light_difference(*both)), 1)
        temperature += f" ({measured_label} {_kelvin(_cct(wavelengths_nm, measured))})"
    numbers["CCT"] = temperature
    return numbers


def comparison_lines(
    wavelengths_nm: FloatArray, estimated: FloatArray, measured: FloatArray | None = None
) -> list[dict[str, str]]:
    """The numbers of an estimated spectrum (L,), and how well it fits the measured one (L,), as lines of text by name.

    Examples
    --------
    >>> from ..spectra.colorimetry import illuminant
    >>> from ..spectra.grid import WAVELENGTHS_NM
    >>> light_line, = comparison_lines(WAVELENGTHS_NM, illuminant("FL11"))
    >>> light_line["Duv"], light_line["Ra"], light_line["Rf"]
    ('0.0001', '83', '80')
    """
    if measured is None:
        return [_light_line(light_numbers(estimated, wavelengths_nm))]
    compared = compare_spectra(estimated, measured, wavelengths_nm)
    return [_fit_line(compared), _light_line(compared.estimated, compared.measured)]


def _fit_line(compared: SpectrumComparison) -> dict[str, str]:
    differences = {
        "light": compared.de2000_light,
        "ColorChecker": compared.de2000_colorchecker and compared.de2000_colorchecker[0],
        "metals": compared.de2000_metals and compared.de2000_metals[0],
    }
    return {
        "GFC": _goodness(compared.gfc),
        "rel. RMSE": _percent(compared.relative_rmse),
        "ΔE₀₀": ", ".join(f"{name} {_decimal(value, 1)}" for name, value in differences.items()),
    }


def _light_line(light: LightNumbers, measured: LightNumbers | None = None) -> dict[str, str]:
    """The numbers of a light, those of the measured one in parentheses."""

    def shown(text: Any, word: str = "") -> str:
        return str(text(light)) if measured is None else f"{text(light)} ({word}{text(measured)})"

    return {
        "CCT": shown(lambda one: _kelvin(one.cct_kelvin), "measured "),
        "Duv": shown(lambda one: _decimal(one.duv, 4)),
        "Ra": shown(lambda one: _decimal(one.ra, 0)),
        "Rf": shown(lambda one: _decimal(one.rf, 0)),
        "Rg": shown(lambda one: _decimal(one.rg, 0)),
    }


def _goodness(goodness: float | None) -> str:
    """Four decimals, rounded down: 1.0000 is said of no imperfect fit."""
    return "–" if goodness is None else _decimal(float(np.floor(goodness * 1e4 + 1e-6) / 1e4), 4)


def _percent(share: float | None) -> str:
    return "–" if share is None or not np.isfinite(share) else f"{100 * share:.1f}{THIN_SPACE}%"


def _decimal(value: float | None, decimals: int) -> str:
    """A number with a true minus; a dash where there is none.

    Examples
    --------
    >>> _decimal(-0.00123, 4), _decimal(-0.00001, 4), _decimal(None, 1)
    ('−0.0012', '0.0000', '–')
    """
    if value is None or not np.isfinite(value):
        return "–"
    text = f"{value:.{decimals}f}"
    return text.removeprefix("-") if float(text) == 0 else text.replace("-", MINUS)


def _kelvin(kelvin: float | None) -> str:
    return "none" if kelvin is None else f"{kelvin:.0f}{THIN_SPACE}K"


def _cct(wavelengths_nm: FloatArray, spectrum: FloatArray) -> float | None:
    found = colour_temperature(spectrum, wavelengths_nm)
    return None if found is None else found[0]


def numbers_line(numbers: Mapping[str, str]) -> str:
    """Numbers by name as one line of text."""
    return "     ".join(f"{name}  {value}" for name, value in numbers.items())


def wrapped(parts: Sequence[str], width_in: float, separator: str, **style: object) -> list[str]:
    """Parts of text joined into as few lines as fit a width in inches; a part that is wider alone has a line of its own.

    Examples
    --------
    >>> wrapped(["one", "two", "three"], 0.6, " ", fontsize=8)
    ['one two', 'three']
    """
    figure = new_figure(1.0, 1.0)
    sample = figure.text(0, 0, "", **style)  # type: ignore[arg-type]  # matplotlib's own
    lines: list[str] = []
    for part in parts:
        longer = f"{lines[-1]}{separator}{part}" if lines else part
        sample.set_text(longer)
        if lines and sample.get_window_extent().width > width_in * figure.dpi:
            lines.append(part)
        else:
            lines[-1:] = [longer]
    return lines

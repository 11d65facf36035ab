"""One plot of an entry of the library: a lamp, a camera, a metal, a surface."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..model import FloatArray
from ..spectra.grid import WAVELENGTHS_NM
from .spectrum import wavelength_axis
from .style import CURVE_COLOURS, RGB_COLOURS, SOFT_INK, axes_at, house_style, new_figure

_LEFT_IN, _WIDTH_IN, _PANEL_IN, _GAP_IN, _TOP_IN = 0.62, 5.18, 1.9, 0.62, 0.78


def entry_figure(title: str, subtitle: str, curves: Mapping[str, FloatArray]) -> Figure:
    """Curves (61,) by name over wavelength; an index n, k has a panel of its own above the reflectance.

    Fractions are drawn from 0 to 1, everything else from 0 to its peak.
    """
    index = {name: curve for name, curve in curves.items() if name in {"n", "k"}}
    panels = [panel for panel in (index, {n: c for n, c in curves.items() if n not in index}) if panel]
    height_in = _TOP_IN + len(panels) * (_PANEL_IN + _GAP_IN)
    figure = new_figure(2 * _LEFT_IN + _WIDTH_IN, height_in)
    with house_style():
        for row, panel in enumerate(panels):
            _draw(figure, _TOP_IN + row * (_PANEL_IN + _GAP_IN), panel)
        left = _LEFT_IN / (2 * _LEFT_IN + _WIDTH_IN)
        figure.text(left, 1 - 0.32 / height_in, title, fontsize=11, fontweight="bold", va="baseline")
        figure.text(left, 1 - 0.56 / height_in, subtitle, color=SOFT_INK, va="baseline")
    return figure


def _draw(figure: Figure, top_in: float, panel: Mapping[str, FloatArray]) -> None:
    axes = axes_at(figure, _LEFT_IN, top_in, _WIDTH_IN, _PANEL_IN)
    colours = RGB_COLOURS if set(panel) == set("rgb") else CURVE_COLOURS
    for (name, curve), colour in zip(panel.items(), colours, strict=False):
        axes.plot(WAVELENGTHS_NM, curve, color=colour, label=name.replace("_", " ").replace("deg", "°"))
    stacked = np.stack(list(panel.values()))
    lowest, highest = min(0.0, float(stacked.min())), float(stacked.max())
    fractions = all(name.startswith(("reflectance", "transmittance")) for name in panel)
    axes.set_ylim(1.06 * lowest, 1.0 if fractions else 1.06 * highest)
    axes.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 2.5, 5, 10]))
    if len(panel) > 1:
        axes.legend(loc="best", handlelength=1.6, ncols=len(panel))
    else:
        axes.set_ylabel(next(iter(panel)).replace("_", " "))
    wavelength_axis(axes, np.asarray(WAVELENGTHS_NM))

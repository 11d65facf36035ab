"""The shift of each object's chromaticity from spectral to RGB render, on the xy diagram (fig. 13 of the paper)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..render.compare import Comparison
from .diagram import draw_diagram, with_d65
from .style import INK, VERMILION, axes_at, house_style, new_figure
from .table import largest_objects, short_name

_LETTERS = 16  # of a name on the diagram


@dataclass(frozen=True)
class ChromaticityShift:
    """The chromaticity of one object in the spectral render and, where there is one, in the RGB render."""

    name: str
    xy_spectral: tuple[float, float]
    xy_rgb: tuple[float, float] | None = None


def shifts_of(comparison: Comparison) -> tuple[ChromaticityShift, ...]:
    """The shift of the objects of a comparison (`largest_objects`), or of the whole image where it has none."""
    regions = largest_objects(comparison) or (comparison.image,)
    return tuple(ChromaticityShift(region.name, region.xy_spectral, region.xy_rgb) for region in regions)


def chromaticity_figure(
    shifts: Sequence[ChromaticityShift], *, title: str = "Chromaticity, CIE 1931"
) -> Figure:
    """The shift of every object on the xy diagram: close up, with the whole diagram beside it."""
    with house_style():
        figure = new_figure(5.6, 5.6)
        draw_chromaticity(axes_at(figure, 0.6, 0.6, 4.8, 4.5), shifts)
        figure.text(0.6 / 5.6, 1 - 0.36 / 5.6, title, fontsize=11, fontweight="bold", va="baseline")
    return figure


def draw_chromaticity(axes: Axes, shifts: Sequence[ChromaticityShift]) -> None:
    """Draw the shifts into axes as close up as they allow, with the whole diagram small in a corner."""
    rgb = [shift.xy_rgb for shift in shifts if shift.xy_rgb is not None]
    diagram = draw_diagram(axes, with_d65(np.array([shift.xy_spectral for shift in shifts] + rgb)))
    for shift in shifts:
        _draw_shift(axes, shift)
        if shift.xy_rgb is not None:
            diagram.labels.keep_line_free(np.array([shift.xy_spectral, shift.xy_rgb]))
    for shift in shifts:
        diagram.labels.name(short_name(shift.name, _LETTERS), shift.xy_spectral)
    diagram.number_ticks()
    _draw_key(axes, bool(rgb))


def _draw_shift(axes: Axes, shift: ChromaticityShift) -> None:
    """The two points and the arrow between them."""
    if shift.xy_rgb is not None:
        axes.annotate(
            "",
            shift.xy_rgb,
            xytext=shift.xy_spectral,
            zorder=4,
            arrowprops={
                "arrowstyle": "-|>,head_width=0.16,head_length=0.32",
                "color": INK,
                "linewidth": 0.9,
                "shrinkA": 2.5,
                "shrinkB": 2.5,
            },
        )
        axes.plot(
            *shift.xy_rgb,
            "o",
            markersize=5,
            markerfacecolor="white",
            markeredgecolor=VERMILION,
            markeredgewidth=1.3,
            zorder=5,
        )
    axes.plot(*shift.xy_spectral, "o", markersize=5, color=INK, zorder=6)


def _draw_key(axes: Axes, has_rgb: bool) -> None:
    """The legend of the two kinds of points, above the diagram's upper left corner."""
    axes.plot([], [], "o", markersize=5, color=INK, label="spectral")
    if has_rgb:
        axes.plot(
            [],
            [],
            "o",
            markersize=5,
            markerfacecolor="white",
            markeredgecolor=VERMILION,
            markeredgewidth=1.3,
            label="RGB",
        )
    axes.legend(
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=2,
        handletextpad=0.1,
        columnspacing=1.0,
        borderaxespad=0.1,
    )

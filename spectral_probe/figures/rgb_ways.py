"""Fig. 13 of the paper: metals under one light on the xy diagram, spectrally and by four ways of RGB, with a table."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..render.rgb_ways import WAYS, RgbWays, SurfaceColours
from .diagram import draw_diagram, with_d65
from .style import BLUE, CURVE_COLOURS, INK, SOFT_INK, VERMILION, axes_at, house_style, new_figure
from .table import draw_table

MARKS: Mapping[str, tuple[str, float, str]] = {
    "A0": ("v", 5.0, SOFT_INK),
    "A": ("D", 4.0, BLUE),
    "B": ("s", 4.4, VERMILION),
    "D": ("o", 4.8, CURVE_COLOURS[2]),
}
"""Marker, size in points and colour of each way."""

HEAD = ("ΔE₀₀", *WAYS)
RIGHT_EDGES = (0.0, 0.55, 0.70, 0.85, 1.0)
"""Columns of the short table, and where they end."""

_FULL_HEAD = ("x, y", "spectral", *WAYS)
_FULL_EDGES = (0.0, 0.36, 0.52, 0.68, 0.84, 1.0)
_ROW_IN = 0.235


def rgb_ways_figure(ways: RgbWays) -> Figure:
    """The diagram with its table beside it."""
    rows = _full_rows(ways)
    width_in, table_in = 11.6, (1 + len(rows)) * _ROW_IN
    height_in = max(5.2, 1.2 + table_in + 0.2 * len(ways_notes(ways)) + 0.3)
    with house_style():
        figure = new_figure(width_in, height_in)
        title = f"Metals under {ways.light}: spectral and four ways of RGB"
        figure.text(
            0.6 / width_in, 1 - 0.36 / height_in, title, fontsize=11, fontweight="bold", va="baseline"
        )
        draw_rgb_ways(axes_at(figure, 0.6, 0.6, 4.1, 4.1), ways)
        axes = axes_at(figure, 5.2, 0.6, width_in - 5.7, table_in)
        draw_table(axes, _FULL_HEAD, rows, _FULL_EDGES, row_height=1 / (1 + len(rows)))
        for index, line in enumerate(ways_notes(ways)):
            baseline = 1 - (0.6 + table_in + 0.3 + 0.2 * index) / height_in
            figure.text(5.2 / width_in, baseline, line, fontsize=7.0, color=SOFT_INK, va="baseline")
    return figure


def draw_rgb_ways(axes: Axes, ways: RgbWays) -> None:
    """Draw every surface's spectral point and, joined to it, those of the four ways."""
    points = [surface.xy_spectral for surface in ways.surfaces]
    points += [way.xy for surface in ways.surfaces for way in surface.ways]
    diagram = draw_diagram(axes, with_d65(np.array([*points, ways.white_xy])))
    for surface in ways.surfaces:
        for way in surface.ways:
            diagram.labels.keep_line_free(np.array([surface.xy_spectral, way.xy]))
        _draw_surface(axes, surface)
    for surface in ways.surfaces:
        diagram.labels.name(surface.name, surface.xy_spectral)
    if np.hypot(*np.subtract(ways.white_xy, (0.3127, 0.3290))) > 0.002:  # else it is D65's own cross
        axes.plot(*ways.white_xy, marker="x", markersize=5, markeredgewidth=0.9, color=INK, zorder=3)
        diagram.labels.name("white", ways.white_xy, 6.5, SOFT_INK)
    diagram.number_ticks()
    _draw_key(axes)


def _draw_surface(axes: Axes, surface: SurfaceColours) -> None:
    for way in surface.ways:
        marker, size, edge = MARKS[way.way]
        (x0, y0), (x1, y1) = surface.xy_spectral, way.xy
        axes.plot([x0, x1], [y0, y1], color=edge, linewidth=0.7, zorder=4)
        axes.plot(
            x1,
            y1,
            marker,
            markersize=size,
            markerfacecolor="white",
            markeredgecolor=edge,
            markeredgewidth=1.2,
            zorder=5,
        )
    axes.plot(*surface.xy_spectral, "o", markersize=4.5, color=INK, zorder=6)


def _draw_key(axes: Axes) -> None:
    """The legend of the points, above the diagram's upper left corner."""
    axes.plot([], [], "o", markersize=4.5, color=INK, label="spectral")
    for way, (marker, size, edge) in MARKS.items():
        axes.plot(
            [],
            [],
            marker,
            markersize=size,
            markerfacecolor="white",
            markeredgecolor=edge,
            markeredgewidth=1.2,
            label=way,
        )
    axes.legend(
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=1 + len(MARKS),
        handletextpad=0.1,
        columnspacing=0.9,
        borderaxespad=0.1,
    )


def ways_rows(ways: RgbWays) -> list[tuple[str, ...]]:
    """The cells of the table: dE2000 of every surface by every way, a dash where a way is not defined.

    Examples
    --------
    >>> from ..render.rgb_ways import compare_rgb_ways, metal_reflectances
    >>> from ..spectra.colorimetry import illuminant
    >>> ways_rows(compare_rgb_ways(metal_reflectances(["silver"]), illuminant("D65")))
    [('Silver', '9.34', '0.05', '0.14', '0.04')]
    """
    return [
        (
            surface.name,
            *("–" if (found := surface.way(way)) is None else f"{found.delta_e:.2f}" for way in WAYS),
        )
        for surface in ways.surfaces
    ]


def _full_rows(ways: RgbWays) -> list[tuple[str, ...]]:
    """Of every surface x and y by every way, and below them dE2000."""

    def xy(values: tuple[float, float] | None) -> str:
        return "–" if values is None else f"{values[0]:.4f}, {values[1]:.4f}"

    rows = []
    for surface, (_, *differences) in zip(ways.surfaces, ways_rows(ways), strict=True):
        found = [surface.way(way) for way in WAYS]
        rows.append(
            (
                surface.name,
                xy(surface.xy_spectral),
                *(xy(way.xy if way is not None else None) for way in found),
            )
        )
        rows.append(("    ΔE₀₀", "", *differences))
    return rows


def ways_notes(ways: RgbWays) -> list[str]:
    """What the ways are, and what the light does to them; a line each."""
    return [f"{name}: {text}" for name, text in WAYS.items()] + list(ways.remarks)

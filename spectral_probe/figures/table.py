"""A table of numbers drawn with thin rules above, below and under its head, and nothing else."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes

from ..render.compare import Comparison, RegionComparison
from .style import INK, RULE, SOFT_INK

HEAD = ("", "ΔE₀₀ mean", "p95", "> 1", "> 2", "of means", "x, y spectral", "Δx", "Δy")
"""Columns of the table of differences."""

_RIGHT_EDGES = (0.0, 0.315, 0.385, 0.455, 0.525, 0.62, 0.79, 0.895, 1.0)


MOST_ROWS = 12
"""Of more objects than these, the largest in the picture are shown."""

_LONGEST_NAME = 22


def largest_objects(comparison: Comparison) -> tuple[RegionComparison, ...]:
    """The objects that tables and diagrams show: all, or the largest in the picture, in their own order."""
    by_size = sorted(comparison.objects, key=lambda region: region.raw.pixels, reverse=True)
    shown = {region.name for region in by_size[:MOST_ROWS]}
    return tuple(region for region in comparison.objects if region.name in shown)


def difference_rows(comparison: Comparison) -> list[tuple[str, ...]]:
    """The cells of the table of differences: the objects, then the whole image blurred and raw."""
    rows = [_cells(short_name(region.name), region, raw=False) for region in largest_objects(comparison)]
    if comparison.image.blurred is not None:
        rows.append(_cells(f"image, σ {comparison.blur_px:g} px", comparison.image, raw=False))
    rows.append(_cells("image, raw", comparison.image, raw=True))
    return rows


def _cells(name: str, region: RegionComparison, *, raw: bool) -> tuple[str, ...]:
    numbers = region.raw if raw else region.differences
    dx, dy = region.xy_shift
    return (
        name,
        f"{numbers.mean:.2f}",
        f"{numbers.p95:.2f}",
        f"{100 * numbers.above_1:.0f} %",
        f"{100 * numbers.above_2:.0f} %",
        f"{region.delta_e_of_means:.2f}",
        f"{region.xy_spectral[0]:.4f}, {region.xy_spectral[1]:.4f}",
        _signed(dx),
        _signed(dy),
    )


def short_name(name: str, most: int = _LONGEST_NAME) -> str:
    """A name of so many letters at most: the middle is left out, as numbers stand at the end.

    Examples
    --------
    >>> short_name("Copper Ball"), short_name("A very long name of an object.003")
    ('Copper Ball', 'A very long…object.003')
    """
    if len(name) <= most:
        return name
    tail = (most - 1) // 2
    return f"{name[: most - 1 - tail]}…{name[-tail:]}"


def _signed(value: float) -> str:
    """A shift with its sign and a true minus, four decimals.

    Examples
    --------
    >>> _signed(0.0123), _signed(-0.00001)
    ('+0.0123', '0.0000')
    """
    text = f"{value:+.4f}"
    return text[1:] if float(text) == 0 else text.replace("-", "\N{MINUS SIGN}")


def draw_table(
    axes: Axes,
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    right_edges: Sequence[float] = _RIGHT_EDGES,
    *,
    row_height: float = 0.1,
    top: float = 1.0,
) -> float:
    """Draw a table from the top of axes down; lengths are fractions of the axes.

    The first column is flush left, the others flush right at `right_edges`. Returns where the table ends.
    """
    axes.set_axis_off()
    axes.set_xlim(0, 1)
    axes.set_ylim(0, 1)

    def line(y: float, colour: str, width: float) -> None:
        axes.plot([0, 1], [y, y], color=colour, linewidth=width, clip_on=False, solid_capstyle="butt")

    def cells(texts: Sequence[str], y: float, colour: str, weight: str = "normal") -> None:
        for column, (text, edge) in enumerate(zip(texts, right_edges, strict=True)):
            axes.text(
                edge,
                y,
                text,
                ha="right" if column else "left",
                va="center",
                color=colour,
                fontsize=7.5,
                fontweight=weight if column == 0 else "normal",
            )

    line(top, INK, 0.9)
    cells(head, top - row_height / 2, SOFT_INK)
    line(top - row_height, SOFT_INK, 0.5)
    for index, row in enumerate(rows):
        middle = top - (index + 1.5) * row_height
        cells(row, middle, INK, "bold")
        if index < len(rows) - 1:
            line(middle - row_height / 2, RULE, 0.3)
    bottom = top - (len(rows) + 1) * row_height
    line(bottom, INK, 0.9)
    return bottom

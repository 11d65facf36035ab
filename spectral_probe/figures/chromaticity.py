"""The CIE 1931 xy diagram with each object's shift from spectral to RGB render (fig. 13 of the paper)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle
from matplotlib.ticker import MaxNLocator, MultipleLocator

from ..model import FloatArray
from ..render.compare import Comparison
from ..spectra.colorimetry import chromaticity, spectra_to_xyz, white_xyz, xyz_to_rec709
from ..spectra.colour_science import colour
from ..spectra.library import planck
from .display import Picture, srgb_encoded
from .style import INK, PIXELS_PER_INCH, RULE, SOFT_INK, VERMILION, axes_at, house_style, new_figure

WHOLE_DIAGRAM = (-0.02, 0.76, -0.03, 0.87)
"""Limits x0, x1, y0, y1 of the whole diagram."""

KELVINS = (2000, 2500, 3000, 3500, 4000, 5000, 6500, 8000, 10000, 20000)
"""The colour temperatures marked on the Planckian locus of a close-up; every third on the whole diagram."""

_NAME_RISES = (5.0, -11.0, 14.0, -20.0, 23.0, -29.0, 32.0, -38.0)
"""Where a name may stand above or below its point, in points, the best place first."""

PALENESS = 0.32
"""How much of a colour's distance from white is drawn, so that lines and letters stand out."""

_OBSERVER = "CIE 1931 2 Degree Standard Observer"


@dataclass(frozen=True)
class ChromaticityShift:
    """The chromaticity of one object in the spectral render and, where there is one, in the RGB render."""

    name: str
    xy_spectral: tuple[float, float]
    xy_rgb: tuple[float, float] | None = None


def shifts_of(comparison: Comparison) -> tuple[ChromaticityShift, ...]:
    """The shift of every object of a comparison, or of the whole image where it has none."""
    regions = comparison.objects or (comparison.image,)
    return tuple(ChromaticityShift(region.name, region.xy_spectral, region.xy_rgb) for region in regions)


@cache
def spectral_locus() -> FloatArray:
    """Chromaticities of monochromatic light, (N, 2), from 390 to 700 nm in 1 nm steps.

    Examples
    --------
    >>> spectral_locus()[520 - 390].round(4).tolist()
    [0.0743, 0.8338]
    """
    functions = colour.MSDS_CMFS[_OBSERVER]
    wavelengths_nm = np.asarray(functions.wavelengths)
    shown = (wavelengths_nm >= 390) & (wavelengths_nm <= 700)
    return chromaticity(np.asarray(functions.values, float)[shown])


def planckian_locus(kelvins: FloatArray) -> FloatArray:
    """Chromaticities of black bodies, (N, 2)."""
    return chromaticity(spectra_to_xyz(np.stack([planck(float(kelvin)) for kelvin in kelvins])))


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
    points = _points(shifts)
    limits = close_up_limits(points, _aspect(axes))
    close_up = limits != WHOLE_DIAGRAM
    _draw_diagram(axes, limits, KELVINS if close_up else KELVINS[::3])
    axes.set_xlabel("x")
    axes.set_ylabel("y", rotation=0, labelpad=4)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]) if close_up else MultipleLocator(0.2))
    for shift in shifts:
        _draw_shift(axes, shift)
    _draw_names(axes, shifts)
    _draw_key(axes, any(shift.xy_rgb is not None for shift in shifts))
    if close_up:
        _draw_overview(axes, limits, points)


def _points(shifts: Sequence[ChromaticityShift]) -> FloatArray:
    """All chromaticities of the shifts, (N, 2), and the white of D65 where it is not far from them."""
    listed = [shift.xy_spectral for shift in shifts] + [
        shift.xy_rgb for shift in shifts if shift.xy_rgb is not None
    ]
    points = np.array(listed)
    with_white = np.vstack([points, chromaticity(white_xyz("D65"))])
    return (
        with_white
        if np.ptp(with_white, axis=0).max() < max(1.5 * np.ptp(points, axis=0).max(), 0.03)
        else points
    )


def _aspect(axes: Axes) -> float:
    """Height over width of axes on the page."""
    figure = axes.get_figure(root=True)
    width, height = figure.get_size_inches() if figure is not None else (1.0, 1.0)
    box = axes.get_position(original=True)
    return float(box.height * height / (box.width * width))


def close_up_limits(points: FloatArray, aspect: float = 1.0) -> tuple[float, float, float, float]:
    """Limits x0, x1, y0, y1 round all points (N, 2); the whole diagram where they are far apart.

    Examples
    --------
    >>> close_up_limits(np.array([[0.1, 0.1], [0.6, 0.7]])) == WHOLE_DIAGRAM
    True
    """
    low, high = points.min(0), points.max(0)
    span = max(float(high[0] - low[0]), float(high[1] - low[1]) / aspect, 0.03) * 1.6
    if span > 0.42:
        return WHOLE_DIAGRAM
    x, y = (low + high) / 2
    return (
        float(x - span / 2),
        float(x + span / 2),
        float(y - span * aspect / 2),
        float(y + span * aspect / 2),
    )


def _draw_diagram(axes: Axes, limits: tuple[float, float, float, float], ticks_kelvin: Sequence[int]) -> None:
    """Spectral locus with its colours inside, Planckian locus, and the white of D65."""
    axes.set_xlim(limits[0], limits[1])
    axes.set_ylim(limits[2], limits[3])
    axes.set_aspect("equal", adjustable="box")
    outline = Polygon(
        spectral_locus(), closed=True, facecolor="none", edgecolor=SOFT_INK, linewidth=0.8, zorder=2
    )
    axes.add_patch(outline)
    fill = axes.imshow(
        diagram_colours(limits), extent=limits, origin="lower", interpolation="bilinear", zorder=0
    )
    fill.set_clip_path(outline)
    axes.set_xlim(limits[0], limits[1])
    axes.set_ylim(limits[2], limits[3])
    locus = planckian_locus(1e6 / np.linspace(20.0, 1e6 / 1400, 160))
    axes.plot(locus[:, 0], locus[:, 1], color=INK, linewidth=0.7, alpha=0.55, zorder=2)
    for kelvin, xy in zip(ticks_kelvin, planckian_locus(np.asarray(ticks_kelvin, float)), strict=True):
        inside = (xy - (limits[0], limits[2])) / (limits[1] - limits[0], limits[3] - limits[2])
        if 0.02 < inside[0] < 0.85 and 0.06 < inside[1] < 0.98:  # room for its label below and to the right
            axes.plot(*xy, marker="|", markersize=5, color=INK, alpha=0.55, zorder=2)
            axes.annotate(
                f"{kelvin} K",
                xy,
                xytext=(3, -8),
                textcoords="offset points",
                fontsize=5.5,
                color=SOFT_INK,
                ha="left",
                zorder=2,
            )
    white = chromaticity(white_xyz("D65"))
    axes.plot(*white, marker="+", markersize=6, markeredgewidth=0.9, color=INK, zorder=3)
    axes.annotate(
        "D65",
        (float(white[0]), float(white[1])),
        xytext=(-6, -2),
        textcoords="offset points",
        fontsize=6.5,
        color=SOFT_INK,
        ha="right",
        va="center",
        zorder=3,
    )


def diagram_colours(limits: tuple[float, float, float, float], pixels: int = 240) -> Picture:
    """Pale colours of the chromaticities within limits x0, x1, y0, y1; (pixels, pixels, 3) sRGB, y up."""
    x, y = np.meshgrid(np.linspace(limits[0], limits[1], pixels), np.linspace(limits[2], limits[3], pixels))
    rgb = xyz_to_rec709(np.stack([x, y, 1 - x - y], axis=-1))
    rgb = rgb - np.minimum(rgb.min(-1, keepdims=True), 0)  # white is added where the screen's gamut ends
    rgb = srgb_encoded(np.clip(rgb / np.maximum(rgb.max(-1, keepdims=True), 1e-6), 0, 1))
    return np.asarray(np.rint(255 * (1 - (1 - rgb) * PALENESS)), np.uint8)


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


def _draw_names(axes: Axes, shifts: Sequence[ChromaticityShift]) -> None:
    """Each object's name beside its spectral point, at the first of several places that is free."""
    points_per_pixel = 72.0 / PIXELS_PER_INCH
    right_edge = axes.bbox.x1 * points_per_pixel
    marks = _points(shifts)
    taken = [_Box(x - 4, x + 4, y - 4, y + 4) for x, y in axes.transData.transform(marks) * points_per_pixel]
    for shift in shifts:
        x, y = axes.transData.transform(shift.xy_spectral) * points_per_pixel
        width = 5.2 * len(shift.name)
        boxes = {
            (side, rise): _Box(
                x + (7 if side > 0 else -7 - width),
                x + (7 + width if side > 0 else -7),
                y + rise - 1,
                y + rise + 7,
            )
            for rise in _NAME_RISES
            for side in (1, -1)
        }
        free = [
            place
            for place, box in boxes.items()
            if box.right < right_edge and not any(box.meets(other) for other in taken)
        ]
        side, rise = free[0] if free else (1, _NAME_RISES[0])
        taken.append(boxes[side, rise])
        axes.annotate(
            shift.name,
            shift.xy_spectral,
            xytext=(7 * side, rise),
            textcoords="offset points",
            fontsize=8,
            color=INK,
            ha="left" if side > 0 else "right",
            zorder=6,
        )


@dataclass(frozen=True)
class _Box:
    """A rectangle on the page, in points."""

    left: float
    right: float
    bottom: float
    top: float

    def meets(self, other: _Box) -> bool:
        """Whether the two overlap."""
        return (
            self.left < other.right
            and other.left < self.right
            and self.bottom < other.top
            and other.bottom < self.top
        )


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


def _draw_overview(axes: Axes, limits: tuple[float, float, float, float], points: FloatArray) -> None:
    """The whole diagram, small, in the corner farthest from all points, with the part shown framed."""
    unit = (points - np.array(limits)[[0, 2]]) / (np.array(limits)[[1, 3]] - np.array(limits)[[0, 2]])
    corners = np.array([[0.84, 0.16], [0.16, 0.84], [0.84, 0.84], [0.16, 0.16]])
    distances = np.linalg.norm(unit[None] - corners[:, None], axis=-1).min(1)
    centre = corners[int(distances.argmax())]
    inset = axes.inset_axes((float(centre[0]) - 0.145, float(centre[1]) - 0.15, 0.29, 0.30))
    inset.set_facecolor("white")
    inset.set_xlim(WHOLE_DIAGRAM[0], WHOLE_DIAGRAM[1])
    inset.set_ylim(WHOLE_DIAGRAM[2], WHOLE_DIAGRAM[3])
    inset.set_aspect("equal")
    outline = Polygon(spectral_locus(), closed=True, facecolor="none", edgecolor=SOFT_INK, linewidth=0.7)
    inset.add_patch(outline)
    fill = inset.imshow(
        diagram_colours(WHOLE_DIAGRAM, 120), extent=WHOLE_DIAGRAM, origin="lower", interpolation="bilinear"
    )
    fill.set_clip_path(outline)
    inset.add_patch(
        Rectangle(
            (limits[0], limits[2]),
            limits[1] - limits[0],
            limits[3] - limits[2],
            fill=False,
            edgecolor=INK,
            linewidth=0.8,
        )
    )
    inset.set_xticks([])
    inset.set_yticks([])
    for spine in inset.spines.values():
        spine.set(visible=True, color=RULE, linewidth=0.5)

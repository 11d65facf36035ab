"""The CIE 1931 xy diagram: locus, colours, black bodies, a close-up with the whole in a corner, and names that stay readable."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle
from matplotlib.text import Annotation
from matplotlib.ticker import MaxNLocator, MultipleLocator

from ..model import FloatArray
from ..spectra.colorimetry import chromaticity, spectra_to_xyz, white_xyz, xyz_to_rec709
from ..spectra.colour_science import colour
from ..spectra.library import planck
from .display import Picture, srgb_encoded
from .style import INK, PIXELS_PER_INCH, RULE, SOFT_INK

WHOLE_DIAGRAM = (-0.02, 0.76, -0.03, 0.87)
"""Limits x0, x1, y0, y1 of the whole diagram."""

KELVINS = (2000, 2500, 3000, 3500, 4000, 5000, 6500, 8000, 10000, 20000)
"""The colour temperatures marked on the Planckian locus of a close-up; every third on the whole diagram."""

PALENESS = 0.32
"""How much of a colour's distance from white is drawn, so that lines and letters stand out."""

_OBSERVER = "CIE 1931 2 Degree Standard Observer"
_NAME_RISES = (0.0, 8.0, -8.0, 14.0, -14.0, 22.0, -22.0, 30.0, -30.0, 38.0, -38.0)
"""Where a name may stand above or below its point, in points, the best place first."""

_TICK_PLACES = ((3.0, -8.0), (3.0, 3.0), (-3.0, -8.0), (-3.0, 3.0))
"""Where the number of a colour temperature may stand from its tick, in points."""

_CORNERS = ((0.84, 0.16), (0.16, 0.84), (0.84, 0.84), (0.16, 0.16))
"""Where the whole diagram may stand in a close-up, its centre in fractions of the axes."""

_NEAR_PT = 10.0
"""A name that stands higher or lower than this beside its point is led to by a line."""

_LINE_STEP_PT = 3.0
_POINTS_PER_PIXEL = 72.0 / PIXELS_PER_INCH
_MARK_PT = 4.0  # half the size of a point's mark, with air


@dataclass(frozen=True)
class Box:
    """A rectangle on the page, in points."""

    left: float
    right: float
    bottom: float
    top: float

    def meets(self, other: Box) -> bool:
        """Whether the two overlap.

        Examples
        --------
        >>> Box(0, 2, 0, 2).meets(Box(1, 3, 1, 3)), Box(0, 2, 0, 2).meets(Box(2, 3, 0, 2))
        (True, False)
        """
        return (
            self.left < other.right
            and other.left < self.right
            and self.bottom < other.top
            and other.bottom < self.top
        )

    def within(self, other: Box) -> bool:
        """Whether it lies wholly in another."""
        return (
            other.left <= self.left
            and self.right <= other.right
            and other.bottom <= self.bottom
            and self.top <= other.top
        )


@dataclass
class Labels:
    """What of a diagram is covered by marks and names; every further name goes where there is room."""

    axes: Axes
    taken: list[Box] = field(default_factory=list)
    lines: list[Box] = field(default_factory=list)
    """What is better left free, but may be written over."""

    def keep_free(self, points: Iterable[Sequence[float]]) -> None:
        """No name may cover these chromaticities."""
        for x, y in self._page(points):
            self.taken.append(Box(x - _MARK_PT, x + _MARK_PT, y - _MARK_PT, y + _MARK_PT))

    def keep_line_free(self, points: FloatArray, *, needed: bool = True) -> None:
        """No name may cover the line through chromaticities (N, 2), or none that finds another place."""
        kept = self.taken if needed else self.lines
        page = self._page(points)
        lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(page, axis=0).T))])
        shown, at = self._extent(), np.linspace(0.0, lengths[-1], 2 + int(lengths[-1] / _LINE_STEP_PT))
        for x, y in zip(*(np.interp(at, lengths, column) for column in page.T), strict=True):
            dot = Box(x - 1, x + 1, y - 1, y + 1)
            if dot.meets(shown):
                kept.append(dot)

    def keep_axes_free(self, inset: Axes) -> None:
        """No name may cover axes within these."""
        box = inset.get_window_extent()
        left, bottom, right, top = (float(value) * _POINTS_PER_PIXEL for value in box.extents)
        self.taken.append(Box(left, right, bottom, top))

    def name(self, text: str, xy: Sequence[float], size_pt: float = 8.0, colour: str = INK) -> None:
        """Write a name beside a point at the first of several places that is free; where none is, where it covers least."""
        places = [(side * (7.0 + abs(rise) / 8), rise) for rise in _NAME_RISES for side in (1.0, -1.0)]
        written = self.axes.annotate(
            text,
            (xy[0], xy[1]),
            (0, 0),
            textcoords="offset points",
            va="center",
            fontsize=size_pt,
            color=colour,
            zorder=7,
        )
        boxes = self._boxes(written, xy, places)
        clear = [n for n in self._free(boxes) if not any(boxes[n].meets(line) for line in self.lines)]
        chosen = next(iter(clear or self._free(boxes) or [self._least_covered(boxes)]))
        self._put(written, places, boxes, chosen)
        if abs(places[chosen][1]) > _NEAR_PT:
            self._lead(xy, boxes[chosen], places[chosen])

    def tick(self, text: str, xy: Sequence[float]) -> None:
        """Write the number of a tick beside it if there is room."""
        written = self.axes.annotate(
            text,
            (xy[0], xy[1]),
            (0, 0),
            textcoords="offset points",
            va="center",
            fontsize=5.5,
            color=SOFT_INK,
            zorder=2,
        )
        boxes = self._boxes(written, xy, _TICK_PLACES)
        free = self._free(boxes)
        if free:
            self._put(written, _TICK_PLACES, boxes, free[0])
        else:
            written.remove()

    def _page(self, points: Iterable[Sequence[float]] | FloatArray) -> FloatArray:
        """Chromaticities (N, 2) on the page, in points."""
        return np.asarray(self.axes.transData.transform(np.array(list(points), float)) * _POINTS_PER_PIXEL)

    def _boxes(
        self, written: Annotation, xy: Sequence[float], places: Sequence[tuple[float, float]]
    ) -> list[Box]:
        """What the text would cover at each of the places, in points from xy."""
        extent = written.get_window_extent()
        width, height = extent.width * _POINTS_PER_PIXEL, extent.height * _POINTS_PER_PIXEL
        ((x, y),) = self._page([xy])
        lefts = [x + across if across > 0 else x + across - width for across, _ in places]
        return [
            Box(left, left + width, y + rise - height / 2, y + rise + height / 2)
            for left, (_, rise) in zip(lefts, places, strict=True)
        ]

    def _extent(self) -> Box:
        """The axes themselves."""
        left, bottom, right, top = (float(edge) * _POINTS_PER_PIXEL for edge in self.axes.bbox.extents)
        return Box(left, right, bottom, top)

    def _free(self, boxes: Sequence[Box]) -> list[int]:
        """Which of the boxes lie within the axes and cover nothing."""
        left, bottom, right, top = (
            float(v) * _POINTS_PER_PIXEL for v in self.axes.get_window_extent().extents
        )
        page = Box(left, right, bottom, top)
        return [
            number
            for number, box in enumerate(boxes)
            if box.within(page) and not any(box.meets(other) for other in self.taken)
        ]

    def _least_covered(self, boxes: Sequence[Box]) -> int:
        """Which box covers least, where none is free; those within the axes first."""
        page = self._extent()
        covers = [sum(box.meets(other) for other in self.taken) for box in boxes]
        return min(range(len(boxes)), key=lambda n: (not boxes[n].within(page), covers[n]))

    def _lead(self, xy: Sequence[float], box: Box, place: tuple[float, float]) -> None:
        """A hair line from a point to its name, where that stands away from it."""
        side = box.left if place[0] > 0 else box.right
        end = np.array([side, (box.bottom + box.top) / 2]) / _POINTS_PER_PIXEL
        x, y = self.axes.transData.inverted().transform(end)
        self.axes.plot([xy[0], x], [xy[1], y], color=SOFT_INK, linewidth=0.5, zorder=6, solid_capstyle="butt")

    def _put(
        self, written: Annotation, places: Sequence[tuple[float, float]], boxes: Sequence[Box], chosen: int
    ) -> None:
        written.set_position(places[chosen])
        written.set_horizontalalignment("left" if places[chosen][0] > 0 else "right")
        self.taken.append(boxes[chosen])


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


@cache
def _black_bodies() -> FloatArray:
    """The Planckian locus to draw, (N, 2), from 50,000 to 1,400 K."""
    return planckian_locus(1e6 / np.linspace(20.0, 1e6 / 1400, 160))


def with_d65(points: FloatArray) -> FloatArray:
    """Chromaticities (N, 2), and that of D65 where it is not far from them."""
    with_white = np.vstack([points, chromaticity(white_xyz("D65"))])
    near = np.ptp(with_white, axis=0).max() < max(1.5 * np.ptp(points, axis=0).max(), 0.03)
    return with_white if near else points


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


@dataclass(frozen=True)
class Diagram:
    """A diagram that is drawn, but for its points: what of it is shown, its names, and the ticks still to be numbered."""

    limits: tuple[float, float, float, float]
    labels: Labels
    ticks: tuple[tuple[str, tuple[float, float]], ...]

    def number_ticks(self) -> None:
        """Number the colour temperatures where names have left room."""
        for text, xy in self.ticks:
            self.labels.tick(text, xy)


def draw_diagram(axes: Axes, points: FloatArray) -> Diagram:
    """Draw the diagram into axes as close up as points (N, 2) allow, with the whole of it small in a corner."""
    limits = close_up_limits(points, _aspect(axes))
    close_up = limits != WHOLE_DIAGRAM
    axes.set_xlim(limits[0], limits[1])
    axes.set_ylim(limits[2], limits[3])
    axes.set_aspect("equal", adjustable="box")
    axes.apply_aspect()
    axes.set_xlabel("x")
    axes.set_ylabel("y", rotation=0, labelpad=4)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]) if close_up else MultipleLocator(0.2))
    _draw_locus(axes, limits, 240)
    labels = Labels(axes)
    labels.keep_free(points)
    labels.keep_line_free(_black_bodies(), needed=False)
    labels.keep_line_free(spectral_locus(), needed=False)
    if close_up:
        labels.keep_axes_free(_draw_overview(axes, limits, points))
    ticks = tuple(_draw_black_bodies(axes, limits, KELVINS if close_up else KELVINS[::3]))
    _draw_d65(axes, limits, labels)
    return Diagram(limits, labels, ticks)


def _draw_locus(
    axes: Axes, limits: tuple[float, float, float, float], pixels: int, width: float = 0.8
) -> None:
    """The spectral locus with its colours inside."""
    outline = Polygon(
        spectral_locus(), closed=True, facecolor="none", edgecolor=SOFT_INK, linewidth=width, zorder=2
    )
    axes.add_patch(outline)
    fill = axes.imshow(
        diagram_colours(limits, pixels), extent=limits, origin="lower", interpolation="bilinear", zorder=0
    )
    fill.set_clip_path(outline)
    axes.set_xlim(limits[0], limits[1])
    axes.set_ylim(limits[2], limits[3])


def _draw_black_bodies(
    axes: Axes, limits: tuple[float, float, float, float], kelvins: Sequence[int]
) -> Iterable[tuple[str, tuple[float, float]]]:
    """The Planckian locus and its ticks; what each is to be called, and where it is."""
    locus = _black_bodies()
    axes.plot(locus[:, 0], locus[:, 1], color=INK, linewidth=0.7, alpha=0.55, zorder=2)
    for kelvin, (x, y) in zip(kelvins, planckian_locus(np.asarray(kelvins, float)), strict=True):
        if limits[0] < x < limits[1] and limits[2] < y < limits[3]:
            axes.plot(x, y, marker="|", markersize=5, color=INK, alpha=0.55, zorder=2)
            yield f"{kelvin} K", (float(x), float(y))


def _draw_d65(axes: Axes, limits: tuple[float, float, float, float], labels: Labels) -> None:
    """The white of D65, named to its left."""
    x, y = (float(value) for value in chromaticity(white_xyz("D65")))
    axes.plot(x, y, marker="+", markersize=6, markeredgewidth=0.9, color=INK, zorder=3)
    if limits[0] < x < limits[1] and limits[2] < y < limits[3]:
        labels.keep_free([(x, y)])
        labels.name("D65", (x, y), 6.5, SOFT_INK)


def _draw_overview(axes: Axes, limits: tuple[float, float, float, float], points: FloatArray) -> Axes:
    """The whole diagram, small, in the corner farthest from all points, with the part shown framed."""
    unit = (points - np.array(limits)[[0, 2]]) / (np.array(limits)[[1, 3]] - np.array(limits)[[0, 2]])
    distances = np.linalg.norm(unit[None] - np.array(_CORNERS)[:, None], axis=-1).min(1)
    x, y = _CORNERS[int(distances.argmax())]
    inset = axes.inset_axes((x - 0.145, y - 0.15, 0.29, 0.30))
    inset.set_facecolor("white")
    inset.set_aspect("equal")
    _draw_locus(inset, WHOLE_DIAGRAM, 120, 0.7)
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
    return inset


def diagram_colours(limits: tuple[float, float, float, float], pixels: int = 240) -> Picture:
    """Pale colours of the chromaticities within limits x0, x1, y0, y1; (pixels, pixels, 3) sRGB, y up."""
    x, y = np.meshgrid(np.linspace(limits[0], limits[1], pixels), np.linspace(limits[2], limits[3], pixels))
    rgb = xyz_to_rec709(np.stack([x, y, 1 - x - y], axis=-1))
    rgb = rgb - np.minimum(rgb.min(-1, keepdims=True), 0)  # white is added where the screen's gamut ends
    rgb = srgb_encoded(np.clip(rgb / np.maximum(rgb.max(-1, keepdims=True), 1e-6), 0, 1))
    return np.asarray(np.rint(255 * (1 - (1 - rgb) * PALENESS)), np.uint8)


def _aspect(axes: Axes) -> float:
    """Height over width of axes on the page."""
    width, height = _figure(axes).get_size_inches()
    box = axes.get_position(original=True)
    return float(box.height * height / (box.width * width))


def _figure(axes: Axes) -> Figure:
    figure = axes.get_figure(root=True)
    if figure is None:
        raise ValueError("the axes belong to no figure")
    return figure

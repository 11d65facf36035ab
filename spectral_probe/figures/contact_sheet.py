"""The contact sheet of an animation: each frame's spectral render, RGB render and dE2000 map, small, on one page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..model import BoolArray, FloatArray
from ..render.compare import Comparison
from ..spectra.colorimetry import adapted_to_d65
from .difference import CEILINGS, delta_e_colours
from .display import Picture, exposure_for_white, tone_map
from .style import (
    BLUE,
    INK,
    PIXELS_PER_INCH,
    RULE,
    SOFT_INK,
    VERMILION,
    axes_at,
    house_style,
    new_figure,
    show_picture,
)
from .table import short_name

MOST_FRAMES = 40
"""The sheet shows at most so many frames, evenly chosen, and the worst."""

WIDTH_IN = 12.0
"""Width of the page: 1800 pixels."""

_MARGIN_IN = 0.5
_CONTENT_IN = WIDTH_IN - 2 * _MARGIN_IN
_HEADER_IN = 1.0
_CURVE_IN = 1.3
_COLUMN_GAP_IN = 0.3
_PICTURE_GAP_IN = 0.04
_LABEL_IN = 0.24
_ROW_GAP_IN = 0.12
_TALLEST = 1.25  # a picture's height over its width; what is higher is narrower
_PALE = 230


@dataclass(frozen=True)
class FrameTile:
    """One frame, reduced to what the sheet shows.

    Parameters
    ----------
    frame, mean
        Its number, and its mean dE2000.
    xyz_spectral, xyz_rgb
        (h, w, 3) float32 the renders.
    delta_e, seen
        (h, w) the map, 0 where no pixel is valid; and where any is.
    white_luminance
        Y of white of its comparison.
    adapted_white
        XYZ (3,) of the light that the eye is adapted to, Y = 1; or None.
    """

    frame: int
    mean: float
    xyz_spectral: FloatArray
    xyz_rgb: FloatArray
    delta_e: FloatArray
    seen: BoolArray
    white_luminance: float
    adapted_white: FloatArray | None


class Tiles:
    """The frames that the sheet shows: an even choice, and beyond it only the worst so far, so that memory does not grow."""

    def __init__(self, frames: Sequence[int]) -> None:
        count = min(len(frames), MOST_FRAMES)
        places = np.unique(np.rint(np.linspace(0, max(len(frames) - 1, 0), count)).astype(int)).tolist()
        self.of = len(frames)
        self.chosen = frozenset(frames[place] for place in places)
        self.columns = 1 if count <= 3 else 2 if count <= 12 else 3
        self._kept: dict[int, FrameTile] = {}

    @property
    def picture_width_in(self) -> float:
        """Width of each of a frame's three pictures."""
        return (self.column_in - 2 * _PICTURE_GAP_IN) / 3

    @property
    def column_in(self) -> float:
        """Width of a frame's three pictures beside each other."""
        return (_CONTENT_IN - (self.columns - 1) * _COLUMN_GAP_IN) / self.columns

    def tile(
        self,
        frame: int,
        mean: float,
        comparison: Comparison,
        renders: tuple[FloatArray, FloatArray],
        adapted_white: FloatArray | None,
    ) -> FrameTile | None:
        """A frame's pictures in the size of the sheet; None if it will not be shown."""
        if frame not in self.chosen and mean <= self.worst_mean:
            return None
        finite = np.isfinite(renders[0]).all(-1) & np.isfinite(renders[1]).all(-1)
        spectral, rgb = (
            self._reduced(np.where(finite[..., None], image, 0).astype(np.float32)) for image in renders
        )
        share = self._reduced(comparison.valid.astype(np.float32))
        summed = self._reduced(np.nan_to_num(comparison.delta_e_map).astype(np.float32))
        seen = share > 1e-3
        return FrameTile(
            frame, mean, spectral, rgb, np.where(seen, summed / np.where(seen, share, 1), 0), seen,
            float(comparison.white_xyz[1]), None if adapted_white is None else adapted_white / adapted_white[1],
        )  # fmt: skip

    def add(self, tile: FrameTile) -> None:
        """Keep a frame; a worse one than that kept for being the worst takes its place."""
        worst = max(self._kept.values(), key=lambda kept: kept.mean, default=None)
        self._kept[tile.frame] = tile
        if worst is not None and worst.frame not in self.chosen and worst.mean < tile.mean:
            del self._kept[worst.frame]

    @property
    def worst_mean(self) -> float:
        """The largest mean dE2000 of the frames kept; below 0 without any."""
        return max((tile.mean for tile in self._kept.values()), default=-1.0)

    def shown(self) -> list[FrameTile]:
        """The frames to show, ascending."""
        return [self._kept[frame] for frame in sorted(self._kept)]

    def _reduced(self, image: FloatArray) -> FloatArray:
        """The means of an image's pixels, (h, w, ...), as large as it is shown; never larger than it is."""
        height, width = image.shape[:2]
        factor = min(
            1.0, self.picture_width_in * PIXELS_PER_INCH * min(1.0, _TALLEST * width / height) / width
        )
        size = max(1, round(width * factor)), max(1, round(height * factor))
        return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.float32)


def contact_sheet(
    tiles: Tiles,
    numbers: Sequence[tuple[int, float, float]],
    *,
    title: str,
    left_out: str = "",
    blur_px: float = 0.0,
) -> Figure:
    """One page, 1800 pixels wide: dE2000 over the frames, and below it the frames themselves.

    Parameters
    ----------
    tiles
        The frames shown.
    numbers
        Of every compared frame: its number, mean and 99th percentile of dE2000.
    title
        The heading.
    left_out
        The frames that were not compared, in words.
    blur_px
        The blur the numbers were taken after.

    Notes
    -----
    All pictures have one exposure, one white balance and one view transform, all maps one scale, so that frames can be compared
    with each other. A map's pixel is the mean of those that it stands for.
    """
    shown = tiles.shown()
    ceiling = _ceiling(numbers)
    widest = max(min(tile.seen.shape[0] / tile.seen.shape[1], _TALLEST) for tile in shown)
    picture_in = tiles.picture_width_in * widest
    row_in = _LABEL_IN + picture_in + _ROW_GAP_IN
    curve_in = _CURVE_IN + 0.65 if len(numbers) > 1 else 0.0
    top_in = _HEADER_IN + curve_in
    rows = -(-len(shown) // tiles.columns)
    worst = max(numbers, key=lambda row: row[1])
    with house_style():
        figure = new_figure(WIDTH_IN, top_in + 0.25 + rows * row_in + 0.35)
        _draw_head(figure, tiles, numbers, (title, left_out), blur_px)
        _draw_scale(figure, ceiling, max(row[2] for row in numbers) > ceiling)
        if curve_in:
            _draw_curve(
                axes_at(figure, _MARGIN_IN + 0.35, _HEADER_IN, _CONTENT_IN - 0.35, _CURVE_IN), numbers
            )
        exposure, white = _shown_alike(shown)
        for index, tile in enumerate(shown):
            row, column = divmod(index, tiles.columns)
            left_in = _MARGIN_IN + column * (tiles.column_in + _COLUMN_GAP_IN)
            if row == 0:
                _draw_names(figure, left_in, top_in + 0.1, tiles.picture_width_in)
            pictures = [_shown(xyz, white, exposure) for xyz in (tile.xyz_spectral, tile.xyz_rgb)]
            _draw_tile(
                figure, (left_in, top_in + 0.25 + row * row_in), (tiles.picture_width_in, picture_in),
                [*pictures, _map_picture(tile, ceiling)], tile, worst=tile.frame == worst[0],
            )  # fmt: skip
    return figure


def _ceiling(numbers: Sequence[tuple[int, float, float]]) -> float:
    """The end of the scale of all maps: the first of `CEILINGS` that nearly every pixel of every frame stays below."""
    highest = max(row[2] for row in numbers)
    return next((ceiling for ceiling in CEILINGS if ceiling >= highest), CEILINGS[-1])


def _shown_alike(shown: Sequence[FrameTile]) -> tuple[float, FloatArray | None]:
    """The exposure, and the white to balance by, of all frames."""
    exposure = exposure_for_white(float(np.median([tile.white_luminance for tile in shown])))
    whites = [tile.adapted_white for tile in shown if tile.adapted_white is not None]
    return exposure, np.mean(whites, axis=0) if whites else None


def _shown(xyz: FloatArray, white: FloatArray | None, exposure: float) -> Picture:
    return tone_map(xyz if white is None else adapted_to_d65(xyz, white), exposure)


def _map_picture(tile: FrameTile, ceiling: float) -> Picture:
    colours = np.rint(255 * delta_e_colours()(np.clip(tile.delta_e / ceiling, 0, 1))[..., :3])
    return np.where(tile.seen[..., None], colours, _PALE).astype(np.uint8)


def _text(figure: Figure, text: str, left_in: float, top_in: float, **style: object) -> None:
    """Text whose baseline starts at a place in inches from the left and top edges."""
    height_in = figure.get_size_inches()[1]
    figure.text(left_in / WIDTH_IN, 1 - top_in / height_in, text, va="baseline", **style)  # type: ignore[arg-type]


def _draw_head(
    figure: Figure,
    tiles: Tiles,
    numbers: Sequence[tuple[int, float, float]],
    words: tuple[str, str],
    blur_px: float,
) -> None:
    """The heading, what is shown, and which frames were not compared."""
    title, left_out = words
    worst = max(numbers, key=lambda row: row[1])
    mean = np.mean([row[1] for row in numbers])
    count = len(tiles.shown())
    told = [
        f"{len(numbers)} of {tiles.of} frames compared" if len(numbers) < tiles.of else f"{tiles.of} frames",
        *([f"{count} of them shown, evenly chosen, and the worst"] if count < len(numbers) else []),
        f"mean ΔE₀₀ {mean:.2f}",
        f"worst: frame {worst[0]}, mean {worst[1]:.2f}",
        *([f"blurred, σ = {blur_px:g} px"] if blur_px else []),
    ]
    _text(figure, short_name(title, 90), _MARGIN_IN, 0.45, fontsize=14, fontweight="bold")
    _text(figure, "  ·  ".join(told), _MARGIN_IN, 0.68, fontsize=8.5, color=SOFT_INK)
    if left_out:
        _text(
            figure,
            short_name(f"Not compared: {left_out}", 150),
            _MARGIN_IN,
            0.86,
            fontsize=8,
            color=VERMILION,
        )


def _draw_scale(figure: Figure, ceiling: float, beyond: bool) -> None:
    """The scale of all maps, at the page's right."""
    axes = axes_at(figure, WIDTH_IN - _MARGIN_IN - 2.4, 0.5, 2.4, 0.09)
    bar = figure.colorbar(
        ScalarMappable(Normalize(0, ceiling), delta_e_colours()),
        cax=axes,
        orientation="horizontal",
        extend="max" if beyond else "neither",
    )
    if ceiling <= 5:
        ticks = sorted({0.0, 1.0, 2.0, ceiling})
        bar.set_ticks(ticks, labels=[f"{tick:g}" for tick in ticks])
    bar.outline.set_visible(False)
    axes.tick_params(length=2.0, pad=2.0)
    _text(
        figure,
        "ΔE₀₀, all frames on one scale",
        WIDTH_IN - _MARGIN_IN - 2.4,
        0.43,
        fontsize=7.5,
        color=SOFT_INK,
    )


def _draw_curve(axes: Axes, numbers: Sequence[tuple[int, float, float]]) -> None:
    """Mean and 99th percentile of dE2000 over the frames, the worst marked."""
    frames, means, high = (np.array(column) for column in zip(*numbers, strict=True))
    marker = "o" if len(frames) <= 2 * MOST_FRAMES else ""
    for values, colour, name in ((high, RULE, "99 % of the pixels below"), (means, BLUE, "mean")):
        axes.plot(frames, values, marker=marker, markersize=2.5, color=colour, label=name)
    worst = int(np.argmax(means))
    axes.plot(frames[worst], means[worst], "o", markersize=5, color=VERMILION, label="worst mean")
    axes.set_ylim(0, max(1.0, 1.1 * float(high.max())))
    axes.set_xlim(frames[0] - 0.5, frames[-1] + 0.5)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_xlabel("frame", labelpad=1)
    axes.set_ylabel("ΔE₀₀")
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=3, borderaxespad=0.0)


def _draw_names(figure: Figure, left_in: float, top_in: float, width_in: float) -> None:
    """What the three pictures of a column are."""
    for index, name in enumerate(("Spectral", "Cycles RGB", "ΔE₀₀")):
        _text(
            figure,
            name,
            left_in + index * (width_in + _PICTURE_GAP_IN),
            top_in,
            fontsize=8,
            fontweight="bold",
        )


def _draw_tile(
    figure: Figure,
    place_in: tuple[float, float],
    size_in: tuple[float, float],
    pictures: Sequence[Picture],
    tile: FrameTile,
    *,
    worst: bool,
) -> None:
    """One frame: its number and mean dE2000, and below them its pictures from a box's top."""
    left_in, top_in = place_in
    width_in, height_in = size_in
    colour = VERMILION if worst else INK
    _text(figure, f"Frame {tile.frame}", left_in, top_in + 0.17, fontsize=8, fontweight="bold", color=colour)
    label = f"ΔE₀₀ {tile.mean:.2f}" + (", the worst" if worst else "")
    _text(figure, label, left_in + 0.85, top_in + 0.17, fontsize=8, color=colour)
    for index, picture in enumerate(pictures):
        axes = axes_at(
            figure, left_in + index * (width_in + _PICTURE_GAP_IN), top_in + _LABEL_IN, width_in, height_in
        )
        axes.set_anchor("NW")
        show_picture(axes, picture)

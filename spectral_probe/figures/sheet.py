"""The comparison sheet: light, renders, their difference, chromaticities, ways of RGB and numbers on one page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..model import FloatArray
from ..render.compare import CLIP, Comparison
from ..render.rgb_ways import RgbWays
from . import rgb_ways
from .chromaticity import draw_chromaticity, shifts_of
from .difference import delta_e_picture, draw_scale
from .display import Picture
from .numbers import numbers_line, spectrum_numbers, wrapped
from .pair import shown_pair, wipe_picture
from .panorama import draw_panorama
from .spectrum import SpectrumPlot, draw_spectrum
from .style import INK, SOFT_INK, axes_at, house_style, new_figure, show_picture
from .table import HEAD, MOST_ROWS, difference_rows, draw_table

WIDTH_IN = 12.0
"""Width of the page: 1800 pixels."""

_MARGIN_IN = 0.5
_CONTENT_IN = WIDTH_IN - 2 * _MARGIN_IN
_HEADER_IN = 0.74
_SUBTITLE_IN = 0.24
_CAPTION_IN = 0.28  # from a row's top to its panels
_ROW_GAP_IN = 0.58  # below a row's panels, with the numbers of their axes
_IMAGE_GAP_IN = 0.25
_TALLEST_IMAGE_IN = 3.75
_PANORAMA_IN = 5.8
_DIAGRAM_IN = 3.3
_COLUMNS_IN = (
    _MARGIN_IN,
    _MARGIN_IN + 3.95,
    _MARGIN_IN + 7.95,
)  # of the two diagrams and the table beside them
_TABLE_ROW_IN = 0.235
_TABLE_IN = 7.4
_LINE_IN = 0.19


@dataclass(frozen=True)
class SheetContent:
    """What a comparison sheet shows.

    Parameters
    ----------
    comparison
        The comparison of the two renders.
    xyz_spectral, xyz_rgb
        (H, W, 3) the renders it was made of. Both are shown with one exposure and one view transform.
    ways
        Metals under one light by four ways of RGB.
    split
        Where the wipe changes from the spectral to the RGB render, a share of the width.
    adapted_white
        XYZ (3,) of the light that the eye is adapted to: both pictures are white-balanced to it. None shows them as they are.
    composed
        A photograph and the same with the objects in it, sRGB pictures of one size, or None.
    title, subtitle
        The heading and the line below it.
    panorama
        (Hp, Wp, 3) sRGB picture of the light (`panorama_preview`), or None.
    spectra
        Spectra of regions of the panorama; the first three are drawn.
    numbers
        Further numbers, text by name, such as "Spectral render": "41 s, 5 passes".
    """

    comparison: Comparison
    xyz_spectral: FloatArray
    xyz_rgb: FloatArray
    ways: RgbWays
    split: float = 0.5
    title: str = "Spectral and RGB render compared"
    subtitle: str = ""
    panorama: Picture | None = None
    spectra: Sequence[SpectrumPlot] = ()
    numbers: Mapping[str, str] = field(default_factory=dict)
    adapted_white: FloatArray | None = None
    composed: tuple[Picture, Picture] | None = None


def comparison_sheet(content: SheetContent) -> Figure:
    """One page, 1800 pixels wide, with everything about a spectral and an RGB render.

    From top to bottom: panorama and recovered spectra (where there are any); spectral render, RGB render, both in one picture
    with a divider, and the dE2000 map; a photograph without and with the objects (where there is one); xy diagrams of the objects
    and of metals by four ways of RGB; the numbers.
    """
    light_in, images_in, numbers_in = (
        _light_height_in(content),
        _images_height_in(content),
        _numbers_height_in(content),
    )
    header_in = _HEADER_IN + (_SUBTITLE_IN if content.subtitle else 0.0)
    diagrams_in = _CAPTION_IN + 0.2 + _DIAGRAM_IN + _ROW_GAP_IN
    above_in = header_in + (light_in + _CAPTION_IN + _ROW_GAP_IN if light_in else 0.0)
    composed_in = _composed_height_in(content)
    with house_style():
        height_in = above_in + images_in + composed_in + diagrams_in + numbers_in + 0.3
        page = _Page(new_figure(WIDTH_IN, height_in), iter("abcdefghijklmn"))
        page.text(content.title, _MARGIN_IN, 0.50, fontsize=15, fontweight="bold")
        page.text(content.subtitle, _MARGIN_IN, 0.73, fontsize=8.5, color=SOFT_INK)
        if light_in:
            _draw_light(page, content, header_in, light_in)
        _draw_images(page, content, above_in)
        _draw_composed(page, content, above_in + images_in)
        _draw_diagrams(page, content, above_in + images_in + composed_in)
        _draw_numbers(page, content, above_in + images_in + composed_in + diagrams_in)
    return page.figure


@dataclass(frozen=True)
class _Page:
    """The figure, and the letters its panels are still to be called by."""

    figure: Figure
    letters: Iterator[str]

    def text(self, text: str, left_in: float, top_in: float, **style: object) -> None:
        """Text whose baseline starts at a place in inches from the left and top edges."""
        height_in = self.figure.get_size_inches()[1]
        self.figure.text(left_in / WIDTH_IN, 1 - top_in / height_in, text, va="baseline", **style)  # type: ignore[arg-type]

    def caption(self, text: str, left_in: float, top_in: float, detail: str = "") -> str:
        """Name a panel: its letter, its name, and in a fainter tone what it shows. Returns the letter."""
        letter = next(self.letters)
        baseline_in = top_in + _CAPTION_IN - 0.1
        self.text(letter, left_in, baseline_in, fontsize=8.5, fontweight="bold")
        height_in = self.figure.get_size_inches()[1]
        name = self.figure.text((left_in + 0.17) / WIDTH_IN, 1 - baseline_in / height_in, text, fontsize=8.5)
        right_in = left_in + 0.17 + name.get_window_extent().width / self.figure.dpi
        self.text(detail, right_in + 0.12, baseline_in, fontsize=7.0, color=SOFT_INK)
        return letter


def _light_height_in(content: SheetContent) -> float:
    if content.panorama is not None:
        return _PANORAMA_IN / 2
    return 2.0 if content.spectra else 0.0


def _image_columns(content: SheetContent) -> int:
    """Two pictures beside each other, or all four where they are no wider than high."""
    height_px, width_px = content.comparison.valid.shape
    return 2 if width_px > height_px else 4


def _image_size_in(content: SheetContent) -> tuple[float, float]:
    """Width and height of each of the four pictures, as large as the page allows."""
    columns = _image_columns(content)
    height_px, width_px = content.comparison.valid.shape
    width_in = (_CONTENT_IN - (columns - 1) * _IMAGE_GAP_IN) / columns
    height_in = width_in * height_px / width_px
    if height_in <= _TALLEST_IMAGE_IN:
        return width_in, height_in
    return _TALLEST_IMAGE_IN * width_px / height_px, _TALLEST_IMAGE_IN


def _images_height_in(content: SheetContent) -> float:
    """Of the pictures in their rows, with their captions, and the scale below the last."""
    rows = 4 // _image_columns(content)
    return rows * (_image_size_in(content)[1] + _CAPTION_IN) + (rows - 1) * 0.1 + 0.45


def _composed_height_in(content: SheetContent) -> float:
    """Of the photograph without and with the objects, beside each other."""
    if content.composed is None:
        return 0.0
    height_px, width_px = content.composed[0].shape[:2]
    return float(_CAPTION_IN + (_CONTENT_IN - _IMAGE_GAP_IN) / 2 * height_px / width_px + 0.3)


def _numbers_height_in(content: SheetContent) -> float:
    table_in = (1 + len(difference_rows(content.comparison))) * _TABLE_ROW_IN
    return _CAPTION_IN + max(
        table_in + 0.24 + len(_notes(content)) * _LINE_IN, len(content.numbers) * _LINE_IN
    )


def _draw_light(page: _Page, content: SheetContent, top_in: float, height_in: float) -> None:
    """The panorama with the spectra beside it, or the spectra alone side by side."""
    spectra = list(content.spectra[:3])
    axes = None
    if content.panorama is not None:
        page.caption(
            "Recovered light", _MARGIN_IN, top_in, "compass bearing and elevation; hatched where not seen"
        )
        axes = axes_at(page.figure, _MARGIN_IN, top_in + _CAPTION_IN, _PANORAMA_IN, height_in)
        draw_panorama(axes, content.panorama)
    for index, plot in enumerate(spectra):
        if axes is None:
            width_in = (_CONTENT_IN - 0.45 * (len(spectra) - 1)) / len(spectra)
            box = (_MARGIN_IN + index * (width_in + 0.45), top_in, width_in, height_in + _CAPTION_IN)
        else:
            slot_in = (height_in + _CAPTION_IN + 0.42) / len(spectra)
            left_in = _MARGIN_IN + _PANORAMA_IN + 0.6
            box = (left_in, top_in + index * slot_in, WIDTH_IN - _MARGIN_IN - left_in, slot_in - 0.42)
        letter = _draw_light_spectrum(page, plot, box)
        if axes is not None and plot.bearing_deg is not None:
            _mark_bearing(axes, plot.bearing_deg, letter)


def _draw_light_spectrum(page: _Page, plot: SpectrumPlot, box: tuple[float, float, float, float]) -> str:
    """One spectrum with its name and numbers above it in a box (left, top, width, height) in inches."""
    left_in, top_in, width_in, height_in = box
    letter = page.caption(plot.title, left_in, top_in)
    numbers = spectrum_numbers(plot.wavelengths_nm, plot.estimated, plot.measured, plot.measured_label)
    page.text(
        numbers_line(numbers), left_in + 0.17, top_in + _CAPTION_IN + 0.06, fontsize=7.0, color=SOFT_INK
    )
    head_in = _CAPTION_IN + 0.16
    draw_spectrum(
        axes_at(page.figure, left_in, top_in + head_in, width_in, height_in - head_in),
        plot,
        axis_labels=False,
    )
    return letter


def _mark_bearing(axes: Axes, bearing_deg: tuple[float, float], letter: str) -> None:
    """Ring a direction of the panorama and name the spectrum that was read there."""
    azimuth_deg = (bearing_deg[0] + 90) % 360 - 90
    axes.plot(
        azimuth_deg,
        bearing_deg[1],
        "o",
        markersize=9,
        markerfacecolor="none",
        markeredgecolor=INK,
        markeredgewidth=2.4,
    )
    axes.plot(
        azimuth_deg,
        bearing_deg[1],
        "o",
        markersize=9,
        markerfacecolor="none",
        markeredgecolor="white",
        markeredgewidth=1.2,
    )
    axes.annotate(
        letter,
        (azimuth_deg, bearing_deg[1]),
        xytext=(0, -13),
        textcoords="offset points",
        fontsize=8,
        ha="center",
        fontweight="bold",
        color="white",
        bbox={"boxstyle": "round,pad=0.15", "facecolor": INK, "linewidth": 0, "alpha": 0.75},
        va="center",
    )


def _draw_images(page: _Page, content: SheetContent, top_in: float) -> None:
    """Spectral render, RGB render, both as a wipe, and the map of their difference with its scale."""
    comparison = content.comparison
    width_in, height_in = _image_size_in(content)
    spectral, rgb = shown_pair(comparison, content.xyz_spectral, content.xyz_rgb, content.adapted_white)
    blur = f"blurred, σ = {comparison.blur_px:g} px" if comparison.blur_px else "pixel by pixel"
    balance = "" if content.adapted_white is None else "white-balanced"
    panels = (
        ("Spectral render", balance, spectral),
        ("Cycles RGB render", "same exposure and view", rgb),
        ("Wipe", "spectral on the left, RGB on the right", wipe_picture(spectral, rgb, content.split)),
        ("Colour difference ΔE₀₀", blur, delta_e_picture(comparison)),
    )
    columns = _image_columns(content)
    for index, (name, detail, picture) in enumerate(panels):
        left_in = _MARGIN_IN + (index % columns) * (_CONTENT_IN + _IMAGE_GAP_IN) / columns
        row_in = top_in + (index // columns) * (height_in + _CAPTION_IN + 0.1)
        page.caption(name, left_in, row_in, detail if columns == 2 or name != "Wipe" else "")
        show_picture(axes_at(page.figure, left_in, row_in + _CAPTION_IN, width_in, height_in), picture)
    scale_in = row_in + _CAPTION_IN + height_in + 0.09
    draw_scale(axes_at(page.figure, left_in, scale_in, width_in, 0.08), comparison)


def _draw_composed(page: _Page, content: SheetContent, top_in: float) -> None:
    """The photograph, and beside it the composite."""
    if content.composed is None:
        return
    width_in = (_CONTENT_IN - _IMAGE_GAP_IN) / 2
    names = (("Photograph", "as taken"), ("Composite", "the objects in it, rendered spectrally"))
    for index, (picture, (name, detail)) in enumerate(zip(content.composed, names, strict=True)):
        left_in = _MARGIN_IN + index * (width_in + _IMAGE_GAP_IN)
        page.caption(name, left_in, top_in, detail)
        height_in = width_in * picture.shape[0] / picture.shape[1]
        show_picture(axes_at(page.figure, left_in, top_in + _CAPTION_IN, width_in, height_in), picture)


def _draw_diagrams(page: _Page, content: SheetContent, top_in: float) -> None:
    """The objects' chromaticities, those of metals by four ways of RGB, and the table of the latter."""
    objects_in, ways_in, table_in = _COLUMNS_IN
    below_in = top_in + _CAPTION_IN + 0.2
    page.caption("Chromaticity, CIE 1931 2°", objects_in, top_in, "of the renders")
    draw_chromaticity(
        axes_at(page.figure, objects_in + 0.4, below_in, _DIAGRAM_IN, _DIAGRAM_IN),
        shifts_of(content.comparison),
    )
    page.caption("Four ways of RGB", ways_in, top_in, f"metals under {content.ways.light}")
    rgb_ways.draw_rgb_ways(
        axes_at(page.figure, ways_in + 0.4, below_in, _DIAGRAM_IN, _DIAGRAM_IN), content.ways
    )
    rows = rgb_ways.ways_rows(content.ways)
    width_in, height_in = WIDTH_IN - _MARGIN_IN - table_in, (1 + len(rows)) * _TABLE_ROW_IN
    axes = axes_at(page.figure, table_in, below_in, width_in, height_in)
    draw_table(axes, rgb_ways.HEAD, rows, rgb_ways.RIGHT_EDGES, row_height=1 / (1 + len(rows)))
    line_in = below_in + height_in + 0.24
    for note in rgb_ways.ways_notes(content.ways):
        for line in wrapped(note.split(), width_in, " ", fontsize=7.0):
            page.text(line, table_in, line_in, fontsize=7.0, color=SOFT_INK)
            line_in += _LINE_IN


def _draw_numbers(page: _Page, content: SheetContent, top_in: float) -> None:
    """The table of differences, what it means, and beside it further numbers."""
    page.caption("Differences in numbers", _MARGIN_IN, top_in)
    rows = difference_rows(content.comparison)
    table_in = (1 + len(rows)) * _TABLE_ROW_IN
    axes = axes_at(page.figure, _MARGIN_IN, top_in + _CAPTION_IN, _TABLE_IN, table_in)
    draw_table(axes, HEAD, rows, row_height=1 / (1 + len(rows)))
    line_in = top_in + _CAPTION_IN + table_in + 0.24
    for note in _notes(content):
        page.text(note, _MARGIN_IN, line_in, fontsize=7.0, color=SOFT_INK)
        line_in += _LINE_IN
    for index, (name, value) in enumerate(content.numbers.items()):
        line_in = top_in + _CAPTION_IN + 0.15 + index * _LINE_IN
        page.text(name, _COLUMNS_IN[2], line_in, fontsize=7.5, color=SOFT_INK)
        page.text(value, _COLUMNS_IN[2] + 1.2, line_in, fontsize=7.5)


def _notes(content: SheetContent) -> list[str]:
    """What the table's numbers mean, one line each."""
    comparison = content.comparison
    blur = f"both renders blurred by σ = {comparison.blur_px:g} px; " if comparison.blur_px else ""
    white = f"white is D65 at Y = {comparison.white_xyz[1]:.4g}"
    clipped = f"values clipped at {CLIP:g} × white ({100 * comparison.clipped_fraction:.1f} % of the pixels)"
    lines = [
        f"ΔE₀₀: {blur}{white}, {clipped}.",
        "x, y and “of means”: of a region’s light added up: noise averages out. Shifts are RGB − spectral.",
    ]
    if len(comparison.objects) > MOST_ROWS:
        lines.append(
            f"The {MOST_ROWS} largest of {len(comparison.objects)} objects; all are in compare.json."
        )
    if any(comparison.not_finite):
        lines.append(
            "Left out as not numbers: {} pixels of the spectral, {} of the RGB render.".format(
                *comparison.not_finite
            )
        )
    if comparison.unseen_objects:
        lines.append(f"Not in the picture: {', '.join(comparison.unseen_objects)}.")
    return lines

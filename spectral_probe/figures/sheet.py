"""The comparison sheet: light, renders, their difference, chromaticities and numbers on one page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..model import FloatArray
from ..render.compare import CLIP, Comparison
from ..spectra.colorimetry import adapted_to_d65
from .chromaticity import draw_chromaticity, shifts_of
from .difference import delta_e_picture, draw_scale
from .display import Picture, exposure_for_white, tone_map
from .numbers import numbers_line, spectrum_numbers
from .panorama import draw_panorama
from .spectrum import SpectrumPlot, draw_spectrum
from .style import INK, SOFT_INK, axes_at, house_style, new_figure, show_picture
from .table import HEAD, difference_rows, draw_table

WIDTH_IN = 12.0
"""Width of the page: 1800 pixels."""

_MARGIN_IN = 0.5
_CONTENT_IN = WIDTH_IN - 2 * _MARGIN_IN
_HEADER_IN = 0.74
_SUBTITLE_IN = 0.24
_CAPTION_IN = 0.28  # from a row's top to its panels
_ROW_GAP_IN = 0.58  # below a row's panels, with the numbers of their axes
_IMAGE_GAP_IN = 0.2
_PANORAMA_IN = 6.4
_TABLE_ROW_IN = 0.235
_LINE_IN = 0.2


@dataclass(frozen=True)
class SheetContent:
    """What a comparison sheet shows.

    Parameters
    ----------
    comparison
        The comparison of the two renders.
    xyz_spectral, xyz_rgb
        (H, W, 3) the renders it was made of. Both are shown with one exposure and one view transform.
    adapted_white
        XYZ (3,) of the light that the eye is adapted to: both pictures are white-balanced to it. None shows them as they are.
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
    title: str = "Spectral and RGB render compared"
    subtitle: str = ""
    panorama: Picture | None = None
    spectra: Sequence[SpectrumPlot] = ()
    numbers: Mapping[str, str] = field(default_factory=dict)
    adapted_white: FloatArray | None = None


def comparison_sheet(content: SheetContent) -> Figure:
    """One page, 1800 pixels wide, with everything about a spectral and an RGB render.

    From top to bottom: panorama and recovered spectra (where there are any); spectral render, RGB render and
    dE2000 map; xy diagram and table of numbers.
    """
    light_in, (_, image_in), numbers_in = (
        _light_height_in(content),
        _image_size_in(content),
        _numbers_height_in(content),
    )
    rows_in = (
        (light_in + _CAPTION_IN + _ROW_GAP_IN if light_in else 0.0) + image_in + 2 * _CAPTION_IN + _ROW_GAP_IN
    )
    header_in = _HEADER_IN + (_SUBTITLE_IN if content.subtitle else 0.0)
    with house_style():
        page = _Page(new_figure(WIDTH_IN, header_in + rows_in + numbers_in + 0.42), iter("abcdefghijkl"))
        page.text(content.title, _MARGIN_IN, 0.50, fontsize=15, fontweight="bold")
        page.text(content.subtitle, _MARGIN_IN, 0.73, fontsize=8.5, color=SOFT_INK)
        top_in = header_in
        if light_in:
            _draw_light(page, content, top_in, light_in)
            top_in += light_in + _CAPTION_IN + _ROW_GAP_IN
        _draw_images(page, content, top_in)
        top_in += image_in + _CAPTION_IN + _ROW_GAP_IN
        _draw_numbers(page, content, top_in)
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


def _image_size_in(content: SheetContent) -> tuple[float, float]:
    """Width and height of each of the three images: a third of the page, but no taller than 4.2 in."""
    height_px, width_px = content.comparison.valid.shape
    width_in = (_CONTENT_IN - 2 * _IMAGE_GAP_IN) / 3
    height_in = width_in * height_px / width_px
    return (width_in, height_in) if height_in <= 4.2 else (4.2 * width_px / height_px, 4.2)


def _numbers_height_in(content: SheetContent) -> float:
    table_in = (1 + len(difference_rows(content.comparison))) * _TABLE_ROW_IN
    lines = len(_notes(content)) + (len(content.numbers) + 1) // 2
    return max(3.75, _CAPTION_IN + table_in + 0.5 + lines * _LINE_IN)


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
    """Spectral render, RGB render and the map of their difference, with its scale."""
    comparison = content.comparison
    width_in, height_in = _image_size_in(content)
    exposure = exposure_for_white(float(comparison.white_xyz[1]))
    blur = f"blurred, σ = {comparison.blur_px:g} px" if comparison.blur_px else "pixel by pixel"
    balance, balanced = "", [content.xyz_spectral, content.xyz_rgb]
    if content.adapted_white is not None:
        balance, balanced = "white-balanced", [adapted_to_d65(xyz, content.adapted_white) for xyz in balanced]
    panels = (
        ("Spectral render", balance, tone_map(balanced[0], exposure)),
        ("Cycles RGB render", "same exposure and view", tone_map(balanced[1], exposure)),
        ("Colour difference ΔE₀₀", blur, delta_e_picture(comparison)),
    )
    left_in = _MARGIN_IN
    for index, (name, detail, picture) in enumerate(panels):
        left_in = _MARGIN_IN + index * (_CONTENT_IN + _IMAGE_GAP_IN) / 3
        page.caption(name, left_in, top_in, detail)
        show_picture(axes_at(page.figure, left_in, top_in + _CAPTION_IN, width_in, height_in), picture)
    draw_scale(
        axes_at(page.figure, left_in, top_in + _CAPTION_IN + height_in + 0.09, width_in, 0.08), comparison
    )


def _draw_numbers(page: _Page, content: SheetContent, top_in: float) -> None:
    """The xy diagram on the left, table and further numbers on the right."""
    page.caption("Chromaticity, CIE 1931 2°", _MARGIN_IN, top_in)
    side_in = 3.75 - _CAPTION_IN - 0.2
    draw_chromaticity(
        axes_at(page.figure, _MARGIN_IN + 0.4, top_in + _CAPTION_IN + 0.2, side_in, side_in),
        shifts_of(content.comparison),
    )
    left_in = _MARGIN_IN + 0.4 + side_in + 0.55
    width_in = WIDTH_IN - _MARGIN_IN - left_in
    page.caption("Differences in numbers", left_in, top_in)
    rows = difference_rows(content.comparison)
    table_in = (1 + len(rows)) * _TABLE_ROW_IN
    axes = axes_at(page.figure, left_in, top_in + _CAPTION_IN, width_in, table_in)
    draw_table(axes, HEAD, rows, row_height=1 / (1 + len(rows)))
    line_in = top_in + _CAPTION_IN + table_in + 0.24
    for note in _notes(content):
        page.text(note, left_in, line_in, fontsize=7.0, color=SOFT_INK)
        line_in += _LINE_IN
    line_in += 0.12
    for index, (name, value) in enumerate(content.numbers.items()):
        column_in = left_in + (index % 2) * width_in / 2
        page.text(name, column_in, line_in + (index // 2) * _LINE_IN, fontsize=7.5, color=SOFT_INK)
        page.text(value, column_in + 1.35, line_in + (index // 2) * _LINE_IN, fontsize=7.5)


def _notes(content: SheetContent) -> list[str]:
    """What the table's numbers mean, one line each."""
    comparison = content.comparison
    blur = f"both renders blurred by σ = {comparison.blur_px:g} px; " if comparison.blur_px else ""
    white = f"white is D65 at Y = {comparison.white_xyz[1]:.3g}"
    clipped = f"values clipped at {CLIP:g} × white ({100 * comparison.clipped_fraction:.1f} % of the pixels)"
    lines = [
        f"ΔE₀₀: {blur}{white}, {clipped}.",
        "x, y and “of means”: of a region’s light added up: noise averages out. Shifts are RGB − spectral.",
    ]
    if comparison.unseen_objects:
        lines.append(f"Not in the picture: {', '.join(comparison.unseen_objects)}.")
    return lines

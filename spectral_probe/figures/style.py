"""What all figures share: one typeface, few colours, and saving that gives the same file every time.

Figures are made with matplotlib's objects alone (`Figure`, never pyplot), so nothing outlives them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ..errors import FileFormatError
from ..files.atomic import written_whole
from ..model import BoolArray

INK = "#1c2127"
SOFT_INK = "#5d6672"
RULE = "#c8cdd4"
BLUE = "#0068a8"
VERMILION = "#cf4f08"
CURVE_COLOURS = (BLUE, VERMILION, "#1b8a5a", "#8a5aa8", "#a88b1f", "#3a9fb5")
RGB_COLOURS = ("#c22f2f", "#1b8a5a", "#2c55b8")

PIXELS_PER_INCH = 150
FORMATS = (".png", ".svg")

_SETTINGS: Mapping[str, Any] = {
    "font.family": ["DejaVu Sans"],  # comes with matplotlib: the same letters on every machine
    "font.size": 8.0,
    "text.color": INK,
    "text.hinting": "none",
    "axes.edgecolor": SOFT_INK,
    "axes.labelcolor": SOFT_INK,
    "axes.labelsize": 7.5,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 8.5,
    "axes.unicode_minus": True,
    "xtick.color": SOFT_INK,
    "ytick.color": SOFT_INK,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "legend.frameon": False,
    "legend.fontsize": 7.5,
    "lines.linewidth": 1.5,
    "lines.solid_capstyle": "round",
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "svg.fonttype": "path",
    "svg.hashsalt": "spectral-probe",
    "image.interpolation": "antialiased",
}


@contextmanager
def house_style() -> Iterator[None]:
    """Matplotlib's settings for our figures inside the block, and the caller's own again after it."""
    with mpl.rc_context(dict(_SETTINGS)):  # type: ignore[arg-type]  # its keys are typed one by one
        yield


def new_figure(width_in: float, height_in: float) -> Figure:
    """An empty figure of a size in inches, rounded to whole pixels, 150 to the inch, with a canvas of its own."""
    width_px, height_px = round(width_in * PIXELS_PER_INCH), round(height_in * PIXELS_PER_INCH)
    # A hundredth of a pixel more, since the canvas drops fractions and n / 150 * 150 may fall short of n.
    size_in = ((width_px + 0.01) / PIXELS_PER_INCH, (height_px + 0.01) / PIXELS_PER_INCH)
    figure = Figure(figsize=size_in, dpi=PIXELS_PER_INCH)
    FigureCanvasAgg(figure)
    return figure


def axes_at(figure: Figure, left_in: float, top_in: float, width_in: float, height_in: float) -> Axes:
    """Axes placed in inches from the figure's left and top edges."""
    width, height = figure.get_size_inches()
    box = (left_in / width, 1 - (top_in + height_in) / height, width_in / width, height_in / height)
    return figure.add_axes(box)


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure as PNG or SVG, by the suffix; the same figure gives the same bytes.

    Raises
    ------
    FileFormatError
        If the suffix is another.
    """
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise FileFormatError(
            f'"{path.name}": figures are written as .png or .svg. Choose one of these endings.'
        )
    metadata = {"Date": None} if suffix == ".svg" else {"Software": None}
    with house_style(), written_whole(path) as temporary:
        figure.savefig(temporary, format=suffix[1:], dpi=PIXELS_PER_INCH, metadata=metadata)


def hatching(valid: BoolArray, period_px: float) -> BoolArray:
    """Diagonal stripes over the pixels that are not valid, (H, W): True on a stripe."""
    rows, columns = np.indices(valid.shape)
    return np.asarray(((rows + columns) % period_px < period_px / 3) & ~valid)


def show_picture(axes: Axes, picture: npt.NDArray[np.uint8]) -> None:
    """Show sRGB pixels (H, W, 3) in axes, without scales or a frame."""
    axes.imshow(picture)
    axes.set_axis_off()

"""The dE2000 map as a picture: one perceptually uniform scale, its end stated."""

from __future__ import annotations

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, Normalize
from matplotlib.figure import Figure

from ..render.compare import Comparison
from .display import Picture
from .style import axes_at, hatching, house_style, new_figure, show_picture

CEILINGS = (2.0, 5.0, 10.0, 20.0, 50.0)
"""Ends of the colour scale to choose from; at least 2, so that differences nobody sees look like none."""


def delta_e_figure(comparison: Comparison, *, title: str = "Colour difference ΔE₀₀") -> Figure:
    """The dE2000 map alone, with its scale."""
    height, width = comparison.valid.shape
    shown_in = 6.4 * height / width
    total_in = shown_in + 1.15
    with house_style():
        figure = new_figure(7.0, total_in)
        figure.text(0.3 / 7.0, 1 - 0.34 / total_in, title, fontsize=11, fontweight="bold", va="baseline")
        show_picture(axes_at(figure, 0.3, 0.55, 6.4, shown_in), delta_e_picture(comparison))
        draw_scale(axes_at(figure, 0.3, 0.55 + shown_in + 0.12, 6.4, 0.1), comparison)
    return figure


def delta_e_ceiling(comparison: Comparison) -> float:
    """The end of the colour scale: the first of `CEILINGS` that 99 % of the pixels stay below."""
    highest = float(np.nanpercentile(comparison.delta_e_map, 99))
    return next((ceiling for ceiling in CEILINGS if ceiling >= highest), CEILINGS[-1])


def delta_e_colours() -> Colormap:
    """The perceptually uniform colours of a dE2000 map, dark for 0."""
    return colormaps["inferno"]


def delta_e_picture(comparison: Comparison) -> Picture:
    """The dE2000 map as sRGB pixels, (H, W, 3); pixels that are not valid are pale and hatched."""
    scaled = np.clip(np.nan_to_num(comparison.delta_e_map / delta_e_ceiling(comparison)), 0, 1)
    picture = np.asarray(np.rint(255 * delta_e_colours()(scaled)[..., :3]), np.uint8)
    stripes = hatching(comparison.valid, max(6.0, comparison.valid.shape[1] / 80))
    pale = np.where(stripes, 205, 230).astype(np.uint8)[..., None]
    return np.where(comparison.valid[..., None], picture, pale)


def draw_scale(axes: Axes, comparison: Comparison) -> None:
    """Draw the scale of a dE2000 map, horizontal, its end an arrow where pixels lie beyond it."""
    ceiling = delta_e_ceiling(comparison)
    beyond = float(np.nanmax(comparison.delta_e_map)) > ceiling
    mappable = ScalarMappable(Normalize(0, ceiling), delta_e_colours())
    figure = axes.get_figure(root=True)
    if figure is None:
        raise ValueError("the axes belong to no figure")
    bar = figure.colorbar(mappable, cax=axes, orientation="horizontal", extend="max" if beyond else "neither")
    if ceiling <= 5:  # 1 is about the least difference that is seen side by side
        ticks = sorted({0.0, 1.0, 2.0, ceiling})
        bar.set_ticks(ticks, labels=[f"{tick:g}" for tick in ticks])
    bar.outline.set_visible(False)
    axes.tick_params(length=2.0, pad=2.0)

"""Metals under stained glass, and the light they stand in: the picture of the paper's fig. 12 in one sheet."""

from __future__ import annotations

from dataclasses import dataclass

from matplotlib.figure import Figure

from .display import Picture
from .style import INK, SOFT_INK, axes_at, house_style, new_figure, show_picture

_WIDTH_IN, _MARGIN_IN, _GAP_IN, _CAPTION_IN = 8.0, 0.06, 0.08, 0.24


@dataclass(frozen=True)
class StainedGlassSheet:
    """What the sheet shows, sRGB pixels (H, W, 3) each; the renders are of one size.

    Parameters
    ----------
    spectral, rgb
        The renders, in one exposure and one view transform.
    panorama
        The light, twice as wide as high.
    caption, rgb_caption, panorama_caption
        What stands under each.
    """

    spectral: Picture
    rgb: Picture
    panorama: Picture
    caption: str
    rgb_caption: str
    panorama_caption: str


def stained_glass_figure(content: StainedGlassSheet) -> Figure:
    """The spectral render over the whole width; below it the light, and the same in RGB, equally high.

    Examples
    --------
    >>> import numpy as np
    >>> render, light = np.zeros((56, 100, 3), np.uint8), np.zeros((50, 100, 3), np.uint8)
    >>> figure = stained_glass_figure(StainedGlassSheet(render, render, light, "a", "b", "c"))
    >>> len(figure.axes)
    3
    """
    inner_in = _WIDTH_IN - 2 * _MARGIN_IN
    shape = content.spectral.shape[1] / content.spectral.shape[0]
    light_shape = content.panorama.shape[1] / content.panorama.shape[0]
    large_in = inner_in / shape
    small_in = (inner_in - _GAP_IN) / (shape + light_shape)
    below_in = _MARGIN_IN + large_in + _CAPTION_IN
    with house_style():
        figure = new_figure(_WIDTH_IN, below_in + small_in + _CAPTION_IN)
        places = (
            (content.spectral, content.caption, _MARGIN_IN, _MARGIN_IN, inner_in, large_in),
            (
                content.panorama,
                content.panorama_caption,
                _MARGIN_IN,
                below_in,
                small_in * light_shape,
                small_in,
            ),
            (
                content.rgb,
                content.rgb_caption,
                _MARGIN_IN + small_in * light_shape + _GAP_IN,
                below_in,
                small_in * shape,
                small_in,
            ),
        )
        for number, (picture, caption, left, top, width, height) in enumerate(places):
            axes = axes_at(figure, left, top, width, height)
            show_picture(axes, picture)
            axes.text(
                0.0,
                -0.05 / height,
                caption,
                transform=axes.transAxes,
                va="top",
                color=SOFT_INK if number else INK,
                fontsize=7.5,
            )
    return figure

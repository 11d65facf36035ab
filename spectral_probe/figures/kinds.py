"""Which kind of light comes from each direction: daylight, a lamp family, or what a surface reflects."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from matplotlib.colors import to_rgb

from ..model import BoolArray, FloatArray, SpectralPanorama
from ..spectra.recorded import LightKinds, light_kinds
from .display import Picture
from .panorama import panorama_preview
from .style import CURVE_COLOURS, SOFT_INK, axes_at, hatching, house_style, new_figure

_COLOURS = (*CURVE_COLOURS, "#d46a9f", "#7a4a1e", "#8fbf3f", "#2b3f92", "#e0a3b4")
_SURFACES = "#9aa0a8"  # most of every panorama: grey, so that lamps and windows stand out
_UNSEEN = (150, 214)  # greys of the hatching
_SMALLEST_PX = 640  # width: below it the legend's letters would not fit
_LEAST_SHARE = 1e-4  # of the texels seen: rarer kinds are not in the legend


def kinds_preview(panorama: SpectralPanorama, *, max_width_px: int = 2048) -> Picture:
    """The likeliest kind of light of every direction as sRGB pixels: equirectangular, with a legend below.

    The colour is the kind's, as bright as the panorama is there, and the paler the less probable the kind is.

    Parameters
    ----------
    panorama
        The panorama (H, W), a probe of ours.
    max_width_px
        Wider panoramas are made smaller, by the nearest texels.

    Returns
    -------
    ndarray
        (H' + legend, W', 3) uint8. Directions that no view saw are hatched grey.

    Raises
    ------
    FileFormatError
        If the panorama does not tell how its light was recovered.
    """
    kinds, valid = light_kinds(panorama), panorama.valid
    grey = panorama_preview(panorama, max_width_px=max_width_px).mean(-1) / 255
    height, width = grey.shape
    index, probability, seen = (
        _nearest(values, width, height) for values in (kinds.index, kinds.probability, valid.astype(np.uint8))
    )
    if width < _SMALLEST_PX:
        times = -(-_SMALLEST_PX // width)
        index, probability, seen, grey = (
            values.repeat(times, 0).repeat(times, 1) for values in (index, probability, seen, grey)
        )
    colours = np.array([_colour(number, name) for number, name in enumerate(kinds.names)])
    picture = _coloured(colours, index, probability, grey)
    stripes = np.where(hatching(seen > 0, max(6.0, index.shape[1] / 110)), *_UNSEEN)[..., None]
    shown = np.where(seen[..., None] > 0, picture, stripes).astype(np.uint8)
    return np.concatenate([shown, _legend(shown.shape[1], _present(kinds, valid), unseen=not valid.all())])


def _nearest(values: Any, width: int, height: int) -> Any:
    return np.asarray(cv2.resize(values, (width, height), interpolation=cv2.INTER_NEAREST_EXACT))


def _coloured(colours: FloatArray, index: Any, probability: FloatArray, grey: FloatArray) -> FloatArray:
    """(H, W, 3) of kinds (H, W) with colours (N, 3) and a probability, over a picture (H, W) in 0..1."""
    sure = np.clip(probability, 0, 1)[..., None]
    tint = sure * colours[index] + (1 - sure) * 0.75
    return np.asarray(255 * np.clip(tint * (0.3 + 1.1 * grey[..., None]), 0, 1))


def _colour(number: int, name: str) -> tuple[float, float, float]:
    return to_rgb(_SURFACES if name == "reflected" else _COLOURS[number % len(_COLOURS)])


def _present(kinds: LightKinds, valid: BoolArray) -> dict[str, tuple[float, float, float]]:
    """Colours of the kinds that are there, the commonest first."""
    counts = np.bincount(kinds.index[valid], minlength=len(kinds.names))
    common = [number for number in np.argsort(-counts) if counts[number] > _LEAST_SHARE * counts.sum()]
    return {kinds.names[number]: _colour(int(number), kinds.names[number]) for number in common}


def _legend(width_px: int, colours: dict[str, tuple[float, float, float]], *, unseen: bool) -> Picture:
    """A patch of colour and a name for each kind, in rows as wide as the picture above."""
    dots = max(1.0, width_px / 1024)  # larger letters below larger pictures
    cell_in, row_in = 1.55 * dots, 0.22 * dots
    entries = [*colours, *(["not seen"] if unseen else [])]
    across = max(1, int(width_px / 150 / cell_in))
    height_in = row_in * -(-len(entries) // across) + 0.12 * dots
    with house_style():
        figure = new_figure(width_px / 150, height_in)
        for place, name in enumerate(entries):
            left_in = 0.1 * dots + cell_in * (place % across)
            top_in = 0.07 * dots + row_in * (place // across)
            box = axes_at(figure, left_in, top_in, 0.2 * dots, 0.14 * dots)
            if name in colours:
                box.imshow([[colours[name]]], aspect="auto")
            else:
                stripes = np.where(hatching(np.zeros((16, 23), bool), 6.0), *_UNSEEN)
                box.imshow(stripes, cmap="gray", vmin=0, vmax=255, aspect="auto")
            box.set_axis_off()
            figure.text(
                (left_in + 0.27 * dots) / (width_px / 150),
                1 - (top_in + 0.07 * dots) / height_in,
                name,
                va="center",
                color=SOFT_INK,
                fontsize=7.0 * dots,
            )
        figure.canvas.draw()
        pixels = np.asarray(figure.canvas.buffer_rgba())[..., :3]  # type: ignore[attr-defined]  # an Agg canvas
    return np.ascontiguousarray(pixels[:, :width_px])

"""How sure the recovered spectra are, direction by direction, in false colours."""

from __future__ import annotations

from typing import Any

import cv2
import matplotlib as mpl
import numpy as np

from ..model import FloatArray, SpectralPanorama
from ..spectra.edits import edited_confidence
from .display import Picture
from .style import SOFT_INK, axes_at, hatching, house_style, new_figure

COLOUR_MAP = "viridis"
"""Perceptually uniform, legible to eyes that confuse red and green, and without greys. Dark is unsure, bright is sure."""

TICKS = (0.1, 0.5, 0.9, 0.99, 0.999)
"""Confidences marked on the scale."""

_RANGE = (0.05, 0.9995)
_UNSEEN = (150, 214)  # greys of the hatching: the colour map has no light greys
_SMALLEST_PX = 640  # width: below it the scale's letters would not fit


def confidence_preview(panorama: SpectralPanorama, *, max_width_px: int = 2048) -> Picture:
    """The confidence of a panorama, with its edits, as sRGB pixels: equirectangular, with a scale below.

    The scale is even in the odds c / (1 - c), on which a confidence of 0.99 is as far from 0.9 as that is from 0.5: what is
    worth telling apart lies near 1.

    Parameters
    ----------
    panorama
        The panorama (H, W).
    max_width_px
        Wider panoramas are made smaller by area averages of what was seen.

    Returns
    -------
    ndarray
        (H' + scale, W', 3) uint8. Directions that no view saw are hatched grey.
    """
    valid = panorama.valid
    confidence = np.where(valid, np.clip(np.nan_to_num(edited_confidence(panorama)), 0.0, 1.0), 0.0).astype(
        np.float32
    )
    height, width = valid.shape
    if width > max_width_px:
        size = (max_width_px, max(1, round(height * max_width_px / width)))
        seen = np.asarray(cv2.resize(valid.astype(np.float32), size, interpolation=cv2.INTER_AREA))
        shrunk = cv2.resize(confidence, size, interpolation=cv2.INTER_AREA)
        confidence = np.asarray(shrunk / np.maximum(seen, 1e-6), np.float32)
        valid = seen > 0.5
    elif width < _SMALLEST_PX:
        times = -(-_SMALLEST_PX // width)
        confidence = confidence.repeat(times, 0).repeat(times, 1)
        valid = valid.repeat(times, 0).repeat(times, 1)
    picture = mpl.colormaps[COLOUR_MAP](on_scale(confidence), bytes=True)[..., :3]
    stripes = np.where(hatching(valid, max(6.0, valid.shape[1] / 110)), *_UNSEEN)[..., None]
    shown = np.where(valid[..., None], picture, stripes).astype(np.uint8)
    return np.concatenate([shown, _scale(shown.shape[1], unseen=not valid.all())])


def on_scale(confidence: FloatArray) -> FloatArray:
    """Where confidences (...) lie on the scale: 0 at its dark end, 1 at its bright one.

    Examples
    --------
    >>> on_scale(np.array([0.0, 0.5, 0.9, 0.9995])).round(2).tolist()
    [0.0, 0.28, 0.49, 1.0]
    """
    lowest, highest = (np.log(end / (1 - end)) for end in _RANGE)
    clipped = np.clip(confidence, *_RANGE)
    return np.asarray((np.log(clipped / (1 - clipped)) - lowest) / (highest - lowest))


def _scale(width_px: int, *, unseen: bool) -> Picture:
    """The colours from 0 to 1 with their numbers, as wide as the picture above it."""
    dots = max(1.0, width_px / 1024)  # larger letters below larger pictures
    with house_style():
        figure = new_figure(width_px / 150, 0.42 * dots)
        width_in, height_in = width_px / 150, 0.42 * dots
        left_in, bar_in = 0.9 * dots, min(3.2 * dots, width_in - 2.4 * dots)
        axes = axes_at(figure, left_in, 0.1 * dots, bar_in, 0.1 * dots)
        axes.imshow(np.linspace(0, 1, 256)[None], cmap=COLOUR_MAP, extent=(0, 1, 0, 1), aspect="auto")
        axes.set_yticks([])
        axes.set_xticks(on_scale(np.array(TICKS)), [f"{tick:g}" for tick in TICKS])
        axes.tick_params(labelsize=6.5 * dots, length=1.5 * dots, pad=1.5 * dots)
        for spine in axes.spines.values():
            spine.set_visible(False)
        middle = 1 - 0.15 * dots / height_in
        style: dict[str, Any] = {"va": "center", "color": SOFT_INK, "fontsize": 7.5 * dots}
        figure.text(0.1 * dots / width_in, middle, "confidence", **style)
        if unseen:
            right_in = left_in + bar_in + 0.25 * dots
            box = axes_at(figure, right_in, 0.06 * dots, 0.26 * dots, 0.18 * dots)
            box.imshow(
                np.where(hatching(np.zeros((16, 23), bool), 6.0), *_UNSEEN),
                cmap="gray",
                vmin=0,
                vmax=255,
                aspect="auto",
            )
            box.set_axis_off()
            figure.text((right_in + 0.34 * dots) / width_in, middle, "not seen", **style)
        figure.canvas.draw()
        pixels = np.asarray(figure.canvas.buffer_rgba())[..., :3]  # type: ignore[attr-defined]  # an Agg canvas
    return np.ascontiguousarray(pixels[:, :width_px])

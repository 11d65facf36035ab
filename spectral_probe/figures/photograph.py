"""A photograph developed for the screen: as it is where a camera has developed it already, else with its ball made grey."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from ..files.atomic import written_whole
from ..model import FloatArray, Outline, Photograph
from .display import KNEE, Picture, srgb_encoded, write_png

MIDDLE_GREY = 0.18
_BRIGHTEST = 8.0
"""Linear display value up to which the curve is tabulated; beyond it everything is white."""

_LOSSLESS_PX = 2_000_000
_JPEG_QUALITY = 92
_STEP_PX = 4


def developed(
    photograph: Photograph,
    outline: Outline | None = None,
    *,
    exposure_ev: float = 0.0,
    max_side_px: int = 4096,
) -> Picture:
    """A photograph as sRGB pixels.

    Parameters
    ----------
    photograph
        Linear camera RGB (H, W, 3). JPEG and other converted pictures keep their colours. Others are balanced so that the
        typical pixel of the ball, or of the whole picture where there is no outline, is a middle grey.
    outline
        Of the ball, in pixels of the photograph.
    exposure_ev
        Brighter (above 0) or darker by so many stops.
    max_side_px
        Larger photographs are made smaller by area averages.

    Returns
    -------
    ndarray
        (H', W', 3) uint8 sRGB.
    """
    height, width = photograph.pixels.shape[:2]
    scale = min(1.0, max_side_px / max(height, width))
    pixels = photograph.pixels
    if scale < 1.0:
        size = (max(1, round(width * scale)), max(1, round(height * scale)))
        pixels = np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA))
    gain = 2.0**exposure_ev * (np.ones(3) if photograph.display_referred else _balance(photograph, outline))
    table = _curve(soft=not photograph.display_referred)
    picture = np.empty(pixels.shape, np.uint8)
    steps = (len(table) - 1) / _BRIGHTEST
    for channel in range(3):
        scaled = np.nan_to_num(pixels[..., channel], nan=0.0, posinf=1e6) * np.float32(gain[channel] * steps)
        picture[..., channel] = table[np.clip(scaled + 0.5, 0, len(table) - 1).astype(np.int32)]
    return picture


def write_picture(path: Path, picture: Picture) -> Path:
    """Write a developed photograph, small ones without loss (PNG), large ones as JPEG; the path with its suffix.

    At PNG's speed a picture of ten megapixels would take seconds, and as much room in a .blend as all the rest of it.
    """
    if picture.shape[0] * picture.shape[1] <= _LOSSLESS_PX:
        write_png(path.with_suffix(".png"), picture, quick=True)
        return path.with_suffix(".png")
    from PIL import Image

    with written_whole(path.with_suffix(".jpg")) as temporary:
        Image.fromarray(np.ascontiguousarray(picture), "RGB").save(
            temporary, format="JPEG", quality=_JPEG_QUALITY, subsampling=0
        )
    return path.with_suffix(".jpg")


def _balance(photograph: Photograph, outline: Outline | None) -> FloatArray:
    """Gains (3,) that bring the typical pixel to a middle grey; one for all channels where they are Rec.709 already."""
    pixels = photograph.pixels[::_STEP_PX, ::_STEP_PX]
    if outline is not None:
        rows, columns = np.ogrid[: pixels.shape[0], : pixels.shape[1]]
        x, y = (
            (_STEP_PX * columns + 0.5) - outline.centre_px[0],
            (_STEP_PX * rows + 0.5) - outline.centre_px[1],
        )
        on_ball = np.hypot(x, y) < min(outline.semi_axes_px)
        pixels = pixels[on_ball] if on_ball.any() else pixels
    typical = np.nanmedian(pixels.reshape(-1, 3), axis=0)
    if photograph.scene_referred_float:
        typical = np.full(3, typical.mean())
    return np.asarray(MIDDLE_GREY / np.where(typical > 0.0, typical, 1.0))


def _curve(*, soft: bool) -> Picture:
    """Codes of linear values from 0 to `_BRIGHTEST`: sRGB, where `soft` with highlights rolled off above the knee."""
    linear = np.linspace(0.0, _BRIGHTEST, 1 << 17)
    if soft:
        rolled = 1.0 - (1.0 - KNEE) * np.exp((KNEE - np.maximum(linear, KNEE)) / (1.0 - KNEE))
        linear = np.where(linear > KNEE, rolled, linear)
    return np.asarray(np.rint(srgb_encoded(np.clip(linear, 0.0, 1.0)) * 255.0), np.uint8)

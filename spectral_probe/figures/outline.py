"""The ball's outline drawn over its photograph, to be checked by eye."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from ..model import FloatArray, Outline, Photograph
from ..spectra.colorimetry import rec709_to_xyz
from .display import Picture, tone_map

_LINE_RGB = (255, 64, 160)
_POINT_RGB = (64, 255, 255)
_SUBPIXEL_BITS = 4


def outline_picture(photograph: Photograph, outline: Outline, *, max_width_px: int = 1600) -> Picture:
    """A photograph with the outline (an ellipse and its centre) and the edge points it was fitted to.

    Parameters
    ----------
    photograph
        Linear camera RGB (H, W, 3). It is shown balanced so that the ball is grey on average.
    outline
        In pixels of the photograph.
    max_width_px
        Wider photographs are made smaller by area averages.

    Returns
    -------
    ndarray
        (H', W', 3) uint8 sRGB.
    """
    height, width = photograph.pixels.shape[:2]
    scale = min(1.0, max_width_px / width)
    size = (max(1, round(width * scale)), max(1, round(height * scale)))
    small = np.asarray(cv2.resize(photograph.pixels.astype(np.float32), size, interpolation=cv2.INTER_AREA))
    outline = replace(
        outline,
        centre_px=(outline.centre_px[0] * scale, outline.centre_px[1] * scale),
        semi_axes_px=(outline.semi_axes_px[0] * scale, outline.semi_axes_px[1] * scale),
        points_px=np.asarray(outline.points_px, float).reshape(-1, 2) * scale,
    )
    picture = _shown(small, outline)
    thickness = max(1, round(size[0] / 800))
    for x, y in outline.points_px:
        cv2.circle(picture, _fixed(x, y), 1 << _SUBPIXEL_BITS, _POINT_RGB, -1, cv2.LINE_AA, _SUBPIXEL_BITS)
    centre, axes = _fixed(*outline.centre_px), _fixed(*outline.semi_axes_px, offset=0.0)
    angle_deg = float(np.degrees(outline.angle_rad))
    cv2.ellipse(picture, centre, axes, angle_deg, 0, 360, _LINE_RGB, thickness, cv2.LINE_AA, _SUBPIXEL_BITS)
    x, y = (round(value - 0.5) for value in outline.centre_px)
    cv2.drawMarker(picture, (x, y), _LINE_RGB, cv2.MARKER_CROSS, 12 * thickness, thickness, cv2.LINE_AA)
    return picture


def _fixed(x: float, y: float, offset: float = 0.5) -> tuple[int, int]:
    """Fixed-point coordinates for OpenCV's drawing, whose pixel centres are at integers."""
    return round((x - offset) * (1 << _SUBPIXEL_BITS)), round((y - offset) * (1 << _SUBPIXEL_BITS))


def _shown(pixels: FloatArray, outline: Outline) -> Picture:
    """The photograph with its ball at a middle grey."""
    height, width = pixels.shape[:2]
    rows, columns = np.mgrid[:height, :width] + 0.5
    on_ball = np.hypot(columns - outline.centre_px[0], rows - outline.centre_px[1]) < min(
        outline.semi_axes_px
    )
    typical = np.median(pixels[on_ball], axis=0) if on_ball.any() else np.ones(3)
    balanced = pixels / np.where(typical > 0, typical, 1.0)
    # Balanced camera RGB is taken as linear Rec.709: only a person looks at it.
    return np.ascontiguousarray(tone_map(rec709_to_xyz(balanced), 0.18))

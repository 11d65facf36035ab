"""Edges of log radiance, which do not depend on the exposure."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..model import FloatArray, Photograph


@dataclass(frozen=True)
class Gradients:
    """Gradient of log radiance (H, W) by components, of whichever colour channel has the strongest."""

    x: FloatArray
    y: FloatArray
    magnitude: FloatArray


def shrunk(pixels: FloatArray, scale: float) -> FloatArray:
    """A picture (H, W, 3) reduced by averaging; scale 1 leaves it alone."""
    import cv2

    if scale >= 1.0:
        return pixels
    height, width = pixels.shape[:2]
    size = (max(4, round(width * scale)), max(4, round(height * scale)))
    return np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA))


def log_gradients(pixels: FloatArray, photograph: Photograph) -> tuple[FloatArray, FloatArray]:
    """Gradient (x, y), each (H, W, 3), of the logarithm of a picture that was cut from `photograph`."""
    import cv2

    if photograph.scene_referred_float:
        floor, top = 0.01 * max(float(np.median(pixels)), 1e-6), np.inf
    else:
        floor, top = (0.01 if photograph.display_referred else 0.002), 1.0
    logarithm = np.log(np.clip(pixels, 0.0, top) + floor).astype(np.float32)
    logarithm = cv2.GaussianBlur(logarithm, (0, 0), 1.0)
    along_x = cv2.Scharr(logarithm, cv2.CV_32F, 1, 0) / 32.0
    along_y = cv2.Scharr(logarithm, cv2.CV_32F, 0, 1) / 32.0
    return np.asarray(along_x), np.asarray(along_y)


def strongest_channel(along_x: FloatArray, along_y: FloatArray) -> Gradients:
    """Of gradients by channel (..., 3), that of the channel where it is the strongest."""
    magnitude = np.hypot(along_x, along_y)
    channel = magnitude.argmax(axis=-1)[..., None]
    x, y, m = (np.take_along_axis(a, channel, axis=-1)[..., 0] for a in (along_x, along_y, magnitude))
    return Gradients(x, y, m)

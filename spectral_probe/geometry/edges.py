"""Edges in a bracket: the gradient of log radiance, which does not depend on the exposure, of all photographs together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from ..model import BoolArray, FloatArray, Photograph

DARK, CLIPPING, FADE = 0.05, 0.97, 0.2
"""Levels up to which a photograph's gradients count less, at which they count nothing, and the width of that slope."""


@dataclass(frozen=True)
class EdgeField:
    """Gradients of log radiance in a part of the frame, of whichever colour channel has the strongest.

    `x`, `y` (H, W) and `magnitude` per pixel of the field; `inside` (H, W) is False outside every photograph's frame.
    A point p of the frame of the first photograph lies at (p - corner_px) * scale in the field (pixel centres at
    integer + 0.5).
    """

    x: FloatArray
    y: FloatArray
    magnitude: FloatArray
    inside: BoolArray
    corner_px: FloatArray
    scale: FloatArray


def brightest(pixels: FloatArray) -> FloatArray:
    """The largest of the channels (..., 3)."""
    return np.maximum(np.maximum(pixels[..., 0], pixels[..., 1]), pixels[..., 2])


def shrunk(pixels: FloatArray, scale: float) -> FloatArray:
    """A picture (H, W) or (H, W, 3) reduced by averaging; scale 1 leaves it alone."""
    if scale >= 1.0:
        return pixels
    height, width = pixels.shape[:2]
    size = (max(4, round(width * scale)), max(4, round(height * scale)))
    return np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA))


def edge_field(
    photographs: Sequence[Photograph],
    shifts_px: Sequence[FloatArray],
    box_px: tuple[float, float, float, float],
    scale: float,
) -> EdgeField:
    """The edges of a bracket in a box of its first frame.

    Parameters
    ----------
    photographs
        The bracket.
    shifts_px
        Where what the first photograph shows lies in each, from where it is in the first (x, y).
    box_px
        Left, top, right and bottom in the first's frame; it may reach beyond it.
    scale
        Size of the field over the photographs', at most 1.
    """
    left, top = (int(np.floor(value)) for value in box_px[:2])
    width, height = (max(8, int(np.ceil(b)) - a) for a, b in zip((left, top), box_px[2:], strict=True))
    scale = min(1.0, scale)
    size = (max(4, round(width * scale)), max(4, round(height * scale)))
    scales = np.array([size[0] / width, size[1] / height])
    sums = np.zeros((2, size[1], size[0], 3), np.float32)
    total = np.zeros((size[1], size[0], 3), np.float32)
    for photograph, shift in zip(photographs, shifts_px, strict=True):
        whole = np.round(shift).astype(int)
        picture, inside = _cut(photograph, left + whole[0], top + whole[1], width, height)
        if size != (width, height):
            picture = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
            inside = cv2.resize(inside, size, interpolation=cv2.INTER_AREA)
        inside = (inside > 0.999).astype(np.float32)[..., None]
        weight = _weight(picture, photograph) * inside
        along = _log_gradients(picture, photograph)
        part = (shift - whole) * scales
        if np.abs(part).max() > 0.02:
            matrix = np.array([[1.0, 0.0, part[0]], [0.0, 1.0, part[1]]])
            flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
            along = [cv2.warpAffine(one, matrix, size, flags=flags) for one in along]
            weight = cv2.warpAffine(weight, matrix, size, flags=flags)
        weight = weight + np.float32(1e-3) * inside
        total += weight
        for axis in (0, 1):
            sums[axis] += along[axis] * weight
    sums /= np.maximum(total, 1e-6)
    x, y, magnitude = _strongest_channel(sums[0], sums[1])
    return EdgeField(x, y, magnitude, total[..., 0] > 0.0, np.array([left, top], float), scales)


def _cut(
    photograph: Photograph, left: int, top: int, width: int, height: int
) -> tuple[FloatArray, FloatArray]:
    """A box of a photograph, continued at its borders, and where (H, W) it is inside the frame (1.0)."""
    rows, columns = photograph.clipped.shape
    y0, y1 = (int(np.clip(value, 0, rows)) for value in (top, top + height))
    x0, x1 = (int(np.clip(value, 0, columns)) for value in (left, left + width))
    if y1 - y0 < 1 or x1 - x0 < 1:
        return np.zeros((height, width, 3), np.float32), np.zeros((height, width), np.float32)
    picture = photograph.pixels[y0:y1, x0:x1]
    inside = np.ones(picture.shape[:2], np.float32)
    border = (y0 - top, top + height - y1, x0 - left, left + width - x1)
    if any(border):
        picture = cv2.copyMakeBorder(picture, *border, cv2.BORDER_REPLICATE)
        inside = cv2.copyMakeBorder(inside, *border, cv2.BORDER_CONSTANT, value=0.0)
    return np.asarray(picture), np.asarray(inside)


def _weight(picture: FloatArray, photograph: Photograph) -> FloatArray:
    """How well each channel (H, W, 3) of a place is exposed, 0 to 1."""
    level = brightest(picture)[..., None]
    if photograph.scene_referred_float:
        weight = np.minimum(picture / max(float(np.median(level)), 1e-6), 1.0)
    else:
        weight = np.minimum(level / DARK, 1.0) * np.clip((CLIPPING - picture) / FADE, 0.0, 1.0)
    return np.asarray(cv2.erode(weight.astype(np.float32), np.ones((3, 3), np.uint8)))


def _log_gradients(picture: FloatArray, photograph: Photograph) -> list[FloatArray]:
    """Gradient along x and y, each (H, W, 3), of the logarithm of a picture that was cut from `photograph`."""
    if photograph.scene_referred_float:
        floor, top = 0.01 * max(float(np.median(picture)), 1e-6), np.inf
    else:
        floor, top = (0.01 if photograph.display_referred else 0.002), 1.0
    logarithm = cv2.log((np.clip(picture, 0.0, top) + floor).astype(np.float32))
    logarithm = cv2.GaussianBlur(logarithm, (0, 0), 1.0)
    return [cv2.Scharr(logarithm, cv2.CV_32F, *axis) / np.float32(32.0) for axis in ((1, 0), (0, 1))]


def _strongest_channel(along_x: FloatArray, along_y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Of gradients by channel (..., 3), x, y and magnitude of the channel where it is the strongest."""
    x, y = along_x[..., 0], along_y[..., 0]
    square = x * x + y * y
    for channel in (1, 2):
        other_x, other_y = along_x[..., channel], along_y[..., channel]
        other = other_x * other_x + other_y * other_y
        more = other > square
        x, y = np.where(more, other_x, x), np.where(more, other_y, y)
        square = np.where(more, other, square)
    return x, y, np.sqrt(square)

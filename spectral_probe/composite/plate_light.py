"""The plate's pixels as light: the camera's response undone, reduced in size in linear values, divided by the exposure."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
import numpy.typing as npt

from ..composite_model import Backplate
from ..model import BoolArray, FloatArray, Photograph
from ..photo.noise import code_index, code_table, display_light
from ..photo.response import ResponseCurve

_ROWS_AT_ONCE = 256


def response_curve(log_gain: FloatArray | None) -> ResponseCurve | None:
    """The response that `Backplate.response_log_gain` stands for; None for sRGB's own curve."""
    return None if log_gain is None else ResponseCurve(np.asarray(log_gain), (0.0, 0.0, 0.0), ())


def linear_pixels(
    photograph: Photograph, response: ResponseCurve | None, size_px: tuple[int, int]
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """A photograph's linear camera RGB (H, W, 3) at a size (width, height), and how much of each pixel (H, W) is clipped.

    Converted pictures are brought to light by the response (sRGB's curve without one) before they are reduced.
    """
    height, width = photograph.clipped.shape
    clipped = photograph.clipped.astype(np.float32)
    pixels = np.asarray(photograph.pixels, np.float32)
    if photograph.display_referred and response is not None:
        table = code_table(display_light(response))
        light = np.empty_like(pixels)
        for start in range(0, height, _ROWS_AT_ONCE):
            rows = slice(start, min(start + _ROWS_AT_ONCE, height))
            cv2.LUT(code_index(pixels[rows], np.empty_like(pixels[rows])), table, dst=light[rows])
        pixels = light
    if size_px == (width, height):
        return pixels, clipped
    reduced = [cv2.resize(plane, size_px, interpolation=cv2.INTER_AREA) for plane in (pixels, clipped)]
    return np.asarray(reduced[0], np.float32), np.asarray(reduced[1], np.float32)


def plate_radiance(photograph: Photograph, backplate: Backplate) -> tuple[FloatArray, BoolArray]:
    """What the plate shows as the probe's camera sees light (H, W, 3), and where it is not clipped (H, W).

    In the probe's unit: the responses of `camera_model` to its spectra, per unit of relative exposure.
    """
    response = response_curve(backplate.response_log_gain)
    pixels, clipped = linear_pixels(photograph, response, backplate.camera.size_px)
    scale = np.asarray(backplate.exposure * backplate.gain, np.float32)
    return pixels / scale, clipped < 0.5


def brightness_ratio(
    pictures: Sequence[tuple[FloatArray, FloatArray]],
    exposures: tuple[float, float],
    shift_px: FloatArray,
    ball_px: tuple[float, float, float],
) -> tuple[FloatArray, FloatArray] | None:
    """How much brighter the second of two small pictures is than the first, apart from exposure, and its standard error.

    Parameters
    ----------
    pictures
        Linear pixels (h, w, 3) and clipped share (h, w) of each.
    exposures
        Relative exposures of both.
    shift_px
        (2,) where a point of the first lies in the second, from itself.
    ball_px
        Ball in the first: what lies within 2.5 radii is left out, the ball and most of what it casts.

    Returns
    -------
    tuple of ndarray, or None
        (3,) ratio and its standard error (3,); None where fewer than fifty places can be compared.
    """
    (first, hidden), (second, lost) = pictures
    height, width = hidden.shape
    matrix = np.array([[1.0, 0.0, shift_px[0]], [0.0, 1.0, shift_px[1]]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    second = np.asarray(cv2.warpAffine(np.asarray(second, np.float32), matrix, (width, height), flags=flags))
    lost = cv2.warpAffine(np.asarray(lost, np.float32), matrix, (width, height), flags=flags, borderValue=1.0)
    rows, columns = np.mgrid[:height, :width] + 0.5
    away = np.hypot(columns - ball_px[0], rows - ball_px[1]) > 2.5 * ball_px[2]
    kept = away & (hidden < 0.01) & (np.asarray(lost) < 0.01)
    kept &= (np.minimum(first.min(-1), second.min(-1)) > _DARK) & _flat(first) & _flat(second)
    if np.count_nonzero(kept) < _LEAST_PLACES:
        return None
    logs = np.log(second[kept] / first[kept]) - np.log(exposures[1] / exposures[0])
    middle = np.median(logs, axis=0)
    spread = 1.4826 * np.median(np.abs(logs - middle), axis=0)
    return np.exp(middle), spread / np.sqrt(np.count_nonzero(kept) / _DEPENDENT)


_LEAST_PLACES = 50
_DEPENDENT = 25.0
"""Places that count as one: neighbours show the same surface under the same light."""

_DARK = 0.01
_FLAT = 0.15
"""Relative difference to the surroundings up to which a place bears a misalignment of a pixel."""


def _flat(picture: FloatArray) -> BoolArray:
    level = np.asarray(picture, np.float32).mean(-1)
    highest, lowest = cv2.dilate(level, np.ones((3, 3))), cv2.erode(level, np.ones((3, 3)))
    return np.asarray(highest - lowest < _FLAT * np.maximum(highest, 1e-9))

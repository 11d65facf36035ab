"""Filters on panoramas that know the sphere: they go round in longitude, over the poles, and keep their angular size.

A panorama's rows are circles of latitude that shrink towards the poles, so a filter of one angular width spans ever more
columns there, and what lies above the top row is the top row again, half way round.
"""

from __future__ import annotations

import cv2
import numpy as np

from ..large import strips
from ..model import BoolArray, FloatArray

_FILL_WIDTH = 512
"""Width of the panorama on which unseen directions are filled in, in pixels."""


def padded(values: FloatArray, rows: int, columns: int) -> FloatArray:
    """A panorama (H, W) or (H, W, C) continued over its edges: round in longitude, and over the poles.

    Examples
    --------
    >>> padded(np.array([[1.0, 2.0, 3.0, 4.0], [5.0, 6.0, 7.0, 8.0]]), 1, 1)[0].tolist()  # beyond the pole: half way round
    [2.0, 3.0, 4.0, 1.0, 2.0, 3.0]
    """
    over = np.roll(values, values.shape[1] // 2, axis=1)
    tall = np.concatenate([over[:rows][::-1], values, over[len(values) - rows :][::-1]], axis=0)
    return np.pad(tall, ((0, 0), (columns, columns), *((0, 0),) * (values.ndim - 2)), mode="wrap")


def blurred(values: FloatArray, sigma_rad: float) -> FloatArray:
    """Gaussian blur of one angular width everywhere on the sphere.

    Rows are blurred in the frequency domain, where each has its own width in columns; columns then by a common kernel that
    goes over the poles.

    Parameters
    ----------
    values
        (H, W) or (H, W, C).
    sigma_rad
        Standard deviation in radians.

    Returns
    -------
    ndarray
        float32 of the same shape.
    """
    height, width = values.shape[:2]
    latitude = (0.5 - (np.arange(height) + 0.5) / height) * np.pi
    spread = sigma_rad / np.cos(latitude)  # in longitude
    frequency = np.arange(width // 2 + 1)
    gain = np.exp(-0.5 * (spread[:, None] * frequency) ** 2).astype(np.float32)
    gain = gain.reshape(*gain.shape, *(1,) * (values.ndim - 2))
    along = np.fft.irfft(np.fft.rfft(np.asarray(values, np.float32), axis=1) * gain, n=width, axis=1)
    sigma_rows = sigma_rad * height / np.pi
    margin = min(int(np.ceil(4 * sigma_rows)), height)
    tall = padded(np.asarray(along, np.float32), margin, 0)
    kernel = (1, 2 * margin + 1)  # (columns, rows)
    done = cv2.GaussianBlur(tall, kernel, sigmaX=1e-3, sigmaY=max(sigma_rows, 1e-3))
    return np.asarray(done[margin : margin + height].reshape(values.shape))


def blurred_where(values: FloatArray, weight: FloatArray, sigma_rad: float) -> FloatArray:
    """Blur of the values that have weight: the weighted mean of each direction's surroundings; 0 far from any weight.

    Examples
    --------
    >>> values, weight = np.full((8, 16), 3.0), np.zeros((8, 16))
    >>> weight[2:6] = 1
    >>> bool(np.allclose(blurred_where(values, weight, 0.3)[2:6], 3.0, atol=1e-4))
    True
    """
    shape = (*weight.shape, *(1,) * (values.ndim - 2))
    share = blurred(weight, sigma_rad).reshape(shape)
    total = blurred(np.asarray(values, np.float32) * np.asarray(weight, np.float32).reshape(shape), sigma_rad)
    return np.asarray(total / np.maximum(share, 1e-4), np.float32)


def resized(values: FloatArray, width: int, rows: slice | None = None) -> FloatArray:
    """A panorama (H, W) or (H, W, C <= 4) at another width: area averages down, bilinear and round the edges up.

    Some rows of it, where they are given: made by themselves where it becomes larger.
    """
    height, old = values.shape[:2]
    size = (width, max(width * height // old, 1))
    wanted = slice(0, size[1]) if rows is None else rows
    if width <= old:
        return np.asarray(cv2.resize(values, size, interpolation=cv2.INTER_AREA))[wanted]
    lines, columns = np.arange(wanted.start, wanted.stop) + 0.5, np.arange(width) + 0.5
    at_x = (columns * (old / width) - 0.5 + 1).astype(
        np.float32
    )  # the padding's one column before, one row above
    at_y = (lines * (height / size[1]) - 0.5 + 1).astype(np.float32)
    around = padded(np.asarray(values, np.float32), 1, 1)
    map_x, map_y = (
        np.broadcast_to(at_x, (len(at_y), width)),
        np.broadcast_to(at_y[:, None], (len(at_y), width)),
    )
    return np.asarray(
        cv2.remap(around, np.ascontiguousarray(map_x), np.ascontiguousarray(map_y), cv2.INTER_LINEAR)
    )


def fill_unknown(values: FloatArray, known: BoolArray, *, in_place: bool = False) -> FloatArray:
    """Values of directions nobody saw, from their surroundings: pull-push over halved resolutions, round the sphere.

    Parameters
    ----------
    values
        (H, W, K).
    known
        (H, W) where `values` are to be kept.
    in_place
        Fill `values` themselves, which are float32.

    Returns
    -------
    ndarray
        (H, W, K) float32; the known ones unchanged. All zero where nothing is known.
    """
    values = np.asarray(values, np.float32)
    if known.all() or not known.any():
        return values if known.any() else np.zeros_like(values)
    latitude = (0.5 - (np.arange(len(known)) + 0.5) / len(known)) * np.pi
    area = np.cos(latitude)[:, None].astype(np.float32)  # rows near a pole hold little of the sphere
    area = np.ascontiguousarray(np.broadcast_to(area, known.shape))
    coarse = min(known.shape[1], _FILL_WIDTH)  # what is made up is smooth: a small panorama holds it
    weight = known * area
    weighted = np.dstack(
        [resized(np.ascontiguousarray(channel) * weight, coarse) for channel in np.moveaxis(values, -1, 0)]
    )
    filled = _pull_push(weighted, resized(weight, coarse), resized(area, coarse))
    del weight, area
    result = values if in_place else values.copy()
    for channel, fill in zip(np.moveaxis(result, -1, 0), np.moveaxis(filled, -1, 0), strict=True):
        small = np.ascontiguousarray(fill)
        for rows in strips(*known.shape):
            unseen = ~known[rows]
            channel[rows][unseen] = resized(small, known.shape[1], rows)[unseen]
    return result


def _pull_push(weighted: FloatArray, weight: FloatArray, area: FloatArray) -> FloatArray:
    """Means where there is weight, and means of ever wider surroundings where there is little of it."""
    height, width = weight.shape
    mean = weighted / np.maximum(weight, 1e-9)[..., None]
    share = np.clip(weight / area, 0.0, 1.0)
    if min(height, width) <= 1 or share.min() > 0.5:
        return mean
    half = (max(width // 2, 1), max(height // 2, 1))
    smaller = np.dstack(
        [cv2.resize(channel, half, interpolation=cv2.INTER_AREA) for channel in np.moveaxis(weighted, -1, 0)]
    )
    below = _pull_push(
        smaller,
        cv2.resize(weight, half, interpolation=cv2.INTER_AREA),
        np.asarray(cv2.resize(area, half, interpolation=cv2.INTER_AREA)),
    )
    filled = np.dstack([resized(channel, width) for channel in np.moveaxis(below, -1, 0)])
    if filled.shape[:2] != (height, width):  # odd heights
        filled = cv2.resize(filled, (width, height), interpolation=cv2.INTER_LINEAR).reshape(
            height, width, -1
        )
    return np.asarray(share[..., None] * mean + (1 - share[..., None]) * filled)

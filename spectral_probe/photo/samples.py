"""Small flat areas of an aligned bracket, from which exposures and the camera's response are measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..model import BoolArray, FloatArray, Photograph

CELLS_ACROSS = 150
"""Cells along the ball's diameter: wide enough to bear a misalignment of a pixel, small enough to tell a lamp from
its surroundings."""

DARKEST_CODE = 6.0 / 255.0
"""Codes below this are mostly black clipping and noise: their mean no longer follows the light."""

DARKEST_LEVEL = 1e-3
"""The same for linear pictures, as a share of saturation: five times a typical read noise, before the average of a cell."""

FLAT_CODE = 0.02
"""Standard deviation of codes (0..1) among a cell and its neighbours up to which an area counts as flat."""

STRATA = 64
"""Steps of brightness from which equally many samples are taken, so that all codes of the response are met."""

PER_STRATUM = 10


@dataclass(frozen=True)
class Cells:
    """Means of small square areas in every photograph of a bracket.

    `values` (E, N, 3): sRGB codes in 0..1 of display-referred photographs, else linear values; `usable` (E, N, 3) neither
    clipped nor lost in the dark; `roughness` (N,) the largest standard deviation around a cell, in codes; `encoded` tells
    that the values are codes.
    """

    values: FloatArray
    usable: BoolArray
    roughness: FloatArray
    encoded: bool


def linear_to_srgb(linear: FloatArray) -> FloatArray:
    """The sRGB curve (IEC 61966-2-1) of linear values from 0 on, any shape; negative ones (ringing) give 0.

    Examples
    --------
    >>> [round(float(value), 4) for value in linear_to_srgb(np.array([0.0, 0.214, 1.0]))]
    [0.0, 0.5, 1.0]
    """
    positive = np.maximum(linear, 0.0)
    return np.where(positive <= 0.0031308, 12.92 * positive, 1.055 * np.power(positive, 1.0 / 2.4) - 0.055)


def cells_of(photographs: Sequence[Photograph], on_ball: BoolArray) -> Cells:
    """Average an aligned bracket over the cells that lie wholly on the ball.

    Parameters
    ----------
    photographs
        Aligned, of one size (H, W).
    on_ball
        (H, W) where the picture of the ball lies.
    """
    import cv2

    encoded = photographs[0].display_referred
    rows, columns = np.flatnonzero(on_ball.any(1)), np.flatnonzero(on_ball.any(0))
    if not len(rows):
        empty = np.zeros((len(photographs), 0, 3))
        return Cells(empty, empty > 0, np.zeros(0), encoded)
    box = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    side = max(1, round(2.0 * float(np.sqrt(np.count_nonzero(on_ball) / np.pi)) / CELLS_ACROSS))
    inside = _cell_means(on_ball[box].astype(np.float32), side) > 0.999
    values, usable = [], []
    roughness = np.zeros(int(inside.sum()))
    for photograph in photographs:
        pixels, clipped = photograph.pixels[box], photograph.clipped[box]
        codes = linear_to_srgb(_cell_means(pixels, side))
        mean = (
            _cell_means(linear_to_srgb(pixels).astype(np.float32), side)
            if encoded
            else _cell_means(pixels, side)
        )
        spread = np.maximum(cv2.blur(codes**2, (3, 3)) - cv2.blur(codes, (3, 3)) ** 2, 0.0).max(-1)
        free = _cell_means(clipped.astype(np.float32), side) == 0.0
        floor = DARKEST_CODE if encoded else 0.0 if photograph.scene_referred_float else DARKEST_LEVEL
        good = free[..., None] & (mean > floor)
        values.append(mean[inside])
        usable.append(good[inside])
        roughness = np.maximum(roughness, np.where(good.all(-1), np.sqrt(spread), 0.0)[inside])
    return Cells(np.stack(values).astype(float), np.stack(usable), roughness, encoded)


def chosen(cells: Cells) -> Cells:
    """The flattest cells of every brightness, usable in two photographs at least."""
    pairs = cells.usable.all(-1).sum(0) >= 2
    brightness = np.where(pairs, cells.values.mean(axis=(0, 2)), np.nan)
    flat = pairs & (cells.roughness <= max(FLAT_CODE, _quantile(cells.roughness[pairs], 0.2)))
    if not flat.any():
        flat = pairs
    if not flat.any():
        return _part(cells, np.zeros(0, int))
    scale = np.log(brightness[flat]) if not cells.encoded else brightness[flat]
    candidates = np.flatnonzero(flat)
    low, high = float(scale.min()), float(scale.max())
    stratum = np.minimum((scale - low) / max(high - low, 1e-9) * STRATA, STRATA - 1).astype(int)
    picked = []
    for number in range(STRATA):
        members = candidates[stratum == number]
        picked.append(members[np.argsort(cells.roughness[members], kind="stable")[:PER_STRATUM]])
    return _part(cells, np.concatenate(picked))


def _part(cells: Cells, index: FloatArray) -> Cells:
    return Cells(cells.values[:, index], cells.usable[:, index], cells.roughness[index], cells.encoded)


def _quantile(values: FloatArray, share: float) -> float:
    return float(np.quantile(values, share)) if len(values) else 0.0


def _cell_means(image: FloatArray, side: int) -> FloatArray:
    """Means over side x side pixels, (H, W, ...) to (H // side, W // side, ...); an incomplete last cell is left out."""
    import cv2

    height, width = (size // side for size in image.shape[:2])
    if side == 1:
        return image
    cut = np.ascontiguousarray(image[: height * side, : width * side])
    return np.asarray(cv2.resize(cut, (width, height), interpolation=cv2.INTER_AREA))

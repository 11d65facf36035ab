"""A sensor's noise constants from a bracket itself: how much pairs of photographs differ where they show the same."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ..model import BoolArray, Exposure, FloatArray, Photograph
from .noise import FULL_WELL_ELECTRONS, READ_NOISE, SensorNoise

CELL_PX = 8
"""Side of the cells whose variances are compared."""

LEAST_READ_NOISE = 5e-5
"""The steps of 12 to 14 bits alone make 2e-5 to 7e-5; a bracket of bright pixels may tell nothing of it, and would give 0."""

LEAST_CELLS = 100
BINS = 12

BELIEVABLE = 10.0
"""Estimates further than this factor from a typical sensor's come from something else (alignment, a converter's noise
reduction): typical constants are then safer."""


def sensor_noise(
    photographs: Sequence[Photograph], exposures: Sequence[Exposure], on_ball: BoolArray
) -> SensorNoise:
    """Full well and read noise of a linear bracket's pixels, as they are after demosaicing and alignment.

    Photographs next to each other in exposure, scaled to one, differ by their noise only. Its variance in a cell is linear in
    the two constants, shot noise over the level and read noise; the smoother half of the cells is used, binned by level, and of
    each bin the median, so that what moved or lies at an edge does not count.

    Parameters
    ----------
    photographs, exposures
        An aligned bracket.
    on_ball
        (H, W) where it is aligned.

    Returns
    -------
    SensorNoise
        Typical constants where the bracket cannot tell: display-referred or radiance pictures, fewer than two photographs, too
        few smooth areas, or an answer that no sensor gives.
    """
    typical = SensorNoise()
    linear = [not (one.display_referred or one.scene_referred_float) for one in photographs]
    if len(photographs) < 2 or not all(linear):
        return typical
    order = sorted(range(len(photographs)), key=lambda index: exposures[index].relative)
    rows = [
        _pair(photographs[dark], photographs[bright], exposures[dark], exposures[bright], on_ball)
        for dark, bright in pairwise(order)
    ]
    design = np.concatenate([row[0] for row in rows])
    variance = np.concatenate([row[1] for row in rows])
    if len(variance) < 2:
        return typical
    shot, read = _non_negative(design / variance[:, None])
    if shot <= 0.0:
        return typical
    full_well = 1.0 / shot
    read_noise = float(np.sqrt(max(read, LEAST_READ_NOISE**2)))
    believable = (
        1.0 / BELIEVABLE < full_well / FULL_WELL_ELECTRONS < BELIEVABLE
        and read_noise < READ_NOISE * BELIEVABLE**1.5
    )
    return SensorNoise(full_well, read_noise) if believable else typical


def _non_negative(design: FloatArray) -> tuple[float, float]:
    """Two factors, at least 0, with which the rows add up to 1 by least squares."""
    both = np.linalg.lstsq(design, np.ones(len(design)), rcond=None)[0]
    if both[1] < 0.0:
        return float(design[:, 0].sum() / (design[:, 0] ** 2).sum()), 0.0
    return float(both[0]), float(both[1])


def _pair(
    dark: Photograph,
    bright: Photograph,
    dark_exposure: Exposure,
    bright_exposure: Exposure,
    on_ball: BoolArray,
) -> tuple[FloatArray, FloatArray]:
    """Bins of smooth cells: what shot and read noise of unit size give (N, 2), and the variance seen (N,)."""
    import cv2

    step = dark_exposure.relative / bright_exposure.relative
    rows, columns = np.flatnonzero(on_ball.any(1)), np.flatnonzero(on_ball.any(0))
    nothing = np.zeros((0, 2)), np.zeros(0)
    if not len(rows):
        return nothing
    box = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    height, width = (size // CELL_PX for size in on_ball[box].shape)

    def means(image: FloatArray) -> FloatArray:
        cut = np.ascontiguousarray(image[: height * CELL_PX, : width * CELL_PX], np.float32)
        return np.asarray(cv2.resize(cut, (width, height), interpolation=cv2.INTER_AREA), float)

    if height < 1 or width < 1:
        return nothing
    unusable = dark.clipped[box] | bright.clipped[box] | ~on_ball[box]
    free = means(unusable.astype(np.float32)) == 0.0
    green = bright.pixels[box][..., 1] * np.float32(step)
    difference = dark.pixels[box][..., 1] - green
    level = means(green)
    spread = means(difference**2) - means(difference) ** 2
    texture = (means(green**2) - level**2) / np.maximum(level, 1e-9) ** 2
    usable = free & (level > 0.0)
    if np.count_nonzero(usable) < LEAST_CELLS:
        return nothing
    usable &= texture <= np.median(texture[usable])
    spread, level = spread[usable] * CELL_PX**2 / (CELL_PX**2 - 1.0), level[usable]
    shot = level * (dark_exposure.iso + step * bright_exposure.iso) / 100.0
    bins = np.array_split(np.argsort(level), BINS)
    design = np.array([[float(np.median(shot[one])), 1.0 + step**2] for one in bins])
    return design, np.array([float(np.median(spread[one])) for one in bins])

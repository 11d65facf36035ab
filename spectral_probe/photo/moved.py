"""What moved while a bracket was taken: areas where a photograph disagrees with the others far beyond its noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..model import BoolArray, Exposure, FloatArray, Photograph
from .noise import SensorNoise, display_variance, noise_polynomial, table_values
from .response import ResponseCurve
from .samples import DARKEST_CODE, linear_to_srgb

CELLS_ACROSS = 240
"""Cells along the ball's diameter: what moves in a smaller area is left to the weights."""

BEYOND = 4.0
"""Disagreements count beyond this many standard deviations of the noise."""

LEAST_DISAGREEMENT = 0.25
"""And beyond this natural logarithm of the radiance: flicker, vignetting and tone curves explain less."""

LEAST_CELLS = 12
"""Smaller areas are left alone: lamps' edges and sparkles."""

REACH_CELLS = 2
"""A moved area is taken this much wider: its soft edge moved too."""


@dataclass(frozen=True)
class _CellLight:
    """Logarithm of the radiance in cells (h, w), its variance, and whether it can be compared."""

    log: FloatArray
    variance: FloatArray
    usable: BoolArray


def moved_areas(
    photographs: Sequence[Photograph],
    exposures: Sequence[Exposure],
    on_ball: BoolArray,
    response: ResponseCurve | None = None,
    sensor: SensorNoise | None = None,
) -> list[BoolArray | None]:
    """Where each aligned photograph shows something else than the majority of the others.

    Cells of several pixels are compared with the weighted median of all photographs, whose votes are their precisions; of
    two, the better exposed one is believed. A cell disagrees when it lies outside of the range that the median takes in
    the cells around it (so edges may lie a pixel off) by more than the noise explains. Cells near clipped or dark pixels are not
    compared.

    Parameters
    ----------
    photographs, exposures
        The bracket, of one size (H, W).
    on_ball
        (H, W) where they are compared.
    response, sensor
        As in `merge.merge`.

    Returns
    -------
    list
        For each photograph (H, W) True where it is not to be used, or None where nothing moved.
    """
    nothing: list[BoolArray | None] = [None] * len(photographs)
    rows, columns = np.flatnonzero(on_ball.any(1)), np.flatnonzero(on_ball.any(0))
    if len(photographs) < 2 or not len(rows):
        return nothing
    box = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    side = max(1, round(2.0 * float(np.sqrt(np.count_nonzero(on_ball) / np.pi)) / CELLS_ACROSS))
    inside = _means(on_ball[box].astype(np.float32), side) > 0.999
    lights = [
        _light(photograph, exposure, box, side, response, sensor or SensorNoise())
        for photograph, exposure in zip(photographs, exposures, strict=True)
    ]
    wrong = _disagreeing(lights, inside)
    return [_as_pixels(cells, side, box, on_ball.shape) if cells.any() else None for cells in wrong]


def _light(
    photograph: Photograph,
    exposure: Exposure,
    box: tuple[slice, slice],
    side: int,
    response: ResponseCurve | None,
    sensor: SensorNoise,
) -> _CellLight:
    import cv2

    level = _means(photograph.pixels[box], side).astype(float)
    near_clipped = cv2.dilate(
        (_means(photograph.clipped[box].astype(np.float32), side) > 0).astype(np.uint8), _square(1)
    )
    if photograph.display_referred:
        dark = linear_to_srgb(level).mean(-1) < 2.0 * DARKEST_CODE
        entries = table_values()
        light = response.linear(level) if response else level
        steps = (
            response.linear(np.repeat(entries[:, None], 3, axis=1))
            if response
            else np.repeat(entries[:, None], 3, 1)
        )
        table = display_variance(response, steps, exposure, sensor)
        variance = np.stack([np.interp(level[..., c], entries, table[:, c]) for c in range(3)], axis=-1)
        level, variance = light, variance.mean(-1)  # a tone curve's error is shared by all pixels of a cell
    else:
        constant, linear, square = noise_polynomial(photograph, exposure, sensor)
        mean = np.maximum(level.mean(-1), 0.0)
        variance = (constant + linear * mean) / (3.0 * side**2) + square * mean**2
        dark = mean < 10.0 * np.sqrt(variance)
    mean = np.maximum(level.mean(-1), 1e-9)
    usable = (near_clipped == 0) & ~dark
    return _CellLight(np.log(mean / exposure.relative), variance / mean**2, usable)


def _disagreeing(lights: Sequence[_CellLight], inside: BoolArray) -> list[BoolArray]:
    """For each photograph the cells (h, w) that are not to be used."""
    import cv2

    logs = np.stack([light.log for light in lights])
    usable = np.stack([light.usable & inside for light in lights])
    votes = np.where(usable, 1.0 / (np.stack([light.variance for light in lights]) + 0.1**2), 0.0)
    middle, known = _weighted_median(logs, votes)
    lowest = cv2.erode(np.where(known, middle, np.inf), _square(1))
    highest = cv2.dilate(np.where(known, middle, -np.inf), _square(1))
    wrong = []
    for light, seen in zip(lights, usable, strict=True):
        limit = np.maximum(LEAST_DISAGREEMENT, BEYOND * np.sqrt(light.variance))
        off = seen & ((light.log > highest + limit) | (light.log < lowest - limit))
        wrong.append(_areas(off))
    # Where all that see a cell were called wrong, nobody can say; they are all believed.
    heard = np.any([seen & ~off for seen, off in zip(usable, wrong, strict=True)], axis=0)
    return [off & heard for off in wrong]


def _weighted_median(values: FloatArray, weights: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Weighted median over the first axis, and where any weight is."""
    order = np.argsort(np.where(weights > 0.0, values, np.inf), axis=0)
    values, weights = np.take_along_axis(values, order, 0), np.take_along_axis(weights, order, 0)
    reached = np.cumsum(weights, axis=0) >= 0.5 * weights.sum(0)
    place = np.argmax(reached, axis=0)
    return np.take_along_axis(values, place[None], 0)[0], np.asarray(weights.sum(0) > 0.0)


def _areas(off: BoolArray) -> BoolArray:
    """Connected areas of some size, widened."""
    import cv2

    count, labels, statistics, _ = cv2.connectedComponentsWithStats(off.astype(np.uint8), connectivity=4)
    large = np.zeros(count, bool)
    large[1:] = statistics[1:, cv2.CC_STAT_AREA] >= LEAST_CELLS
    areas = large[labels]
    if not areas.any():
        return np.asarray(areas)
    return np.asarray(cv2.dilate(areas.astype(np.uint8), _square(REACH_CELLS)) > 0)


def _as_pixels(cells: BoolArray, side: int, box: tuple[slice, slice], shape: tuple[int, ...]) -> BoolArray:
    pixels = np.zeros(shape, bool)
    spread = np.repeat(np.repeat(cells, side, axis=0), side, axis=1)
    pixels[box][: spread.shape[0], : spread.shape[1]] = spread
    return pixels


def _means(image: FloatArray, side: int) -> FloatArray:
    import cv2

    height, width = (size // side for size in image.shape[:2])
    cut = np.ascontiguousarray(image[: height * side, : width * side])
    return np.asarray(cv2.resize(cut, (width, height), interpolation=cv2.INTER_AREA))


def _square(reach: int) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    return np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)

"""The photographs of a bracket brought onto the frame of the first, by shifts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from ..errors import PhotographError
from ..model import BoolArray, FloatArray, Photograph
from .read import neighbourhood

STILL_PX = 0.1
"""Shifts below this, and parts of a pixel below this, are left alone: interpolation would cost more than it
mends."""

LEVEL_RADII_PX = (60.0, 150.0, 400.0)
"""Radii to which larger balls are scaled down for the registration, one after the other."""

SURROUNDINGS_PX = 5.0
"""Detail is what differs from the surroundings, blurred with this standard deviation."""

CLIPPED_REACH_PX = 4
"""Clipped and dark areas count as wider by this much, as far as enough is left: they change the surroundings in one picture
and not in the other, which would seem a shift. With it, shifts of simulated brackets of four times the exposure are
found to 0.04 px (raw) and 0.06 px (JPEG), without to 0.06 and 0.11."""

IMPROVEMENT = 0.97
"""A shift is believed when it leaves less than this share of the disagreement that the outlines' shift
leaves."""

SIGNIFICANCE = 3.0
"""And when it is this many of its standard errors: a few lamps in a black, noisy picture always agree better somewhere."""

DEPENDENT_PX = 4.0 * np.pi
"""Pixels that share their noise after a blur of one pixel."""


def align(photographs: Sequence[Photograph], shifts_px: Sequence[FloatArray]) -> list[Photograph]:
    """Bring every photograph of a bracket onto the frame of the first one.

    Parameters
    ----------
    photographs
        A bracket; crops of it may differ in size and place.
    shifts_px
        Where each photograph's ball lies from the first's, (x, y) in pixels, as `register` finds it.

    Returns
    -------
    list of Photograph
        All of the first one's size. Photographs that agree already to a tenth of a pixel are returned as
        they are, the very same arrays; others are moved, by whole pixels without interpolation where that
        is enough. Pixels from outside a photograph are 0 and `clipped`, so that a merge ignores them.
    """
    if len(photographs) != len(shifts_px):
        raise PhotographError(
            f"{len(shifts_px)} shifts for {len(photographs)} photographs. Give one for each photograph."
        )
    if not photographs:
        return []
    shape = photographs[0].pixels.shape[:2]
    return [
        _moved(photograph, np.asarray(shift, float), shape)
        for photograph, shift in zip(photographs, shifts_px, strict=True)
    ]


def register(
    photographs: Sequence[Photograph], circles_px: Sequence[tuple[float, float, float]]
) -> list[FloatArray]:
    """Where each photograph's picture of the ball lies from the first's: a shift (x, y) in pixels for each.

    The circles give the shift to about a pixel; each photograph is then registered to its neighbour in
    exposure, with which it shares the most unclipped pixels, by the picture inside the ball.

    Parameters
    ----------
    photographs
        A bracket.
    circles_px
        Roughly where the ball is in each: centre x, y and radius. A few per cent of the radius are near enough.
    """
    centres = [np.asarray(circle[:2], float) for circle in circles_px]
    brightness = [_brightness(photograph) for photograph in photographs]
    order = sorted(range(len(photographs)), key=lambda index: brightness[index])
    start = order.index(0)
    shifts: list[FloatArray] = [np.zeros(2) for _ in photographs]
    for chain in (order[start:], order[start::-1]):
        for known, index in pairwise(chain):
            first, second = photographs[known], photographs[index]
            between = centres[index] - centres[known]
            if first.pixels.shape == second.pixels.shape and np.abs(between).max() < 0.5:
                between = np.zeros(2)  # a camera that stood still is far likelier than half a pixel
            radius = circles_px[known][2]
            for level in LEVEL_RADII_PX:
                between = _registered(first, second, centres[known], radius, between, level)
                if level >= radius:
                    break
            shifts[index] = shifts[known] + between
    return shifts


def _brightness(photograph: Photograph) -> float:
    step = max(1, min(photograph.pixels.shape[:2]) // 200)
    return float(photograph.pixels[::step, ::step].mean())


def _registered(
    first: Photograph,
    second: Photograph,
    centre: FloatArray,
    radius: float,
    between: FloatArray,
    level_radius: float,
) -> FloatArray:
    """The shift between two photographs refined by their pictures of the ball, if that is clearly better."""
    import cv2

    scale = min(1.0, level_radius / radius)
    size = int(2.0 * radius * scale) + 1
    here, here_seen = _detail(first, centre - radius, scale, size)
    there, there_seen = _detail(second, centre - radius + between, scale, size)
    row, column = np.mgrid[:size, :size]
    disc = np.hypot(column - size / 2, row - size / 2) < 0.97 * size / 2
    seen = here_seen & there_seen & disc
    if np.count_nonzero(seen) < 0.02 * size * size:
        return between
    inner = cv2.erode(seen.astype(np.uint8), np.ones((2 * CLIPPED_REACH_PX + 1,) * 2, np.uint8)) > 0
    if np.count_nonzero(inner) >= 0.05 * size * size:
        seen = inner
    mask = seen.astype(np.uint8)
    before = _disagreement(here, there, seen)
    warp = np.eye(2, 3, dtype=np.float32)
    criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 60, 1e-4)
    try:
        _, warp = cv2.findTransformECC(here, there, warp, cv2.MOTION_TRANSLATION, criteria, mask, 3)
    except cv2.error:  # it does not converge where there is too little to see
        return between
    shift = np.asarray(warp[:, 2], float)
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    matched = cv2.warpAffine(there, warp, (size, size), flags=flags)
    after = _disagreement(here, matched, seen)
    if np.abs(shift).max() > 0.05 * radius * scale or after > IMPROVEMENT * before:
        return between
    if (np.abs(shift) < SIGNIFICANCE * _shift_error(here, matched, seen)).all():
        return between
    return between + shift / scale


def _detail(
    photograph: Photograph, corner: FloatArray, scale: float, size: int
) -> tuple[npt.NDArray[np.float32], BoolArray]:
    """Fine detail (size, size) of log luminance from a corner (x, y) on, and where it can be trusted."""
    import cv2

    height, width = photograph.clipped.shape
    margin = 2.0 + 2.0 / scale
    left, right = (int(np.clip(corner[0] + a, 0, width)) for a in (-margin, size / scale + margin))
    top, bottom = (int(np.clip(corner[1] + a, 0, height)) for a in (-margin, size / scale + margin))
    if right - left < 8 or bottom - top < 8:
        return np.zeros((size, size), np.float32), np.zeros((size, size), bool)
    matrix = np.array([[1.0 / scale, 0.0, corner[0] - left], [0.0, 1.0 / scale, corner[1] - top]])
    matrix[:, 2] += 0.5 / scale - 0.5  # from pixel centres at integers, as OpenCV counts, to integer + 0.5
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    luminance = photograph.pixels[top:bottom, left:right].mean(axis=-1)
    hidden = photograph.clipped[top:bottom, left:right].astype(np.float32)
    if scale < 1.0:
        luminance = cv2.GaussianBlur(luminance, (0, 0), 0.4 / scale)
        hidden = cv2.GaussianBlur(hidden, (0, 0), 0.4 / scale)
    inside = np.ones(luminance.shape, np.float32)
    picture = cv2.warpAffine(luminance, matrix, (size, size), flags=flags, borderMode=cv2.BORDER_REPLICATE)
    clipped = cv2.warpAffine(hidden, matrix, (size, size), flags=flags)
    covered = cv2.warpAffine(inside, matrix, (size, size), flags=flags)
    floor = 0.01 if photograph.display_referred else 0.002
    if photograph.scene_referred_float:
        floor = 0.01 * max(float(np.median(picture)), 1e-6)
    seen = (clipped < 0.02) & (covered > 0.999) & (picture > floor)
    logarithm = np.log(np.maximum(picture, 0.0) + floor).astype(np.float32)
    detail = cv2.GaussianBlur(logarithm, (0, 0), 1.0) - cv2.GaussianBlur(logarithm, (0, 0), SURROUNDINGS_PX)
    contrast = float(detail[seen].std()) if seen.any() else 1.0
    return np.asarray(np.clip(detail / max(contrast, 1e-9), -4.0, 4.0), np.float32), np.asarray(seen)


def _disagreement(here: FloatArray, there: FloatArray, seen: BoolArray) -> float:
    """One minus the correlation of two pictures where both can be trusted."""
    a = here[seen] - here[seen].mean()
    b = there[seen] - there[seen].mean()
    norm = float(np.sqrt((a**2).sum() * (b**2).sum()))
    return 1.0 - float((a * b).sum()) / norm if norm > 0.0 else 1.0


def _shift_error(here: FloatArray, there: FloatArray, seen: BoolArray) -> FloatArray:
    """Standard error (x, y) of a shift between two matched pictures, from what they still differ by and their gradients."""
    rest = float(np.var(here[seen] - there[seen]))
    squares = np.array([float((slope[seen] ** 2).sum()) for slope in np.gradient(here)[::-1]])
    return np.asarray(np.sqrt(DEPENDENT_PX * rest / np.maximum(squares, 1e-9)))


def _moved(photograph: Photograph, shift: FloatArray, shape: tuple[int, ...]) -> Photograph:
    """The photograph seen in the first's frame (H, W), whose place (x, y) lies at (x, y) + shift in it."""
    whole = np.round(shift)
    part = shift - whole
    if np.abs(part).max() < STILL_PX:
        part = np.zeros(2)
    if not whole.any() and not part.any() and photograph.pixels.shape[:2] == shape:
        return photograph
    pixels, clipped = photograph.pixels, photograph.clipped
    if part.any():
        pixels, clipped = _interpolated(pixels, clipped, part)
    pixels, clipped = _cut(pixels, clipped, int(whole[0]), int(whole[1]), shape)
    return replace(photograph, pixels=pixels, clipped=clipped)


def _interpolated(pixels: FloatArray, clipped: BoolArray, part: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Shift by part of a pixel; what a clipped pixel or the border enters into counts as clipped."""
    import cv2

    height, width = clipped.shape
    matrix = np.array([[1.0, 0.0, part[0]], [0.0, 1.0, part[1]]])
    flags = cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP
    moved = cv2.warpAffine(pixels, matrix, (width, height), flags=flags, borderMode=cv2.BORDER_REPLICATE)
    reached = neighbourhood(clipped, 2)
    reached[:2] = reached[-2:] = True
    reached[:, :2] = reached[:, -2:] = True
    return np.asarray(moved, np.float32), reached


def _cut(
    pixels: FloatArray, clipped: BoolArray, left: int, top: int, shape: tuple[int, ...]
) -> tuple[FloatArray, BoolArray]:
    """The part of a picture from (left, top) on, of shape (H, W); outside it is 0 and clipped."""
    height, width = shape
    result = np.zeros((height, width, 3), np.float32)
    outside = np.ones((height, width), bool)
    rows = slice(max(0, -top), min(height, clipped.shape[0] - top))
    columns = slice(max(0, -left), min(width, clipped.shape[1] - left))
    if rows.start < rows.stop and columns.start < columns.stop:
        source = (
            slice(rows.start + top, rows.stop + top),
            slice(columns.start + left, columns.stop + left),
        )
        result[rows, columns] = pixels[source]
        outside[rows, columns] = clipped[source]
    return result, outside

"""The step that a mirrored ball's rim makes all the way round: everything it reflects is dimmed by the same share.

Where the world behind the ball has strong edges, their reflections run along the rim, a little inside it, and a fit to the
strongest edges follows those. But whatever lies behind, the reflection just inside the rim shows the same thing as the
background just outside, dimmed by the reflectance there: in the logarithm of radiance a step that is the same at every
angle, while other edges differ from angle to angle. The median over the angles shows it.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from ..model import BoolArray, FloatArray, Photograph
from .ellipse import Ellipse, full_turn
from .unrolled import harmonics

_ANGLES = 720
_OFFSET_STEP_PX = 0.25
_WIDTH_PX = 1.0
"""Steps are differences over this distance, of profiles blurred by half of it."""

_REACH = 0.03
"""How far outside an outline the step is looked for, in radii; further out other circles have been tried before."""

_SIDEWAYS = 0.02
"""How far its centre may be off, in radii."""

_LEAST_OUTSIDE_PX = 0.7
"""A step nearer than this to the outline is the outline's own."""

_LEAST_STEP, _LEAST_SIGNIFICANCE, _LEAST_AGREEMENT = 0.01, 6.0, 0.7
"""A step must be of a hundredth, of so many standard errors, and of the same sign at this share of the angles."""

_CREST_PX, _ALIKE, _LEAST_ALONE, _ROUNDS = 1.0, 0.3, 0.15, 5
"""The place of the step at one angle is looked for so near to the median's; it counts where its size is the common one within
30 % and no other edge lies beside it, and at this share of the angles it must count."""

_CORRELATED_ANGLES = 4.0
"""Neighbouring angles share pixels, and noise."""


def step_outside(
    photographs: Sequence[Photograph], shifts_px: Sequence[FloatArray], ellipse: Ellipse
) -> Ellipse | None:
    """The outline through a step of one size all round, clearly outside of an outline; None where there is none.

    Pictures with a tone curve are left alone: sharpening makes rings of its own round everything.
    """
    if any(one.display_referred for one in photographs):
        return None
    sideways = _SIDEWAYS * ellipse.radius
    offsets = np.arange(-2.0 - sideways, (_REACH + _SIDEWAYS) * ellipse.radius + 4.0, _OFFSET_STEP_PX)
    angles = full_turn(_ANGLES)
    steps, told = _steps(photographs, shifts_px, ellipse, angles, offsets)
    if told.mean() < 0.5:
        return None
    start = _most_alike(steps[told][::3], angles[told][::3], offsets, ellipse.radius)
    if start is None:
        return None
    for _ in range(2):  # the second time from the place itself, not from the nearest of those tried
        start = _fitted(steps[told], angles[told], offsets, start)
        if start is None:
            return None
    return ellipse.changed(start)


def _most_alike(
    steps: FloatArray, angles: FloatArray, offsets: FloatArray, radius: float
) -> FloatArray | None:
    """Change (x, y, radius) of the outline along which the steps have most in common; None where that is not enough."""
    most = int(_SIDEWAYS * radius)
    outwards = np.arange(0.0, _REACH * radius + 2.0, _OFFSET_STEP_PX)
    near = np.arange(-most, most + 1)
    moves = [np.array([x, y]) for x in near for y in near if np.hypot(x, y) <= most]
    best, chosen = _LEAST_STEP, None
    for move in moves:
        sideways = harmonics(angles, 2) @ move
        own = np.stack([_at(steps, offsets, sideways + out) for out in outwards], axis=-1)
        median = np.median(own, axis=0)
        size = np.abs(median)
        for column in np.flatnonzero(
            _crests(size) & (outwards > _LEAST_OUTSIDE_PX) & (outwards >= np.hypot(*move))
        ):
            if size[column] > best and _common(own[:, column], median[column]):
                best, chosen = float(size[column]), np.array([*move, outwards[column]])
    return chosen


def _crests(size: FloatArray) -> BoolArray:
    """Where (R,) a size is the largest of its neighbours: no flank of another."""
    return np.asarray(np.r_[False, (size[1:-1] >= size[:-2]) & (size[1:-1] > size[2:]), False])


def _common(steps: FloatArray, median: float) -> bool:
    """Whether steps (A,) at all angles are one: their median beyond its error, and most of its sign."""
    spread = 1.4826 * float(np.median(np.abs(steps - median)))
    error = 1.25 * spread * np.sqrt(_CORRELATED_ANGLES / len(steps))
    alike = np.mean(steps * np.sign(median) > 0.0)
    return bool(abs(median) > _LEAST_SIGNIFICANCE * error and alike > _LEAST_AGREEMENT)


def _steps(
    photographs: Sequence[Photograph],
    shifts_px: Sequence[FloatArray],
    ellipse: Ellipse,
    angles: FloatArray,
    offsets: FloatArray,
) -> tuple[FloatArray, BoolArray]:
    """Steps (A, R) of log radiance outwards across places along an ellipse, and at which angles (A,) they are known."""
    total = np.zeros((len(angles), len(offsets)))
    weight = np.zeros(len(angles))
    near = offsets[0] - 2.0, offsets[-1] + 2.0
    line = np.arange(near[0], near[1], _OFFSET_STEP_PX)
    for photograph, shift in zip(photographs, shifts_px, strict=True):
        radius = ellipse.radius_at(angles)[:, None] + line
        x = (ellipse.x + shift[0] + np.cos(angles)[:, None] * radius - 0.5).astype(np.float32)
        y = (ellipse.y + shift[1] + np.sin(angles)[:, None] * radius - 0.5).astype(np.float32)
        level = np.maximum(photograph.pixels, 0.0).mean(axis=-1)
        profile = cv2.remap(level, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
        hidden = cv2.remap(photograph.clipped.astype(np.float32), x, y, cv2.INTER_LINEAR, borderValue=1.0)
        floor = 1e-3 if not photograph.scene_referred_float else 1e-3 * max(float(np.median(level)), 1e-9)
        trusted = (hidden.max(axis=1) <= 0.0) & (profile.min(axis=1) > 5.0 * floor)
        logarithm = cv2.GaussianBlur(
            np.log(profile + floor), (0, 0), sigmaX=0.5 * _WIDTH_PX / _OFFSET_STEP_PX, sigmaY=1e-3
        )
        half = round(0.5 * _WIDTH_PX / _OFFSET_STEP_PX)
        first = round((offsets[0] - line[0]) / _OFFSET_STEP_PX)
        place = first + np.arange(len(offsets))
        share = np.where(
            trusted, np.minimum(profile.mean(axis=1), 1.0), 0.0
        )  # brighter pictures have less noise
        total += share[:, None] * (logarithm[:, place + half] - logarithm[:, place - half])
        weight += share
    return total / np.maximum(weight, 1e-12)[:, None], weight > 0.0


def _fitted(
    steps: FloatArray, angles: FloatArray, offsets: FloatArray, start: FloatArray
) -> FloatArray | None:
    """Change (x, y, radius) to the crests of the steps, at the angles where nothing else lies near; None with too few."""
    shape = harmonics(angles, 3)
    common = float(np.median(_at(steps, offsets, shape @ start)))
    steps = steps * np.sign(common)
    common = abs(common)
    centre = np.round((shape @ start - offsets[0]) / _OFFSET_STEP_PX).astype(int)
    window = round(_CREST_PX / _OFFSET_STEP_PX)
    row = np.arange(len(steps))
    near = np.clip(centre[:, None] + np.arange(-window, window + 1), 1, len(offsets) - 2)
    crest = near[row, steps[row[:, None], near].argmax(axis=1)]
    before, top, after = (steps[row, crest + shift] for shift in (-1, 0, 1))
    bend = np.minimum(before - 2 * top + after, -1e-9)
    place = offsets[crest] + np.clip(0.5 * (before - after) / bend, -1, 1) * _OFFSET_STEP_PX
    alike = np.abs(top / common - 1.0) < _ALIKE
    # A step blurred by half a pixel is gone two pixels away: what is there is another edge.
    beside = [np.clip(crest + side * round(2.0 / _OFFSET_STEP_PX), 0, len(offsets) - 1) for side in (1, -1)]
    outside, inside = (np.abs(steps[row, place]) < _ALIKE * common for place in beside)
    alone = alike & outside & inside
    if (
        alone.mean() < _LEAST_ALONE
    ):  # edges all along inside, lighter and darker in turn: their pull averages out
        alone = alike & outside
    if alone.mean() < _LEAST_ALONE:
        return None
    change = start
    for _ in range(_ROUNDS):
        residual = place - shape @ change
        used = alone & (np.abs(residual) < max(2.5 * 1.4826 * np.median(np.abs(residual[alone])), 0.02))
        change = np.linalg.lstsq(shape[used], place[used], rcond=None)[0]
    return np.asarray(change)


def _at(steps: FloatArray, offsets: FloatArray, place: FloatArray) -> FloatArray:
    """The steps (A,) at one offset for each angle, between the offsets."""
    position = np.clip((place - offsets[0]) / _OFFSET_STEP_PX, 0.0, len(offsets) - 1.001)
    lower = position.astype(int)
    row = np.arange(len(steps))
    return np.asarray(steps[row, lower] + (position - lower) * (steps[row, lower + 1] - steps[row, lower]))

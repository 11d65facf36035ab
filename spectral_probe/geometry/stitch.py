"""Several views into one panorama, one view at a time ("image composition").

A view samples a direction best where the ball faces it squarely: near the rim a pixel spans many directions, and the
outline's error grows, as 1 / cos(theta_i). (The solid angle of a pixel tells little: far from the camera it is the same
all over the ball, 4 / R^2; it is its longer side that grows.) Towards itself a camera sees only itself, so there the other views
count. What one view alone shows (the photographer, who walked on) gives way to what the others agree on.

Every view gets a score in every direction, a logarithm; its share is the exponential, normalised over the views. Because scores
may come in any order (a running maximum is kept), one view at a time is at hand in full size; what needs all views at once,
whom to believe, is judged on small panoramas.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from ..large import strips
from ..model import BoolArray, FloatArray
from .frames import direction_to_equirectangular, panorama_directions
from .panorama import ViewPanorama
from .sphere import blurred, blurred_where, padded, resized

_OWN_REFLECTION_RAD = (np.radians(9.0), np.radians(16.0))
"""Within the first angle of its own direction a view shows the camera; beyond the second it does not."""

_LAST_RESORT = -40.0
"""Score of a camera's own reflection, for where no other view helps: less than any view's rim."""

_PHOTOGRAPHER_RAD = (np.radians(25.0), np.radians(55.0))
"""Within the first angle of its own direction a view may show the photographer; beyond the second it does not. Where views
disagree, this decides whose word counts."""

_LEAST_VOTE = 0.02
"""How much a view's word counts where it may show the photographer."""

_DISAGREEMENT = 0.08
"""Distance from the median of the views, in natural logarithm of radiance, beyond which a view is doubted."""

_MOST_DOUBT = 200.0
"""Nothing is wholly disbelieved: where a doubted view is the only one, it counts. As a score, above `_CLIPPED`."""

_SPREADS = 1.5
"""Where the views differ from their median by more than `_DISAGREEMENT` in the median, this many times as much is allowed."""

_AGREEMENT_WIDTH_RAD = np.radians(1.5)
"""Standard deviation of the blur under which views are compared: wider than their registration and noise."""

_TRUST_WIDTH = 256
"""Width of the panoramas on which views are compared, in pixels of 1.4 degrees."""

_SHARPNESS = 6
"""Power of the sampling quality: high enough that seams are short, low enough that noise averages."""

_CUT = 1e4
"""Score per radian of the plain cut: its seams are a hundredth of a degree wide."""

_CLIPPED = -1e5
"""Score of what a view has clipped: it counts only where every view has."""

_NEVER = -1e30


def view_score(
    view: ViewPanorama,
    doubt: FloatArray,
    pixel_rad: float,
    composition: str = "blend",
    rows: slice = slice(None),
) -> FloatArray:
    """Score of a view in every direction, (h, W) float32: the logarithm of its share before normalisation.

    Parameters
    ----------
    view
        The view's panorama, (H, W).
    doubt
        (H, W) how little the view is to be believed (`doubts`, `sphere.resized` to the panorama).
    pixel_rad
        Angle that one of its pixels spans where the ball faces the camera.
    composition
        "blend": where it samples best, blended; or "cut", the paper's plain cut: the view whose camera is nearest in angle. For
        cameras on the horizon that is phi within 60 degrees of the direction from the ball to each of three, within 90 of each
        of two, and what no cut covers goes to the nearest.
    rows
        The rows wanted; all by default.
    """
    if composition == "cut":
        score = -_CUT * view.facing_rad[rows]
    else:
        shown = _smooth_step(view.facing_rad[rows], *_OWN_REFLECTION_RAD)
        sampling = np.log(np.maximum(view.cos_incidence[rows], 1e-3) / np.float32(pixel_rad))
        score = _SHARPNESS * sampling + _LAST_RESORT * (1 - shown) - doubt[rows]
    score = np.where(view.valid[rows], score, score + np.float32(_CLIPPED))
    return np.asarray(np.where(view.seen[rows], score, _NEVER), np.float32)


def _smooth_step(value: FloatArray, first: float, last: float) -> FloatArray:
    ramp = np.clip((value - np.float32(first)) / np.float32(last - first), 0.0, 1.0)
    return np.asarray(ramp * ramp * (3 - 2 * ramp))


class Blend:
    """A weighted mean of views that come one after the other, with shares exp(score) whatever the size of the scores.

    `channels` are those of each array that the mean is wanted in; most need one.

    Examples
    --------
    >>> blend = Blend(1, 1, 2)
    >>> blend.add(slice(0, 1), np.array([[[1.0, 5.0]]]), np.array([[2000.0]]))
    >>> blend.add(slice(0, 1), np.array([[[3.0, 7.0]]]), np.array([[2000.0]]))
    >>> blend.mean().tolist()
    [[[2.0, 6.0]]]
    """

    def __init__(self, height: int, width: int, *channels: int) -> None:
        self._sums = [np.zeros((height, width, count), np.float32) for count in channels]
        self._total = np.zeros((height, width), np.float32)
        self._best = np.full((height, width), _NEVER, np.float32)

    def add(self, rows: slice, values: FloatArray, score: FloatArray) -> None:
        """Add some rows of a view: values (h, W, C) of all channels, and their score (h, W)."""
        best = np.maximum(self._best[rows], score)
        before = np.exp(self._best[rows] - best)
        share = np.where(score > _NEVER, np.exp(score - best), 0.0).astype(np.float32)
        self._total[rows] = self._total[rows] * before + share
        first = 0
        for own in self._sums:
            own[rows] *= before[..., None]
            own[rows] += share[..., None] * values[..., first : first + own.shape[-1]]
            first += own.shape[-1]
        self._best[rows] = best

    @property
    def known(self) -> BoolArray:
        """(H, W) where any view was added."""
        return np.asarray(self._total > 0)

    def mean(self) -> FloatArray:
        """The mean, (H, W, C) float32, 0 where nothing is known. It takes the memory of the sums: nothing can be added after."""
        return self.means()[0]

    def means(self) -> list[FloatArray]:
        """The same for a blend of several arrays: (H, W, C) each."""
        for rows in strips(*self._total.shape):
            total = np.where(self._total[rows] > 0, self._total[rows], 1.0)[..., None]
            for own in self._sums:
                own[rows] /= total
        return self._sums


def doubts(
    panoramas: Sequence[ViewPanorama], corrections: FloatArray | None = None, gains: FloatArray | None = None
) -> FloatArray:
    """How little each view is to be believed in every direction, as a score to subtract, (V, h, w) float32.

    A view's disagreement is its distance from the weighted median of all that see the direction; what nobody else shows
    loses. A view counts less in the median towards the rim and around its own camera, where the photographer stands: so of two
    views that disagree there, the other is believed, and of two that disagree elsewhere the one that sees better.

    Parameters
    ----------
    panoramas
        Small panoramas of the views.
    corrections
        (V, 3, 3) rotations from their frames to the world; none by default.
    gains
        (V, 3) factors of their responses; one by default.
    """
    views = len(panoramas)
    if corrections is None:
        corrections = np.tile(np.eye(3), (views, 1, 1))
    if gains is None:
        gains = np.ones((views, 3))
    floor = 0.02 * np.median([_median_response(view) for view in panoramas])
    parts = [
        _compared(view, correction, gain, floor)
        for view, correction, gain in zip(panoramas, corrections, gains, strict=True)
    ]
    logs, votes, seen, valid = (np.stack(part) for part in zip(*parts, strict=True))
    counted = np.where(valid.any(0), valid, seen)  # clipped views know no better
    votes = votes * counted
    distance = np.abs(logs - _weighted_median(logs, votes)).mean(-1)
    allowed = np.full(distance.shape[1:], _DISAGREEMENT, np.float32)
    if views > 2:  # where all differ (things near the ball) no view is more to be doubted than another
        spread = _weighted_median(distance[..., None], votes)[..., 0]
        allowed = np.where(counted.sum(0) > 2, np.maximum(allowed, _SPREADS * spread), allowed)
    times = np.where(counted, np.maximum(distance - allowed, 0.0) / allowed, 0.0)
    doubt = np.minimum(times**2 / (1.0 + 0.5 * times), _MOST_DOUBT)
    return np.stack([blurred(own, _AGREEMENT_WIDTH_RAD) for own in doubt])


def _median_response(view: ViewPanorama) -> float:
    return max(float(np.median(view.responses[view.seen])), 1e-30) if view.seen.any() else 1.0


def _compared(
    view: ViewPanorama, correction: FloatArray, gain: FloatArray, floor: float
) -> tuple[FloatArray, FloatArray, BoolArray, BoolArray]:
    """A view in the world, small: blurred logarithm (h, w, 3), its vote (h, w), and where it saw and was not clipped."""
    log = np.log(np.maximum(view.responses, 0.0) * gain.astype(np.float32) + np.float32(floor))
    first, last = _PHOTOGRAPHER_RAD
    own = _LEAST_VOTE + (1 - _LEAST_VOTE) * _smooth_step(view.facing_rad, first, last)
    seen = view.seen.astype(np.float32)
    small = [
        resized(np.dstack([log * seen[..., None], seen]).astype(np.float32), _TRUST_WIDTH),
        resized(np.dstack([view.cos_incidence * own, view.valid]).astype(np.float32), _TRUST_WIDTH),
    ]
    if not np.array_equal(correction, np.eye(3)):
        small = [_turned(part, correction) for part in small]
    known = small[0][..., 3]
    log = small[0][..., :3] / np.maximum(known, 1e-6)[..., None]
    blur = blurred_where(log, (known > 0.5).astype(np.float32), _AGREEMENT_WIDTH_RAD)
    return blur, np.maximum(small[1][..., 0], 1e-4), known > 0.5, small[1][..., 1] > 0.9


def _turned(values: FloatArray, correction: FloatArray) -> FloatArray:
    """A panorama (h, w, C) turned into the world."""
    height, width = values.shape[:2]
    directions = panorama_directions(height, width) @ correction
    points = (direction_to_equirectangular(directions, height, width) + 0.5).astype(
        np.float32
    )  # one texel of padding
    return np.asarray(cv2.remap(padded(values, 1, 1), points, None, cv2.INTER_LINEAR))


def _weighted_median(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Median over the first axis of (V, h, w, C) with weights (V, h, w), between the two nearest in proportion: (h, w, C).

    For two views it is their weighted mean, so neither wins by chance.
    """
    order = np.argsort(values, axis=0)
    ordered = np.take_along_axis(values, order, axis=0)
    weight = np.take_along_axis(np.broadcast_to(weights[..., None], values.shape), order, axis=0)
    above = np.cumsum(weight, axis=0)
    place = (above - 0.5 * weight) / np.maximum(above[-1], 1e-12)  # of each value's middle, in 0..1
    used = weight > 0
    result = np.zeros(values.shape[1:])
    last_place, last = np.zeros_like(result), np.zeros_like(result)
    started, done = np.zeros(result.shape, bool), np.zeros(result.shape, bool)
    for value, here, counts in zip(ordered, place, used, strict=True):
        reached = counts & (here >= 0.5) & ~done
        share = np.where(started, (0.5 - last_place) / np.maximum(here - last_place, 1e-9), 1.0)
        result = np.where(reached, last + share * (value - last), result)
        done |= reached
        result = np.where(counts & ~done, value, result)  # what lies highest, should none reach the middle
        last, last_place = np.where(counts, value, last), np.where(counts, here, last_place)
        started |= counts
    return np.asarray(result, np.float32)

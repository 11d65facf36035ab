"""Gains between views: one factor a channel, from what both see well."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from ..model import BoolArray, FloatArray
from .frames import direction_to_equirectangular
from .panorama import ViewPanorama
from .sphere import padded, resized
from .view_features import even_directions

_WIDTH = 128
_DIRECTIONS = 6000
_ROUNDS = 10

_LEAST_GAIN = 0.005
"""Less than half a percent is not corrected: the reflectance of the ball, which is not divided out here, leaves as much."""

_AGREEMENT = 0.3
"""Views farther from the median than this, in natural logarithm, show something else (a moved thing, an edge)."""

_LEAST_COSINE = 0.35
"""Nearer to the rim the ball's reflectance and the directions are too uncertain to tell a gain."""

_FACING_RAD = np.radians(25.0)
"""Nearer to itself than this a view shows the camera and the photographer."""

_LEAST_SHARED = 60
"""Directions, of all, that two views must share for a gain to mean something (1 % of the sphere)."""


def match_gains(panoramas: Sequence[ViewPanorama], corrections: FloatArray, anchor: int) -> FloatArray:
    """Factors (V, 3) that match each view's responses to the anchor's, as robust medians of logarithmic ratios.

    Every view is compared with what the views agree on in each direction (the mean of those near their median: the median
    alone would be one of the views, and hide small gains), again and again; the anchor's factors are then one.

    Parameters
    ----------
    panoramas
        The views at their nominal rotations.
    corrections
        (V, 3, 3) from there to the registered ones.
    anchor
        Number of the view that keeps its level.
    """
    directions = even_directions(_DIRECTIONS)
    parts = [_logarithms(view, directions @ turn) for view, turn in zip(panoramas, corrections, strict=True)]
    usable: BoolArray = np.stack([part[1] for part in parts])  # (V, N)
    shared = usable.sum(0) > 1
    usable = usable[:, shared]
    hidden = np.repeat(~usable[..., None], 3, axis=-1)
    log = np.ma.array(np.stack([part[0][shared] for part in parts]), mask=hidden)  # (V, N, 3)
    gains = np.zeros((len(panoramas), 3))
    if usable.shape[1] < _LEAST_SHARED:
        return np.exp(gains)
    enough = usable.sum(1) >= _LEAST_SHARED
    for _ in range(_ROUNDS):
        matched = log + gains[:, None]
        agreeing = np.ma.masked_where(
            np.ma.abs(matched - np.ma.median(matched, axis=0)) > _AGREEMENT, matched
        )
        difference = np.ma.median(agreeing.mean(0) - log, axis=1).filled(0.0)
        gains = np.where(enough[:, None], difference, gains)
    gains = np.where(enough[:, None] & enough[anchor], gains - gains[anchor], 0.0)
    gains[np.abs(gains).max(1) < _LEAST_GAIN] = 0.0
    return np.asarray(np.exp(gains))


def _logarithms(view: ViewPanorama, directions: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Logarithm of the responses (N, 3) in directions of the view's own frame, and where it can be used (N,)."""
    usable = view.valid & (view.cos_incidence > _LEAST_COSINE) & (view.facing_rad > _FACING_RAD)
    small = resized(np.dstack([view.responses, usable.astype(np.float32)]).astype(np.float32), _WIDTH)
    points = direction_to_equirectangular(directions, *small.shape[:2]) + 0.5  # one texel of padding
    found = cv2.remap(padded(small, 1, 1), points.astype(np.float32)[None], None, cv2.INTER_LINEAR)[0]
    colour, inside = found[:, :3], found[:, 3] > 0.98
    dark = 0.05 * np.median(colour[inside], axis=0) if inside.any() else np.zeros(3)
    return np.log(np.maximum(colour, 1e-30)), inside & (colour > np.maximum(dark, 1e-30)).all(-1)

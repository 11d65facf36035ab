"""Several views into one panorama: every direction is taken where it is sampled best ("image composition").

A view samples a direction best where the ball faces it squarely: near the rim a pixel spans many directions and
the outline's error grows as 1 / cos(theta_i). Towards itself a camera sees only itself, so there the other views count.
What one view alone shows (the photographer, who walked on) gives way to what two others agree on.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from ..model import BoolArray, FloatArray
from .panorama import ViewPanorama

_OWN_REFLECTION_RAD = (np.radians(9.0), np.radians(16.0))
"""Within the first angle of its own direction a view shows the camera; beyond the second it does not."""

_LAST_RESORT = 1e-4
"""Weight of a camera's own reflection where no other view helps."""

_DISAGREEMENT = 0.08
"""Distance from the median of the views, in natural logarithm of radiance, beyond which a view is doubted."""

_LEAST_TRUST = 1e-6
"""Nothing is wholly disbelieved: where a doubted view is the only one, it counts."""

_AGREEMENT_WIDTH_RAD = np.radians(1.5)
"""Standard deviation of the blur under which views are compared: wider than their registration and noise."""

_SHARPNESS = 6
"""Power of the sampling quality: high enough that seams are short, low enough that noise averages."""


def view_weights(views: Sequence[ViewPanorama]) -> FloatArray:
    """Share of each view in every direction, (V, H, W) float32, summing to one where any view is valid, else 0.

    Directions that every view that sees them has clipped get the shares of those views all the same: what they hold is
    a lower bound, and better than nothing; `valid` of the result tells.

    Examples
    --------
    >>> flat = np.ones((1, 2), np.float32)
    >>> view = ViewPanorama(np.ones((1, 2, 3)), np.ones((1, 2, 3)), flat, flat, flat > 0, flat > 0)
    >>> view_weights([view, view]).tolist()
    [[[0.5, 0.5]], [[0.5, 0.5]]]
    """
    any_valid = np.any([view.valid for view in views], axis=0)
    quality = np.stack([_quality(view, np.where(any_valid, view.valid, view.seen)) for view in views])
    if len(views) >= 3:
        quality *= _trust(views, any_valid)
    total = quality.sum(0)
    return np.asarray(quality / np.where(total > 0, total, 1.0), np.float32)


def _quality(view: ViewPanorama, usable: BoolArray) -> FloatArray:
    first, last = _OWN_REFLECTION_RAD
    ramp = np.clip((view.facing_rad - first) / (last - first), 0.0, 1.0)
    shown = np.maximum(ramp * ramp * (3 - 2 * ramp), _LAST_RESORT)
    return np.where(usable, np.maximum(view.cos_incidence, 1e-3) ** _SHARPNESS * shown, 0.0)


def _trust(views: Sequence[ViewPanorama], any_valid: BoolArray) -> FloatArray:
    """How far each view is to be believed in every direction, (V, H, W) in 0..1.

    A view's disagreement is its distance from the median of all that see the direction; what nobody else shows loses.
    Where fewer than three see a direction nobody can say who is right, and all are believed.
    """
    seen = np.stack(
        [np.where(any_valid, view.valid, view.seen) for view in views]
    )  # clipped views know no better
    logs = np.ma.array([_blurred_log(view) for view in views], mask=np.repeat(~seen[..., None], 3, axis=-1))
    distance = np.abs(logs - np.ma.median(logs, axis=0)).mean(-1).filled(0.0)
    excess = np.where(seen.sum(0) >= 3, np.maximum(distance - _DISAGREEMENT, 0.0), 0.0)
    return np.asarray(np.maximum(np.exp(-((excess / _DISAGREEMENT) ** 2)), _LEAST_TRUST), np.float32)


def _blurred_log(view: ViewPanorama) -> FloatArray:
    """Logarithm of the responses, blurred over the sphere's texels that the view saw; a floor keeps noise in the dark out."""
    width = view.seen.shape[1]
    floor = max(0.02 * float(np.median(view.responses[view.seen])), 1e-30) if view.seen.any() else 1.0
    log = np.log(np.maximum(view.responses, 0.0) + floor).astype(np.float32)
    seen = view.seen.astype(np.float32)
    sigma = _AGREEMENT_WIDTH_RAD * width / (2 * np.pi)
    margin = min(int(np.ceil(4 * sigma)), width)
    blurred = []
    for channel in (*np.moveaxis(log * seen[..., None], -1, 0), seen):
        around = np.pad(channel, ((0, 0), (margin, margin)), mode="wrap")  # a panorama goes round
        blurred.append(
            cv2.GaussianBlur(around, (0, 0), sigma, borderType=cv2.BORDER_REFLECT)[:, margin : margin + width]
        )
    return np.asarray(np.stack(blurred[:3], axis=-1) / np.maximum(blurred[3], 1e-6)[..., None])


def fill_unseen(values: FloatArray, known: BoolArray) -> FloatArray:
    """Values of directions nobody saw, from their surroundings: pull-push over halved resolutions.

    Parameters
    ----------
    values
        (H, W, K).
    known
        (H, W) where `values` are to be kept.

    Returns
    -------
    ndarray
        (H, W, K) float32; the known ones unchanged. All zero where nothing is known.
    """
    values = np.asarray(values, np.float32)
    if known.all() or not known.any():
        return values if known.any() else np.zeros_like(values)
    return np.where(known[..., None], values, _pull_push(values * known[..., None], known.astype(np.float32)))


def _pull_push(weighted: FloatArray, weight: FloatArray) -> FloatArray:
    height, width = weight.shape
    mean = weighted / np.maximum(weight, 1e-6)[..., None]
    if min(height, width) <= 1 or weight.min() > 0.5:
        return mean
    half = (max(width // 2, 1), max(height // 2, 1))
    smaller = np.dstack(
        [cv2.resize(channel, half, interpolation=cv2.INTER_AREA) for channel in np.moveaxis(weighted, -1, 0)]
    )
    below = _pull_push(smaller, cv2.resize(weight, half, interpolation=cv2.INTER_AREA))
    filled = np.dstack(
        [
            cv2.resize(channel, (width, height), interpolation=cv2.INTER_LINEAR)
            for channel in np.moveaxis(below, -1, 0)
        ]
    )
    share = np.clip(weight, 0.0, 1.0)[..., None]
    return np.asarray(share * mean + (1 - share) * filled)

"""A rotation found by trying many: where the angles given are too far off for a descent to find the way."""

from __future__ import annotations

import numpy as np

from ..model import FloatArray
from .bundle import rotation_of
from .view_features import FeatureMap

_REACH = (2, 2, 4)
"""Steps tried to both sides about the world's x, y and z: azimuths are guessed worse than a camera is levelled."""

_STEPS_RAD = (np.radians(4.5), np.radians(1.5))
"""Spacing of the rotations tried: first over the whole reach, then around the best."""

_DISTRUST = 0.8
"""Correlation by which a turn of one radian must beat the angles given (by its square): rooms repeat themselves."""


def search_rotation(
    features: FeatureMap,
    correction: FloatArray,
    reference: FloatArray,
    weight: FloatArray,
    directions: FloatArray,
) -> FloatArray:
    """The correction (3, 3) under which a view correlates best with a reference.

    Parameters
    ----------
    features
        The view's detail, coarse.
    correction
        (3, 3) from the map to the world, at which the search starts.
    reference, weight
        (N,) detail to be found, and how much each direction counts.
    directions
        (N, 3) in the world.
    """
    counted = weight > 0.05 * weight.max(initial=0.0)
    if not counted.any():
        return correction
    reference, weight, directions = (
        reference[counted],
        weight[counted],
        directions[counted].astype(np.float32),
    )
    best = np.zeros(3)
    for reach, step in ((_REACH, _STEPS_RAD[0]), ((2, 2, 2), _STEPS_RAD[1])):
        axes = [np.arange(-steps, steps + 1) * step for steps in reach]
        vectors = best + np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        scores = [
            _correlation(features, rotation_of(vector) @ correction, reference, weight, directions)
            - _DISTRUST * float(vector @ vector)
            for vector in vectors
        ]
        best = vectors[int(np.argmax(scores))]
    return np.asarray(rotation_of(best) @ correction)


def _correlation(
    features: FeatureMap,
    correction: FloatArray,
    reference: FloatArray,
    weight: FloatArray,
    directions: FloatArray,
) -> float:
    """Correlation with the reference of the nearest texels: no interpolation, since many are to be tried."""
    height, width = features.size
    local = directions @ correction.astype(np.float32)
    margin = (features.weight.shape[1] - width) // 2
    column = ((0.5 - np.arctan2(local[:, 1], local[:, 0]) / np.float32(2 * np.pi)) * width).astype(np.intp)
    row = ((0.5 - np.arcsin(np.clip(local[:, 2], -1, 1)) / np.float32(np.pi)) * height).astype(np.intp)
    at = (row.clip(0, height - 1) + margin, column + margin)
    detail, both = features.values[at][:, 0], features.weight[at] * weight
    total = float(both.sum())
    if total < 0.02 * float(weight.sum()):
        return 0.0
    first = detail - (both @ detail) / total
    second = reference - (both @ reference) / total
    power = float((both @ first**2) * (both @ second**2))
    return float(both @ (first * second)) / float(np.sqrt(power)) if power > 0 else 0.0

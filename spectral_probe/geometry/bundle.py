"""All views' rotations at once, from their detail on the sphere: a photometric bundle adjustment in SO(3).

The views of a ball are not taken from one point: a direction is mirrored on the side of the ball that faces the camera,
so what is near shows up to a ball's radius apart. Seen from the ball's centre at the distance D a thing's direction u
appears in a view turned away from its camera's direction c by (r / D) sin(theta_i); with the half vector along u + c
this is q (c - (c.u) u) / |u + c| with q = r / D. A smooth q (real spherical harmonics up to degree two) is solved for along
with the rotations, so that a near floor does not turn the views.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from ..model import FloatArray
from .view_features import FeatureMap, even_directions, sample

_DEPTH_PRIOR = 0.02
"""Expected size of r / D: things a metre or two from a ball of a few centimetres."""

_DEPTHS = 9
_TURN_PRIOR_RAD = np.radians(20.0)

_STILL = 0.001
"""A level ends when no view turns by more than this share of its finer blur: a hundredth of what is asked for."""

_TURNS = 20

_SLOWEST = 0.85
"""Steps may be summed ahead as if each were at most this share of the one before."""

_ROBUST = 1.5
"""Residuals beyond this many times their usual size count less and less (Geman-McClure)."""

_CORRELATED = 4.0
"""Area over which residuals of a level agree with each other, in squares of its finer blur width (times pi)."""


@dataclass(frozen=True)
class Level:
    """One step from coarse to fine.

    Width of the maps, blur widths of their detail, number of directions compared, the shift that is no outlier as a share of the
    finer blur, and the most iterations.
    """

    width: int
    fine_rad: float
    coarse_rad: float
    directions: int
    shift: float
    iterations: int


@dataclass(frozen=True)
class Bundle:
    """State of the adjustment: `corrections` (V, 3, 3) turn each view's map into the world, `depths` (9,) are those of q.

    `covariance` (V, 3, 3) of each view's rotation vector in rad^2; zero for views that do not move.
    """

    corrections: FloatArray
    depths: FloatArray
    covariance: FloatArray


def harmonics(directions: FloatArray) -> FloatArray:
    """Real spherical harmonics up to degree two of directions (N, 3), not normalised, each of size about one: (N, 9)."""
    x, y, z = directions.T
    one = np.ones_like(x)
    return np.stack([one, x, y, z, x * y, y * z, z * x, x * x - y * y, 1.5 * z * z - 0.5], axis=-1)


def rotation_of(vector_rad: FloatArray) -> FloatArray:
    """Rotation matrix (3, 3) of a rotation vector."""
    return np.asarray(cv2.Rodrigues(np.asarray(vector_rad, float))[0])


def angle_between(first: FloatArray, second: FloatArray) -> float:
    """Angle in radians between two rotations (3, 3).

    Examples
    --------
    >>> round(angle_between(np.eye(3), rotation_of(np.array([0.0, 0.1, 0.0]))), 6)
    0.1
    """
    return float(np.linalg.norm(cv2.Rodrigues(first.T @ second)[0]))


@dataclass(frozen=True)
class Samples:
    """What every view shows in the same world directions, float32.

    `detail` (V, N) and its `weight` (V, N); `steepness` (V, N), the squared gradient; and the derivatives of the detail by the
    view's rotation vector, `by_turn` (V, 3, N), and by the depth q there, `by_depth` (V, N).
    """

    detail: FloatArray
    weight: FloatArray
    steepness: FloatArray
    by_turn: FloatArray
    by_depth: FloatArray


def sample_views(
    maps: Sequence[FeatureMap], cameras: FloatArray, bundle: Bundle, directions: FloatArray
) -> Samples:
    """All views read in the same world directions (N, 3); `cameras` (V, 3) point from the ball to each camera in the maps."""
    directions = directions.astype(np.float32)
    depth = (harmonics(directions) @ bundle.depths.astype(np.float32))[:, None]
    parts = []
    for features, camera, correction in zip(maps, cameras, bundle.corrections, strict=True):
        turn = correction.astype(np.float32)
        towards = turn @ camera.astype(np.float32)
        along = directions @ towards
        half = np.sqrt(np.maximum(2.0 + 2.0 * along, 0.0025))[:, None]  # |u + c|
        parallax = (along[:, None] * directions - towards) / half
        apparent = directions + depth * parallax
        apparent /= np.linalg.norm(apparent, axis=1, keepdims=True)
        detail, gradient, weight = sample(features, apparent @ turn)
        gradient = gradient @ turn.T
        steepness = np.einsum("nk,nk->n", gradient, gradient)
        by_depth = np.einsum("nk,nk->n", gradient, parallax)
        parts.append((detail, weight, steepness, _across(gradient, directions), by_depth))
    return Samples(*(np.stack(part) for part in zip(*parts, strict=True)))


def _across(first: FloatArray, second: FloatArray) -> FloatArray:
    """Vector products of (N, 3) and (N, 3), component by component: (3, N)."""
    (ax, ay, az), (bx, by, bz) = first.T, second.T
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def robust_weights(samples: Samples, shift_rad: float) -> tuple[FloatArray, FloatArray]:
    """Weights (V, N), inverse variances that also doubt what differs from the others, and the weighted mean (N,).

    The variance is that of noise plus that of a shift of `shift_rad` along the gradient (what parallax and the rotations yet
    to be found do): so an edge out of place is no outlier, and no lamp outweighs a wall.
    """
    steepness = (samples.weight * samples.steepness).sum(0) / np.maximum(samples.weight.sum(0), 1e-9)
    shifts = steepness * shift_rad**2
    counted = (samples.weight > 0.02) & ((samples.weight > 0.02).sum(0) > 1)
    weight = samples.weight
    for _ in range(3):
        mean = (weight * samples.detail).sum(0) / np.maximum(weight.sum(0), 1e-9)
        residual = samples.detail - mean
        noise = float(np.median(np.abs(residual[counted]))) if counted.any() else 1.0
        variance = max(1.4826 * noise, 0.02) ** 2 + shifts
        weight = samples.weight / (variance * (1.0 + residual**2 / (_ROBUST**2 * variance)) ** 2)
    return weight, (weight * samples.detail).sum(0) / np.maximum(weight.sum(0), 1e-9)


def solve_level(
    maps: Sequence[FeatureMap],
    cameras: FloatArray,
    bundle: Bundle,
    level: Level,
    moving: Sequence[int],
    *,
    with_depth: bool = True,
) -> Bundle:
    """Gauss-Newton over the rotations of the `moving` views and the depth field; what all see in common is eliminated.

    With the weighted mean of the views in each direction as a nuisance, the normal equations are
    sum w J J^T - (sum w J)(sum w J)^T / sum w: exact, without a choice of reference view.
    """
    directions = even_directions(level.directions)
    basis = harmonics(directions).astype(np.float32)
    views, count = len(maps), 3 * len(maps) + _DEPTHS
    free = [3 * view + axis for view in moving for axis in range(3)]
    free += list(range(3 * views, count)) if with_depth else []
    chosen = np.ix_(free, free)
    # Neighbouring samples agree with each other: that many of them are one observation.
    together = max(_CORRELATED * np.pi * level.fine_rad**2 * level.directions / (4 * np.pi), 1.0)
    prior = together / np.concatenate(
        [np.full(3 * views, _TURN_PRIOR_RAD**2), np.full(_DEPTHS, _DEPTH_PRIOR**2)]
    )
    prior[3 * views + 4 :] *= 4.0  # what is fine in angle is small
    previous: FloatArray | None = None
    for _ in range(level.iterations):
        samples = sample_views(maps, cameras, bundle, directions)
        weight, mean = robust_weights(samples, level.shift * level.fine_rad)
        hessian, gradient = _normal_equations(samples, weight, mean, basis)
        gradient[3 * views :] += prior[3 * views :] * bundle.depths
        hessian[np.diag_indices(count)] += prior
        step = np.zeros(count)
        step[free] = -np.linalg.solve(hessian[chosen], gradient[free])
        if (size := float(np.abs(step[: 3 * views]).max(initial=0.0))) < _STILL * level.fine_rad:
            break
        ahead = 1.0  # steps that shrink slowly along one direction are summed ahead (Aitken)
        if previous is not None:
            ratio = float(previous @ step) / max(float(previous @ previous), 1e-30)
            ahead = 1.0 / (1.0 - float(np.clip(ratio, 0.0, _SLOWEST)))
        previous = step
        bundle = _moved(bundle, step * min(ahead, 2.0 * level.fine_rad / size))
    covariance = np.zeros((count, count))
    covariance[chosen] = np.linalg.inv(hessian[chosen]) * together
    blocks = [covariance[3 * view : 3 * view + 3, 3 * view : 3 * view + 3] for view in range(views)]
    return replace(bundle, covariance=np.stack(blocks))


def _moved(bundle: Bundle, step: FloatArray) -> Bundle:
    turns = step[:-_DEPTHS].reshape(-1, 3)
    corrections = [rotation_of(turn) @ old for turn, old in zip(turns, bundle.corrections, strict=True)]
    return replace(bundle, corrections=np.stack(corrections), depths=bundle.depths + step[-_DEPTHS:])


def _normal_equations(
    samples: Samples, weight: FloatArray, mean: FloatArray, basis: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Hessian and gradient of half the weighted sum of squares, over 3 V rotation and 9 depth parameters."""
    (views, count), depths = weight.shape, basis.shape[1]
    size = 3 * views + depths
    shared = np.empty((size, count), np.float32)  # sum over the views of w J, parameter by parameter
    hessian, gradient = np.zeros((size, size)), np.zeros(size)
    deeper = weight * samples.by_depth
    residual = samples.detail - mean
    for view in range(views):
        rows = slice(3 * view, 3 * view + 3)
        weighted = samples.by_turn[view] * weight[view]
        shared[rows] = weighted
        hessian[rows, rows] = weighted @ samples.by_turn[view].T
        hessian[rows, 3 * views :] = (weighted * samples.by_depth[view]) @ basis
        hessian[3 * views :, rows] = hessian[rows, 3 * views :].T
        gradient[rows] = weighted @ residual[view]
    shared[3 * views :] = deeper.sum(0) * basis.T
    hessian[3 * views :, 3 * views :] = (basis.T * (deeper * samples.by_depth).sum(0)) @ basis
    gradient[3 * views :] = (deeper * residual).sum(0) @ basis
    shared /= np.sqrt(np.maximum(weight.sum(0), 1e-6))
    return hessian - shared @ shared.T, gradient


def correlation(first: FloatArray, second: FloatArray, weight: FloatArray) -> float:
    """Weighted correlation of two samplings (N,), 0 where nothing overlaps."""
    total = float(weight.sum())
    if total <= 0:
        return 0.0
    first = first - (weight * first).sum() / total
    second = second - (weight * second).sum() / total
    power = float((weight * first**2).sum() * (weight * second**2).sum())
    return float((weight * first * second).sum() / np.sqrt(power)) if power > 0 else 0.0


def start(views: int) -> Bundle:
    """Every view at its nominal rotation, everything far away."""
    return Bundle(np.tile(np.eye(3), (views, 1, 1)), np.zeros(_DEPTHS), np.zeros((views, 3, 3)))


def merged_others(samples: Samples, view: int) -> tuple[FloatArray, FloatArray]:
    """Weighted mean (N,) of all views but one, and the weight (N,) of comparing that one with it."""
    weight = samples.weight
    others = np.maximum(weight.sum(0) - weight[view], 0.0)
    total = (weight * samples.detail).sum(0) - weight[view] * samples.detail[view]
    return total / np.maximum(others, 1e-6), weight[view] * others / np.maximum(weight[view] + others, 1e-6)


def remaining_turn(
    features: FeatureMap,
    correction: FloatArray,
    reference: FloatArray,
    weight: FloatArray,
    directions: FloatArray,
    shift_rad: float,
) -> float:
    """Angle in radians by which one view would have to turn to fit a reference (N,) best: a rotation only, nothing else."""
    counted = weight > 0.02
    if not counted.any():
        return 0.0
    turned, directions = correction, directions.astype(np.float32)
    for _ in range(_TURNS):
        detail, gradient, _ = sample(features, directions @ turned.astype(np.float32))
        gradient = gradient @ turned.T.astype(np.float32)
        residual = detail - reference
        noise = max(1.4826 * float(np.median(np.abs(residual[counted]))), 0.02)
        variance = noise**2 + (gradient**2).sum(-1) * shift_rad**2
        trust = weight / (variance * (1.0 + residual**2 / (_ROBUST**2 * variance)) ** 2)
        jacobian = _across(gradient, directions)
        hessian = (jacobian * trust) @ jacobian.T + 1e-6 * np.eye(3)
        step = -np.linalg.solve(hessian, jacobian @ (trust * residual))
        step *= min(1.0, 2 * shift_rad / max(float(np.linalg.norm(step)), 1e-12))
        turned = rotation_of(step) @ turned
    return angle_between(correction, turned)

"""The ball from its outline (fig. 4), and reflection on it: eq. 1 and 3-6 of the paper.

All vectors are in the camera's frame: the centre of projection is the origin, V a unit viewing direction, M the
ball's centre, P the point hit, N its normal, L the direction from which the mirrored light came.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import OutlineError
from ..model import BallFit, BoolArray, Camera, FloatArray, Outline
from .camera import pixel_rays, project
from .interpolate import bilinear

_ROBUST_ROUNDS = 30
_TABLE_SAMPLES = 20001

OUTLIER = 3.0
"""Residuals beyond so many robust standard deviations do not count."""

MODEL_ERROR_PX, INDEPENDENT_ARCS = 0.1, 6.0
"""What no residual shows: whatever lies along the rim moves a stretch of it, some sixth of the whole, by a tenth of a pixel."""

GIVEN_ERROR_PX = 0.5
"""How far an outline without residuals (a circle given by hand) is assumed to be off, in centre and radius."""


def fit_ball(camera: Camera, outline: Outline, radius_m: float) -> BallFit:
    """The ball's centre from its outline, and how well it is known.

    The rays through the outline make a circular cone about the direction C of the ball's centre: C . b = cos(xi) for
    unit rays b is linear in C / cos(xi), so the cone is a plane fitted to unit rays. From there the angles between rays and
    cone are made smallest (Gauss-Newton) without the points beyond three standard deviations, so that a stretch of false
    edge does not pull it.

    Parameters
    ----------
    camera
        The camera's intrinsics.
    outline
        Sub-pixel points of the outline. Where they have no residuals (a circle given by hand) the covariance is that of
        `error_px`, or of half a pixel in the centre and the radius where that is not given either.
    radius_m
        The ball's radius r.

    Returns
    -------
    BallFit
        M with |M| = d = r / sin(xi), and the covariance of C and xi.

    Raises
    ------
    OutlineError
        If the points do not make a cone.
    """
    points = np.asarray(outline.points_px, float)
    rays = pixel_rays(camera, points)
    axis, angle = cone_of_rays(rays, _trusted(rays))
    used = np.ones(len(rays), bool)
    for _ in range(_ROBUST_ROUNDS):
        residual, jacobian = _cone_residuals(rays, axis, angle)
        scale = 1.4826 * float(np.median(np.abs(residual)))
        now = np.abs(residual) <= OUTLIER * scale + 1e-12
        step = np.linalg.lstsq(jacobian[now], residual[now], rcond=None)[0]
        axis, angle = _moved_cone(axis, angle, step)
        settled = np.abs(step).max() < 1e-10 and (now == used).all()
        used = now
        if settled:
            break
    residual, jacobian = _cone_residuals(rays, axis, angle)
    if not 0.0 < angle < np.pi / 2:
        raise OutlineError(_NOT_A_BALL)
    rad_per_px = _angle_of_a_pixel(camera, points, rays, axis)
    covariance = _covariance(outline, jacobian[used], residual[used], float(rad_per_px.mean()))
    return BallFit(
        axis * radius_m / np.sin(angle),
        radius_m,
        angle,
        float(np.sqrt(np.mean(residual[used] ** 2))),
        covariance,
        points,
        residual / rad_per_px,
        used,
    )


_NOT_A_BALL = "The outline is not that of a ball. Write another: outline = [cx, cy, r] in pixels."


def cone_of_rays(rays: FloatArray, weights: FloatArray | None = None) -> tuple[FloatArray, float]:
    """Axis and half angle of the cone through unit rays (N, 3), by weighted total least squares of a plane.

    Examples
    --------
    >>> turn = np.arange(6.0)
    >>> rays = np.stack([0.6 * np.cos(turn), 0.6 * np.sin(turn), np.full(6, 0.8)], axis=-1)
    >>> axis, angle = cone_of_rays(rays)
    >>> bool(np.allclose(axis, [0.0, 0.0, 1.0])), round(float(np.cos(angle)), 9)
    (True, 0.8)
    """
    if len(rays) < 3:
        raise OutlineError(
            "The ball's outline has fewer than three points. Write it: outline = [cx, cy, r] in pixels."
        )
    weights = np.ones(len(rays)) if weights is None else weights
    centre = (weights[:, None] * rays).sum(0) / weights.sum()
    scatter = (weights[:, None] * (rays - centre)).T @ (rays - centre)
    axis = np.linalg.eigh(scatter)[1][:, 0]
    axis = axis * np.sign(axis @ centre)
    cosine = float(axis @ centre)
    if not 0.0 < cosine < 1.0:
        raise OutlineError(_NOT_A_BALL)
    return axis, float(np.arccos(cosine))


def _tangents(axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """`BallFit.axis_tangents` of an axis."""
    right = np.cross([0.0, 1.0, 0.0], axis)
    right /= np.linalg.norm(right)
    return right, np.cross(axis, right)


def _trusted(rays: FloatArray) -> FloatArray:
    """Weights (N,) of rays that lie near the cone that most of them make (Geman-McClure)."""
    weights = np.ones(len(rays))
    for _ in range(20):
        axis, angle = cone_of_rays(rays, weights)
        residual = np.arccos(np.clip(rays @ axis, -1.0, 1.0)) - angle
        scale = max(1.4826 * float(np.median(np.abs(residual))), 1e-9)
        weights = 1.0 / (1.0 + (residual / (2.0 * scale)) ** 2) ** 2
    return weights


def _cone_residuals(rays: FloatArray, axis: FloatArray, angle_rad: float) -> tuple[FloatArray, FloatArray]:
    """Angles (N,) of rays outside the cone, and their change (N, 3) when the cone turns right, down, and opens."""
    right, down = _tangents(axis)
    x, y, along = rays @ right, rays @ down, rays @ axis
    off_axis = np.hypot(x, y)
    residual = np.arctan2(off_axis, along) - angle_rad
    return residual, np.stack([x / off_axis, y / off_axis, np.ones(len(rays))], axis=-1)


def _moved_cone(axis: FloatArray, angle_rad: float, step: FloatArray) -> tuple[FloatArray, float]:
    right, down = _tangents(axis)
    axis = axis + step[0] * right + step[1] * down
    return axis / np.linalg.norm(axis), angle_rad + float(step[2])


def _angle_of_a_pixel(
    camera: Camera, points_px: FloatArray, rays: FloatArray, axis: FloatArray
) -> FloatArray:
    """Angle (N,) in radians that a pixel across the outline spans at each of its points."""
    centre = project(camera, axis)
    outwards = points_px - centre
    outwards /= np.linalg.norm(outwards, axis=-1, keepdims=True)
    beyond = pixel_rays(camera, points_px + outwards)
    return np.asarray(np.arccos(np.clip(beyond @ axis, -1, 1)) - np.arccos(np.clip(rays @ axis, -1, 1)))


def _covariance(
    outline: Outline, jacobian: FloatArray, residual_rad: FloatArray, rad_per_px: float
) -> FloatArray:
    """Covariance (3, 3) of the cone, from its residuals and, for what is common to all points, `error_px`."""
    centre_px, radius_px = outline.error_px
    if outline.rms_px == 0.0:
        centre_px, radius_px = centre_px or GIVEN_ERROR_PX, radius_px or GIVEN_ERROR_PX
    least = np.diag([centre_px, centre_px, radius_px]) ** 2 * rad_per_px**2
    freedom = len(residual_rad) - 3
    if outline.rms_px == 0.0 or freedom <= 0:
        return least
    information = jacobian.T @ jacobian
    round_the_rim = np.argsort(np.arctan2(jacobian[:, 1], jacobian[:, 0]))
    spread = float((residual_rad**2).sum()) / freedom * correlated(residual_rad[round_the_rim])
    spread = max(spread, (MODEL_ERROR_PX * rad_per_px) ** 2 * len(residual_rad) / INDEPENDENT_ARCS)
    covariance = spread * np.linalg.inv(information)
    missing = np.sqrt(np.maximum(np.diag(least) - np.diag(covariance), 0.0))
    return np.asarray(covariance + np.diag(missing**2))


def correlated(residuals: FloatArray) -> float:
    """How many neighbours on a curve err together: N over the number of independent ones among residuals (N,).

    1 + 2 sum of the autocorrelation up to where it vanishes; at least 1, at most a sixth of the points.

    Examples
    --------
    >>> wave = np.repeat([1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0, -1.0], 8)
    >>> correlated(wave) > 5.0, correlated(np.array([1.0, -1.0] * 32))
    (True, 1.0)
    """
    centred = residuals - residuals.mean()
    power = float(centred @ centred)
    total = 1.0
    for lag in range(1, len(centred) // 3):
        correlation = float(centred[lag:] @ centred[:-lag]) / max(power, 1e-300)
        if correlation < 1.0 / np.sqrt(len(centred)):
            break
        total += 2.0 * correlation
    return min(total, max(1.0, len(centred) / 6.0))


@dataclass(frozen=True)
class Reflection:
    """Where viewing rays meet the ball and where the mirrored light came from.

    `hit` (...) is False where a ray misses the ball; there the other arrays hold finite values without meaning.
    `points_m`, `normals`, `directions` are (..., 3); `cos_incidence` is (...).
    """

    hit: BoolArray
    points_m: FloatArray
    normals: FloatArray
    directions: FloatArray
    cos_incidence: FloatArray


def reflect(ball: BallFit, rays: FloatArray) -> Reflection:
    """Mirror viewing rays on the ball.

    Eq. 3 as printed lacks a square: the discriminant is (V.M)^2 - M.M + r^2.

    Parameters
    ----------
    ball
        The ball in the camera's frame.
    rays
        (..., 3) unit viewing directions V.

    Returns
    -------
    Reflection
        P = lambda V (eq. 3), N = (P - M) / r (eq. 4), L = V - 2 (V.N) N (eq. 5), cos(theta_i) = -V.N (eq. 6).

    Examples
    --------
    >>> ball = BallFit(np.array([0.0, 0.0, 1.0]), 0.1, np.arcsin(0.1), 0.0)
    >>> reflect(ball, np.array([0.0, 0.0, 1.0])).directions.tolist()  # straight back
    [0.0, 0.0, -1.0]
    """
    rays = np.asarray(rays, float)
    along = rays @ ball.centre_m
    discriminant = along**2 - ball.centre_m @ ball.centre_m + ball.radius_m**2
    hit = discriminant >= 0
    points = (along - np.sqrt(np.maximum(discriminant, 0.0)))[..., None] * rays
    normals = (points - ball.centre_m) / ball.radius_m
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    cosine = -(rays * normals).sum(-1)
    directions = rays + 2 * cosine[..., None] * normals
    return Reflection(hit, points, normals, directions, np.clip(cosine, 0.0, 1.0))


def find_reflection(
    ball: BallFit, directions: FloatArray, table: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Where on the ball light from given directions is mirrored to the camera: the inverse of `reflect`.

    Everything happens in the plane of the light and the ball's axis: a normal at the angle beta from the axis
    (towards the camera) mirrors light from the angle alpha = beta + theta_i, which grows with beta. The normal is then
    a combination of axis and light, N = a axis + b L, with coefficients that are smooth in cos(alpha / 2): they are
    tabulated once, and no direction needs a trigonometric function of its own.

    Parameters
    ----------
    ball
        The ball in the camera's frame.
    directions
        (..., 3) unit vectors L towards the light, in the camera's frame.
    table
        `reflection_table` of the ball, where it is asked more than once.

    Returns
    -------
    points_m
        (..., 3) float32 points P on the ball.
    cos_incidence
        (...) float32 cosine of the incidence angle; 0 where the camera cannot see the direction (the blind cone
        psi = xi behind the ball, fig. 4: at the rim light grazes the ball, so the last direction seen is the outline's
        own ray).

    Examples
    --------
    >>> ball = BallFit(np.array([0.0, 0.0, 1.0]), 0.1, np.arcsin(0.1), 0.0)
    >>> light = np.array([0.6, 0.0, -0.8])
    >>> point, cosine = find_reflection(ball, light)
    >>> back = reflect(ball, point / np.linalg.norm(point))
    >>> bool(np.allclose(back.directions, light, atol=1e-6)), bool(np.isclose(back.cos_incidence, cosine, atol=1e-6))
    (True, True)
    """
    directions = np.asarray(directions, np.float32)
    axis = (-ball.centre_m / ball.distance_m).astype(np.float32)
    half_angle_cosine = np.sqrt(np.maximum(0.5 + 0.5 * (directions @ axis), 0.0))
    table = reflection_table(ball) if table is None else table
    column = half_angle_cosine * np.float32(len(table) - 1)
    of_axis, of_light, cosine = np.moveaxis(bilinear(table[None], column, np.zeros_like(column)), -1, 0)
    points = np.empty(
        (3, *directions.shape[:-1]), np.float32
    )  # by component: numpy is slow along an axis of 3
    for number, (along, centre) in enumerate(zip(axis, ball.centre_m.astype(np.float32), strict=True)):
        np.multiply(of_light, directions[..., number], out=points[number, ...])
        points[number] += of_axis * along + centre
    return np.moveaxis(points, 0, -1), cosine


def reflection_table(ball: BallFit) -> FloatArray:
    """Coefficients of axis and light in r N, and the cosine of incidence, (N, 3), evenly in cos(alpha / 2) from 0 to 1.

    Beyond the last direction seen the coefficients stay those of the rim and the cosine is 0.
    """
    sine_xi = np.sin(ball.cone_angle_rad)
    beta = np.linspace(0.0, np.pi / 2 - ball.cone_angle_rad, _TABLE_SAMPLES)
    # The triangle camera - ball's centre - P: distance d and r with the angle beta between them.
    incidence = beta + np.arctan2(sine_xi * np.sin(beta), 1 - sine_xi * np.cos(beta))
    alpha = 2.0 * np.arccos(np.linspace(0.0, 1.0, _TABLE_SAMPLES))
    beta = np.interp(alpha, beta + incidence, beta)
    seen = alpha < np.pi - ball.cone_angle_rad
    last = int(seen.argmax())
    of_light = np.sin(beta) / np.maximum(np.sin(alpha), 1e-9)
    of_light[-1] = of_light[-2]  # straight back to the camera the quotient is 0 / 0, and its limit smooth
    of_light[:last] = of_light[last]
    of_axis = np.cos(beta) - of_light * np.cos(alpha)
    cosine = np.where(seen, np.cos(alpha - beta), 0.0)
    return np.stack([ball.radius_m * of_axis, ball.radius_m * of_light, cosine], axis=-1, dtype=np.float32)

"""The ball from its outline (fig. 4), and reflection on it: eq. 1 and 3-6 of the paper.

All vectors are in the camera's frame: the centre of projection is the origin, V a unit viewing direction, M the
ball's centre, P the point hit, N its normal, L the direction from which the mirrored light came.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import OutlineError
from ..model import BallFit, BoolArray, Camera, FloatArray, Outline
from .camera import pixel_rays
from .interpolate import bilinear

_ROBUST_ROUNDS = 20
_SMALLEST_SCALE_RAD = 1e-7
_TABLE_SAMPLES = 20001


def fit_ball(camera: Camera, outline: Outline, radius_m: float) -> BallFit:
    """The ball's centre from its outline.

    The rays through the outline make a circular cone about the direction C of the ball's centre: C . b = cos(xi) for
    unit rays b is linear in C / cos(xi), so the cone is a plane fitted to unit rays. The fit is repeated with
    weights that fall with the residual (Geman-McClure), so that a stretch of false edge does not pull it.

    Parameters
    ----------
    camera
        The camera's intrinsics.
    outline
        Sub-pixel points of the outline.
    radius_m
        The ball's radius r.

    Returns
    -------
    BallFit
        M with |M| = d = r / sin(xi).

    Raises
    ------
    OutlineError
        If the points do not make a cone.
    """
    rays = pixel_rays(camera, outline.points_px)
    weights = np.ones(len(rays))
    for _ in range(_ROBUST_ROUNDS):
        axis, cone_angle = _cone(rays, weights)
        residual = np.arccos(np.clip(rays @ axis, -1.0, 1.0)) - cone_angle
        scale = max(1.4826 * float(np.median(np.abs(residual))), _SMALLEST_SCALE_RAD)
        weights = 1.0 / (1.0 + (residual / (2.0 * scale)) ** 2) ** 2
    rms = float(np.sqrt((weights * residual**2).sum() / weights.sum()))
    return BallFit(axis * radius_m / np.sin(cone_angle), radius_m, cone_angle, rms)


def _cone(rays: FloatArray, weights: FloatArray) -> tuple[FloatArray, float]:
    """Axis and half angle of the cone through unit rays, by weighted total least squares of a plane."""
    if len(rays) < 3:
        raise OutlineError("The ball's outline has fewer than three points. Give it: outline = [cx, cy, r].")
    centre = (weights[:, None] * rays).sum(0) / weights.sum()
    _, _, rows = np.linalg.svd(np.sqrt(weights)[:, None] * (rays - centre), full_matrices=False)
    axis = rows[2] * np.sign(rows[2] @ centre)
    cosine = float(axis @ centre)
    if not 0.0 < cosine < 1.0:
        raise OutlineError("The outline found is not that of a ball. Give it: outline = [cx, cy, r].")
    return axis, float(np.arccos(cosine))


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

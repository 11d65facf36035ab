"""How densely, and how exactly, a view of the ball samples the directions around it.

Both vary slowly over the sphere and are kept as small panoramas.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from ..model import BallFit, Camera, FloatArray
from .ball import find_reflection, reflect
from .frames import panorama_directions

_HEIGHT, _WIDTH = 128, 256
_STEP_RAD = 1e-7
"""For derivatives: far below any outline's error and far above rounding."""

_RIM_SHARE = 0.999
"""Places closer to the rim than this share of its angle stand for all beyond, where both measures go to infinity."""


@dataclass(frozen=True)
class Sampling:
    """Sampling density and accuracy of a view, in the panorama's frame, whatever its resolution.

    `footprint_sr` (H, W) float32 is the solid angle of the directions that one pixel of the photograph sees;
    `direction_error_rad` (H, W) float32 the standard error of the direction, from the outline's covariance. In the blind cone
    both hold the values of its edge.
    """

    footprint_sr: FloatArray
    direction_error_rad: FloatArray

    def resized(self, height: int, width: int) -> Sampling:
        """The same at another resolution."""
        return Sampling(_resized(self.footprint_sr, height, width), self.resized_error(height, width))

    def resized_error(self, height: int, width: int) -> FloatArray:
        """`direction_error_rad` at another resolution."""
        return _resized(self.direction_error_rad, height, width)


def _resized(values: FloatArray, height: int, width: int) -> FloatArray:
    return np.asarray(cv2.resize(values, (width, height), interpolation=cv2.INTER_LINEAR))


def sampling(camera: Camera, ball: BallFit, rotation: FloatArray) -> Sampling:
    """Sampling density and accuracy of a view.

    Parameters
    ----------
    camera, ball
        The view's geometry; `ball.covariance_rad2` is where the errors come from.
    rotation
        (3, 3) camera to world.

    Examples
    --------
    From far away every pixel of a ball of radius R sees 4 / R^2 steradians:

    >>> far = BallFit(np.array([0.0, 0.0, 100.0]), 0.1, np.arcsin(1e-3), 0.0)
    >>> camera = Camera((500000.0, 500000.0), (512.0, 512.0), (1024, 1024))
    >>> footprint = sampling(camera, far, np.eye(3)).footprint_sr * 500**2
    >>> bool(abs(footprint.min() - 4) < 0.02), bool(abs(np.median(footprint) - 4) < 0.02)
    (True, True)
    """
    directions = panorama_directions(_HEIGHT, _WIDTH) @ rotation
    axis = -ball.centre_m / ball.distance_m
    last = np.cos(_RIM_SHARE * (np.pi - ball.cone_angle_rad))
    across = directions - (directions @ axis)[..., None] * axis
    along = np.maximum(directions @ axis, last)
    across *= (np.sqrt(1 - along**2) / np.maximum(np.linalg.norm(across, axis=-1), 1e-12))[..., None]
    points, _ = find_reflection(ball, along[..., None] * axis + across)
    points = points.astype(float)
    return Sampling(
        _footprint(camera, ball, points).astype(np.float32), direction_error(ball, points).astype(np.float32)
    )


def _footprint(camera: Camera, ball: BallFit, points: FloatArray) -> FloatArray:
    """Solid angle of the light that one pixel sees at points P (..., 3) of the ball.

    With beta between axis and normal and gamma between the ray and the ball's centre, light comes from
    alpha = 2 beta + gamma, and a cone of rays sin(gamma) d(gamma) widens to sin(alpha) d(alpha).
    """
    distance = np.linalg.norm(points, axis=-1)
    pixel_sr = (points[..., 2] / distance) ** 3 / (camera.focal_px[0] * camera.focal_px[1])
    ratio = np.sin(ball.cone_angle_rad)  # r / d
    cos_beta = np.clip((ball.centre_m - points) @ ball.centre_m / (ball.distance_m * ball.radius_m), ratio, 1)
    beta = np.maximum(np.arccos(cos_beta), 1e-4)
    squared = 1 - 2 * ratio * np.cos(beta) + ratio**2  # (camera to P / d)^2
    gamma = np.arctan2(ratio * np.sin(beta), 1 - ratio * np.cos(beta))
    gamma_slope = np.maximum(ratio * np.cos(beta) - ratio**2, 1e-9 * ratio) / squared
    widening = np.sin(np.minimum(2 * beta + gamma, np.pi)) * (2 + gamma_slope) / (np.sin(gamma) * gamma_slope)
    return np.asarray(pixel_sr * widening)


def direction_error(ball: BallFit, points: FloatArray) -> FloatArray:
    """Standard error of the light's direction at points (..., 3) of the ball, for fixed viewing rays."""
    rays = points / np.linalg.norm(points, axis=-1, keepdims=True)
    directions = reflect(ball, rays).directions
    axis = ball.centre_m / ball.distance_m
    changed = [
        (axis + _STEP_RAD * ball.axis_tangents[0], 0.0),
        (axis + _STEP_RAD * ball.axis_tangents[1], 0.0),
        (axis, _STEP_RAD),
    ]
    slopes = []
    for turned, wider in changed:
        angle = ball.cone_angle_rad + wider
        centre = turned / np.linalg.norm(turned) * ball.radius_m / np.sin(angle)
        moved = reflect(BallFit(centre, ball.radius_m, angle, 0.0), rays).directions
        slopes.append((moved - directions) / _STEP_RAD)
    jacobian = np.stack(slopes)
    variance = np.einsum("i...d,ij,j...d->...", jacobian, ball.covariance_rad2, jacobian)
    return np.asarray(np.sqrt(np.maximum(variance, 0.0)))

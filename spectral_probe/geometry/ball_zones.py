"""Where on the picture of the ball its directions are well sampled, and which it does not show at all.

A pixel spans ever more directions towards the rim: its longer side grows as 1 / cos(theta_i), and the error that the outline
leaves grows with it. Behind the ball lies the blind cone, as wide as the ball is seen (fig. 4), that no pixel shows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..model import BallFit, Camera, FloatArray
from .camera import project
from .sampling import direction_error

SPANS = (1.25, 1.5, 2.0, 3.0, 4.0, 6.0, 10.0)
"""Zones end where a pixel spans so many times the directions that it spans in the middle of the ball."""

OWN_REFLECTION_RAD = float(np.radians(16.0))
"""Within this angle of its own direction a view may show the camera (`stitch`)."""

_SAMPLES = 32


@dataclass(frozen=True)
class Ring:
    """Places on the ball's picture where light meets the ball at one angle.

    `incidence_rad` is that angle, `light_rad` the angle between the light and the direction to the camera, `error_rad` the
    standard error of the light's direction there. `points_px` (N, 2) go round once, evenly, beginning anywhere.
    """

    incidence_rad: float
    light_rad: float
    error_rad: float
    points_px: FloatArray


def ball_zones(camera: Camera, ball: BallFit) -> tuple[Ring, ...]:
    """Rings on the picture of the ball from its middle to its rim.

    The first encloses the camera's own reflection, the others end where a pixel spans `SPANS` times what it spans in the middle.

    Parameters
    ----------
    camera, ball
        The view's geometry; `ball.covariance_rad2` is where the errors come from.

    Examples
    --------
    >>> ball = BallFit(np.array([0.0, 0.0, 1.0]), 0.1, np.arcsin(0.1), 0.0)
    >>> camera = Camera((1000.0, 1000.0), (100.0, 100.0), (200, 200))
    >>> rings = ball_zones(camera, ball)
    >>> [round(float(np.degrees(ring.incidence_rad))) for ring in rings]
    [8, 37, 48, 60, 71, 76, 80, 84]
    >>> round(float(np.hypot(*(rings[3].points_px - 100).T).mean()))  # nearly sin(60 degrees) of the radius of 100.5
    87
    """
    ratio = float(np.sin(ball.cone_angle_rad))
    incidences = (_incidence_of(OWN_REFLECTION_RAD, ratio), *(float(np.arccos(1.0 / span)) for span in SPANS))
    return tuple(_ring(camera, ball, incidence, ratio) for incidence in incidences)


def _normal_angle(incidence_rad: float, ratio: float) -> float:
    """Angle beta between the normal and the direction to the camera, from the sines of the triangle camera, centre, P."""
    return incidence_rad - float(np.arcsin(ratio * np.sin(incidence_rad)))


def _incidence_of(light_rad: float, ratio: float) -> float:
    """The incidence at which light from an angle off the camera's direction is seen: alpha = beta + theta_i, inverted."""
    incidences = np.linspace(0.0, np.pi / 2, 2048)
    return float(np.interp(light_rad, [_normal_angle(one, ratio) + one for one in incidences], incidences))


def _ring(camera: Camera, ball: BallFit, incidence_rad: float, ratio: float) -> Ring:
    beta = _normal_angle(incidence_rad, ratio)
    right, down = ball.axis_tangents
    towards = -ball.centre_m / ball.distance_m
    turn = np.arange(_SAMPLES) * (2.0 * np.pi / _SAMPLES)
    across = np.cos(turn)[:, None] * right + np.sin(turn)[:, None] * down
    points = ball.centre_m + ball.radius_m * (np.cos(beta) * towards + np.sin(beta) * across)
    error_rad = float(direction_error(ball, points).mean())
    return Ring(incidence_rad, beta + incidence_rad, error_rad, project(camera, points))


def around(points_px: FloatArray, count: int) -> FloatArray:
    """A closed smooth curve (N, 2) through evenly spread points, at more places (count, 2): by its Fourier series.

    Examples
    --------
    >>> turn = np.arange(16) * (2 * np.pi / 16)
    >>> circle = around(np.stack([np.cos(turn), np.sin(turn)], axis=-1), 360)
    >>> bool(np.allclose(np.hypot(*circle.T), 1.0))
    True
    """
    points = np.asarray(points_px, float)
    wave = np.fft.fft(points[:, 0] + 1j * points[:, 1])
    half = len(points) // 2
    wide = np.concatenate([wave[:half], np.zeros(count - len(points), complex), wave[half:]])
    curve = np.fft.ifft(wide) * (count / len(points))
    return np.stack([curve.real, curve.imag], axis=-1)

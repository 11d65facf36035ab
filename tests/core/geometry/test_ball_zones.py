"""Zones of the ball's picture are where the exact reflection has them, and a text keeps them."""

import numpy as np
import pytest

from spectral_probe.geometry.ball import reflect
from spectral_probe.geometry.ball_zones import SPANS, around, ball_zones
from spectral_probe.geometry.camera import pixel_rays
from spectral_probe.geometry.ellipse import Ellipse
from spectral_probe.geometry.outline_summary import from_text, summary_of, to_text
from spectral_probe.model import BallFit, Camera, Outline

CAMERA = Camera((1800.0, 1790.0), (410.0, 390.0), (800, 800), (0.02, -0.01, 0.0, 0.0, 0.0))
DISTANCE_M, RADIUS_M = 0.6, 0.05


@pytest.fixture
def ball() -> BallFit:
    axis = np.array([0.05, -0.03, 1.0])
    axis /= np.linalg.norm(axis)
    return BallFit(
        axis * DISTANCE_M, RADIUS_M, float(np.arcsin(RADIUS_M / DISTANCE_M)), 0.0, np.eye(3) * 1e-8
    )


def test_rings_lie_where_light_meets_the_ball_at_their_angle(ball):
    rings = ball_zones(CAMERA, ball)
    towards_camera = -ball.centre_m / ball.distance_m
    for ring in rings:
        seen = reflect(ball, pixel_rays(CAMERA, around(ring.points_px, 100)))
        assert seen.hit.all()
        np.testing.assert_allclose(np.arccos(seen.cos_incidence), ring.incidence_rad, atol=2e-4)
        np.testing.assert_allclose(np.arccos(seen.directions @ towards_camera), ring.light_rad, atol=4e-4)
    np.testing.assert_allclose([1 / np.cos(ring.incidence_rad) for ring in rings[1:]], SPANS)
    assert rings[0].light_rad == pytest.approx(np.radians(16.0), abs=1e-4)
    errors = [ring.error_rad for ring in rings]
    assert errors == sorted(errors), "towards the rim a direction is known ever worse"


def test_a_text_keeps_residuals_and_zones():
    ellipse = Ellipse(400.0, 380.0, 151.0, 150.0, 0.4)
    angles = np.radians(np.arange(0.5, 360.0, 2.0))
    residuals = 0.3 * np.sin(3 * angles)
    away = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    points = [ellipse.x, ellipse.y] + (ellipse.radius_at(angles) + residuals)[:, None] * away
    outline = Outline((ellipse.x, ellipse.y), (ellipse.major, ellipse.minor), ellipse.angle_rad, points, 0.2)
    summary = summary_of(outline, CAMERA, RADIUS_M)
    again = from_text(to_text(summary))
    np.testing.assert_allclose(again.residuals_px, residuals, atol=6e-4)
    np.testing.assert_allclose(again.angles_rad, angles, atol=1e-9)
    assert again.cone_angle_rad == pytest.approx(np.arctan(150.5 / 1795), rel=0.02)
    assert len(again.zones) == len(SPANS) + 1
    np.testing.assert_allclose(again.zones[3].points_px, summary.zones[3].points_px, atol=6e-3)
    assert summary_of(outline, None, RADIUS_M).zones == ()


@pytest.mark.parametrize("text", ["", "{", "[]", '{"version": 99}', '{"version": 1}'])
def test_a_text_that_is_none_of_ours_is_an_empty_summary(text):
    assert len(from_text(text).angles_rad) == 0
    assert from_text(text).zones == ()

import numpy as np
import pytest

import spectral_probe.geometry.ball as ball_module
from spectral_probe.errors import OutlineError
from spectral_probe.geometry.ball import find_reflection, fit_ball, reflect
from spectral_probe.geometry.camera import project
from spectral_probe.geometry.outline import outline_from_circle
from spectral_probe.model import BallFit, Camera, Outline

CAMERA = Camera((1200.0, 1180.0), (640.0, 480.0), (1280, 960))


def ball_at(centre, radius):
    centre = np.asarray(centre, float)
    return BallFit(centre, radius, float(np.arcsin(radius / np.linalg.norm(centre))), 0.0)


def rim_points(ball, count=400):
    """Points where rays from the origin graze the sphere, from first principles."""
    distance = np.linalg.norm(ball.centre_m)
    axis = ball.centre_m / distance
    side = np.cross(axis, [0.0, 1.0, 0.3])
    side /= np.linalg.norm(side)
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)[:, None]
    circle_centre = ball.centre_m - axis * ball.radius_m**2 / distance
    circle_radius = ball.radius_m * np.sqrt(1 - (ball.radius_m / distance) ** 2)
    return circle_centre + circle_radius * (np.cos(angle) * side + np.sin(angle) * np.cross(axis, side))


def outline_of(points_px):
    return Outline(tuple(points_px.mean(0)), (1.0, 1.0), 0.0, points_px, 0.0)


@pytest.mark.parametrize("centre", [(0, 0, 1), (0.25, -0.15, 0.9), (0.1, 0.1, 0.3)])
def test_ball_from_its_outline_off_axis(centre):
    ball = ball_at(centre, 0.05)
    fit = fit_ball(CAMERA, outline_of(project(CAMERA, rim_points(ball))), 0.05)
    assert np.abs(fit.centre_m - ball.centre_m).max() < 1e-9
    assert fit.distance_m == pytest.approx(0.05 / np.sin(fit.cone_angle_rad))


def test_a_false_stretch_of_edge_does_not_pull_the_fit():
    ball = ball_at((0.1, 0.05, 0.8), 0.05)
    points = project(CAMERA, rim_points(ball))
    points = points + np.random.default_rng(4).normal(scale=0.1, size=points.shape)
    spoiled = points.copy()
    spoiled[:100] += [0, 6.0]  # a quarter of the rim is the stand's edge
    clean, robust = fit_ball(CAMERA, outline_of(points), 0.05), fit_ball(CAMERA, outline_of(spoiled), 0.05)
    radius_px = CAMERA.focal_px[0] * 0.05 / 0.8
    assert np.linalg.norm(robust.centre_m - clean.centre_m) / 0.05 * radius_px < 1.0


def test_points_that_are_no_cone_are_refused():
    with pytest.raises(OutlineError, match="fewer than three"):
        fit_ball(CAMERA, outline_of(np.array([[1.0, 2.0], [3.0, 4.0]])), 0.05)


def test_reflection_obeys_the_law_of_reflection():
    ball = ball_at((0.1, -0.2, 1.0), 0.15)
    rays = np.random.default_rng(5).normal(ball.centre_m, 0.1, size=(2000, 3))
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    mirrored = reflect(ball, rays)
    hit = mirrored.hit
    assert 0.2 < hit.mean() < 0.999
    points, normals = mirrored.points_m[hit], mirrored.normals[hit]
    assert np.allclose(np.linalg.norm(points - ball.centre_m, axis=-1), ball.radius_m)
    assert np.allclose((mirrored.directions[hit] * normals).sum(-1), mirrored.cos_incidence[hit])
    assert np.allclose((-rays[hit] * normals).sum(-1), mirrored.cos_incidence[hit])
    in_plane = np.einsum("ni,ni->n", np.cross(rays[hit], normals), mirrored.directions[hit])
    assert np.abs(in_plane).max() < 1e-12
    closer = np.linalg.norm(points, axis=-1) < np.linalg.norm(ball.centre_m)
    assert closer.all()  # the near side of the ball, not the far one


@pytest.mark.parametrize("distance", [0.3, 1.0, 20.0])
def test_find_reflection_inverts_reflect(distance):
    ball = ball_at(distance * np.array([0.1, 0.2, 0.97]), 0.1)
    directions = np.random.default_rng(6).normal(size=(5000, 3))
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    points, cosine = find_reflection(ball, directions)
    points = points.astype(float)
    seen = cosine > 0.01
    off_surface = np.linalg.norm(points[seen] - ball.centre_m, axis=-1) / ball.radius_m - 1.0
    assert (
        np.abs(off_surface).max() < 1e-3
    )  # a pixel on a ball of 1000 pixels seen from 200 radii away, and at the rim only
    square = cosine > 0.2  # closer to the rim directions turn ever faster with the place on the ball
    rays = points[square] / np.linalg.norm(points[square], axis=-1, keepdims=True)
    mirrored = reflect(ball, rays)
    error = np.linalg.norm(mirrored.directions - directions[square], axis=-1)
    assert np.degrees(error).max() < 5e-3
    assert np.abs(mirrored.cos_incidence - cosine[square]).max() < 5e-5


def test_the_blind_cone_is_as_wide_as_the_outline():
    ball = ball_at((0.0, 0.0, 0.3), 0.1)
    angle = np.radians(np.linspace(0, 60, 6001))
    behind = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=-1)
    _, cosine = find_reflection(ball, behind)
    first_seen = angle[cosine > 0].min()
    assert first_seen == pytest.approx(ball.cone_angle_rad, abs=np.radians(0.02))


def test_orthographic_unwrap_would_err_by_degrees():
    """The exact geometry matters: at d = 10 r the usual orthographic unwrap errs by up to 5.7 degrees."""
    ball = ball_at((0.0, 0.0, 1.0), 0.1)
    ray = np.array([np.sin(0.0995), 0.0, np.cos(0.0995)])
    exact = reflect(ball, ray).directions
    sine = np.tan(0.0995) / np.tan(ball.cone_angle_rad)
    normal = np.array([sine, 0, -np.sqrt(1 - sine**2)])
    orthographic = np.array([0, 0, 1.0]) - 2 * normal[2] * normal
    assert 3.0 < np.degrees(np.arccos(exact @ orthographic)) < 7.0


# ---------------------------------------------------------------- how well the ball is known


def noisy_fits(points, noise_px, count=200):
    rng = np.random.default_rng(7)
    for _ in range(count):
        moved = points + rng.normal(scale=noise_px, size=points.shape)
        yield fit_ball(CAMERA, Outline((0.0, 0.0), (1.0, 1.0), 0.0, moved, noise_px), 0.05)


@pytest.mark.parametrize("hidden", [0.0, 0.5])
def test_covariance_is_that_of_repeated_measurements(hidden, monkeypatch):
    monkeypatch.setattr(ball_module, "MODEL_ERROR_PX", 0.0)  # of noise alone
    ball = ball_at((0.1, 0.05, 0.8), 0.05)
    points = project(CAMERA, rim_points(ball, 180))
    points = points[: round(len(points) * (1.0 - hidden))]
    fits = list(noisy_fits(points, 0.2))
    axis = ball.centre_m / ball.distance_m
    errors = np.array(
        [[*(fit.axis_tangents @ -axis), fit.cone_angle_rad - ball.cone_angle_rad] for fit in fits]
    )
    measured = np.cov(errors.T)
    stated = np.mean([fit.covariance_rad2 for fit in fits], axis=0)
    # 200 repetitions know a standard deviation to 5 %; the fit leaves out the few points beyond three of them.
    assert np.allclose(np.sqrt(np.diag(stated)), np.sqrt(np.diag(measured)), rtol=0.3)
    assert np.abs(errors.mean(0)).max() < 4 * np.sqrt(np.diag(measured).max() / len(fits))


def test_points_that_err_together_make_the_ball_less_certain(monkeypatch):
    monkeypatch.setattr(ball_module, "MODEL_ERROR_PX", 0.0)
    ball = ball_at((0.1, 0.05, 0.8), 0.05)
    points = project(CAMERA, rim_points(ball, 360))
    rng = np.random.default_rng(8)
    white = rng.normal(size=(360, 2)) * 0.2
    smooth = np.repeat(rng.normal(size=(36, 2)), 10, axis=0) * 0.2
    sigma = [
        np.sqrt(
            fit_ball(CAMERA, Outline((0, 0), (1, 1), 0.0, points + noise, 0.2), 0.05).covariance_rad2[2, 2]
        )
        for noise in (white, smooth)
    ]
    assert 2.0 < sigma[1] / sigma[0] < 5.0  # the square root of ten points in one


def test_what_a_picture_of_the_residuals_needs():
    ball = ball_at((0.1, 0.05, 0.8), 0.05)
    points = project(CAMERA, rim_points(ball, 360))
    middle = points.mean(0)
    points[:20] += 3.0 * (points[:20] - middle) / np.linalg.norm(points[:20] - middle, axis=1, keepdims=True)
    points[20:] += np.random.default_rng(9).normal(scale=0.05, size=(340, 2))
    fit = fit_ball(CAMERA, Outline((0, 0), (1, 1), 0.0, points, 0.1), 0.05)
    assert fit.points_px.shape == (360, 2)
    assert not fit.used[:20].any()
    assert fit.used[20:].mean() > 0.95
    np.testing.assert_allclose(fit.residuals_px[:20], 3.0, atol=0.2)  # outside is positive
    assert np.abs(fit.residuals_px[20:]).max() < 0.3


def test_a_circle_given_by_hand_is_taken_to_be_half_a_pixel_off():
    fit = fit_ball(CAMERA, outline_from_circle(640.0, 480.0, 75.0), 0.05)
    sigma_px = np.sqrt(np.diag(fit.covariance_rad2)) * CAMERA.focal_px[0]
    np.testing.assert_allclose(sigma_px, 0.5, rtol=0.05)

"""Footprints against areas counted on the sphere, direction errors against Monte Carlo."""

import numpy as np
import pytest

from spectral_probe.geometry.ball import reflect
from spectral_probe.geometry.camera import pixel_rays, project
from spectral_probe.geometry.frames import (
    camera_to_world,
    direction_to_equirectangular,
    panorama_solid_angles,
)
from spectral_probe.geometry.sampling import sampling
from spectral_probe.model import BallFit, Camera

CAMERA = Camera((2000.0, 2050.0), (300.0, 280.0), (600, 600))


def ball_at(centre, radius=0.05, covariance=None):
    centre = np.array(centre)
    return BallFit(
        centre,
        radius,
        float(np.arcsin(radius / np.linalg.norm(centre))),
        0.0,
        np.zeros((3, 3)) if covariance is None else covariance,
    )


def at_pixels(view, pixels_px, ball, rotation):
    """Values of both maps where the pixels (N, 2) look."""
    directions = reflect(ball, pixel_rays(CAMERA, pixels_px)).directions @ rotation.T
    height, width = view.footprint_sr.shape
    column, row = (direction_to_equirectangular(directions, height, width) - 0.5).round().astype(int).T
    return view.footprint_sr[row, column % width], view.direction_error_rad[row, column % width]


@pytest.mark.parametrize("centre", [(0.0, 0.0, 0.5), (0.03, -0.04, 0.4)])
def test_footprint_is_the_area_between_neighbouring_pixels(centre):
    ball, rotation = ball_at(centre), camera_to_world(30, 10)
    middle = project(CAMERA, ball.centre_m)
    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    pixels = np.concatenate([middle + radius * ring for radius in (20, 90, 150, 170)])
    step = 0.01
    corner = reflect(ball, pixel_rays(CAMERA, pixels)).directions
    right, down = (
        reflect(ball, pixel_rays(CAMERA, pixels + offset)).directions - corner
        for offset in ([step, 0.0], [0.0, step])
    )
    area = np.linalg.norm(np.cross(right, down), axis=-1) / step**2
    footprint, _ = at_pixels(sampling(CAMERA, ball, rotation), pixels, ball, rotation)
    assert np.abs(footprint / area - 1).max() < 0.06  # a map of 256 columns, read at the nearest


def test_the_footprints_of_all_pixels_make_up_what_is_seen():
    ball = ball_at((0.02, 0.01, 0.5))
    columns, rows = np.meshgrid(np.arange(600) + 0.5, np.arange(600) + 0.5)
    pixels = np.stack([columns, rows], axis=-1).reshape(-1, 2)
    mirrored = reflect(ball, pixel_rays(CAMERA, pixels))
    inner = mirrored.hit & (mirrored.cos_incidence > 0.3)
    footprint, _ = at_pixels(sampling(CAMERA, ball, np.eye(3)), pixels[inner], ball, np.eye(3))
    directions = mirrored.directions[inner]
    facing = np.arccos(np.clip(-directions @ ball.centre_m / ball.distance_m, -1, 1)).max()
    assert footprint.sum() == pytest.approx(2 * np.pi * (1 - np.cos(facing)), rel=0.02)
    assert panorama_solid_angles(8, 16).sum() * 16 == pytest.approx(4 * np.pi)


def test_direction_error_is_that_of_wrong_outlines():
    rng = np.random.default_rng(3)
    spread = np.array([[4.0, 0.5, 0.2], [0.5, 3.0, 0.1], [0.2, 0.1, 1.5]]) * 1e-9
    ball, rotation = ball_at((0.02, -0.01, 0.5), covariance=spread), camera_to_world(200, -20)
    pixels = project(CAMERA, ball.centre_m) + rng.uniform(-125, 125, size=(60, 2))
    rays = pixel_rays(CAMERA, pixels)
    truth = reflect(ball, rays).directions
    axis = ball.centre_m / ball.distance_m
    squares = np.zeros(len(pixels))
    for right, down, wider in rng.multivariate_normal(np.zeros(3), spread, size=600):
        turned = axis + np.array([right, down]) @ ball.axis_tangents
        angle = ball.cone_angle_rad + wider
        wrong = ball_at(turned / np.linalg.norm(turned) * ball.radius_m / np.sin(angle))
        squares += ((reflect(wrong, rays).directions - truth) ** 2).sum(-1)
    _, error = at_pixels(sampling(CAMERA, ball, rotation), pixels, ball, rotation)
    assert np.abs(error / np.sqrt(squares / 600) - 1).max() < 0.15
    assert error.max() > 1.3 * error.min()  # it grows towards the rim


def test_an_exact_outline_has_no_direction_error():
    assert sampling(CAMERA, ball_at((0.0, 0.0, 0.5)), np.eye(3)).direction_error_rad.max() == 0.0

import numpy as np
import pytest

from spectral_probe.geometry import frames


@pytest.fixture
def random_directions():
    directions = np.random.default_rng(1).normal(size=(5000, 3))
    return directions / np.linalg.norm(directions, axis=-1, keepdims=True)


def test_equirectangular_and_back(random_directions):
    pixels = frames.direction_to_equirectangular(random_directions, 512, 1024)
    back = frames.equirectangular_to_direction(pixels, 512, 1024)
    assert np.abs(back - random_directions).max() < 1e-12


def test_bearing_and_back(random_directions):
    back = frames.bearing_to_direction(*frames.direction_to_bearing(random_directions))
    assert np.abs(back - random_directions).max() < 1e-12


def test_equirectangular_is_what_cycles_reads(random_directions):
    x, y, z = random_directions.T
    column, row = frames.direction_to_equirectangular(random_directions, 100, 200).T
    assert np.allclose(column / 200, 0.5 - np.arctan2(y, x) / (2 * np.pi))
    assert np.allclose(1 - row / 100, 0.5 + np.arcsin(z) / np.pi)


@pytest.mark.parametrize(
    ("azimuth", "expected"), [(0, [0, 1, 0]), (90, [1, 0, 0]), (180, [0, -1, 0]), (270, [-1, 0, 0])]
)
def test_azimuth_is_a_compass_bearing(azimuth, expected):
    forward = frames.camera_to_world(azimuth)[:, 2]
    assert np.allclose(forward, expected, atol=1e-12)
    assert np.allclose(forward, frames.bearing_to_direction(azimuth, 0), atol=1e-12)


def test_a_raised_camera_looks_down():
    forward = frames.camera_to_world(0, 30)[:, 2]
    assert np.allclose(forward, [0, np.cos(np.pi / 6), -0.5])


def test_rotations_are_proper_and_angles_come_back():
    rng = np.random.default_rng(2)
    for azimuth, elevation, roll in rng.uniform([0, -80, -170], [360, 80, 170], size=(100, 3)):
        rotation = frames.camera_to_world(azimuth, elevation, roll)
        assert np.allclose(rotation @ rotation.T, np.eye(3))
        assert np.linalg.det(rotation) == pytest.approx(1)
        assert np.allclose(frames.view_angles(rotation), [azimuth, elevation, roll], atol=1e-9)


def test_solid_angles_fill_the_sphere():
    assert frames.panorama_solid_angles(90, 180).sum() * 180 == pytest.approx(4 * np.pi)

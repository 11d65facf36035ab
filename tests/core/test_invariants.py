"""What must hold for any input: geometry and spectra, by hypothesis. A few examples; more with SPECTRAL_PROBE_EXAMPLES=1000."""

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from spectral_probe.files.image_exr import read_channels, write_channels
from spectral_probe.geometry.ball import fit_ball, reflect
from spectral_probe.geometry.camera import pixel_rays, project
from spectral_probe.geometry.frames import (
    bearing_to_direction,
    camera_to_world,
    direction_to_bearing,
    direction_to_equirectangular,
    equirectangular_to_direction,
    panorama_solid_angles,
    view_angles,
)
from spectral_probe.model import BallFit, Camera, Outline
from spectral_probe.spectra.colorimetry import spectra_to_xyz
from spectral_probe.spectra.grid import WAVELENGTHS_NM, resample

examples = settings(
    max_examples=int(os.environ.get("SPECTRAL_PROBE_EXAMPLES", "15")),
    derandomize=True,
    deadline=None,
    database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)


def numbers(least: float, most: float):
    return st.floats(least, most, allow_nan=False, allow_infinity=False)


angles = numbers(0, 359.99)
elevations = numbers(-89, 89)
spectra = st.lists(numbers(0, 1e3), min_size=61, max_size=61).map(np.array)


@st.composite
def balls(draw):
    """A ball before the camera, somewhere in its view."""
    radius, distance = draw(numbers(0.01, 0.3)), draw(numbers(5, 60))
    towards = np.array([draw(numbers(-0.3, 0.3)), draw(numbers(-0.3, 0.3)), 1.0])
    centre = towards / np.linalg.norm(towards) * distance * radius
    return BallFit(centre, radius, float(np.arcsin(1 / distance)), 0.0)


def rays_at(ball: BallFit, reach: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Unit rays (N, 3) that meet the ball, `reach` (N,) of the way from its middle to its rim."""
    axis = ball.centre_m / np.linalg.norm(ball.centre_m)
    one = np.cross(axis, [0.0, 1.0, 0.0])
    one /= np.linalg.norm(one)
    other = np.cross(axis, one)
    angle = ball.cone_angle_rad * reach[:, None]
    around = np.cos(turn)[:, None] * one + np.sin(turn)[:, None] * other
    return np.cos(angle) * axis + np.sin(angle) * around


@examples
@given(angles, elevations, numbers(-179, 179))
def test_camera_rotations_are_proper_and_come_back(azimuth, elevation, roll):
    rotation = camera_to_world(azimuth, elevation, roll)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    found = view_angles(rotation)
    np.testing.assert_allclose(camera_to_world(*found), rotation, atol=1e-9)


@examples
@given(angles, elevations)
def test_bearings_and_directions_are_inverse(azimuth, elevation):
    direction = bearing_to_direction(azimuth, elevation)
    np.testing.assert_allclose(np.linalg.norm(direction), 1, atol=1e-12)
    np.testing.assert_allclose(bearing_to_direction(*direction_to_bearing(direction)), direction, atol=1e-12)


@examples
@given(st.integers(1, 4096), numbers(0, 1), numbers(0.001, 0.999))
def test_texels_and_directions_are_inverse(height, across, down):
    point = np.array([across * 2 * height % (2 * height), down * height])
    direction = equirectangular_to_direction(point, height, 2 * height)
    found = direction_to_equirectangular(direction, height, 2 * height)
    np.testing.assert_allclose(equirectangular_to_direction(found, height, 2 * height), direction, atol=1e-9)


@examples
@given(st.integers(1, 3000), st.integers(1, 3000))
def test_solid_angles_fill_the_sphere(height, width):
    assert panorama_solid_angles(height, width).sum() * width == pytest.approx(4 * np.pi, rel=1e-9)


@examples
@given(
    st.tuples(*[numbers(-0.08, 0.08)] * 2),
    st.tuples(*[numbers(-0.003, 0.003)] * 2),
    numbers(500, 6000),
    st.integers(0, 99),
)
def test_distortion_and_its_inverse(radial, tangential, focal, seed):
    camera = Camera((focal, 1.02 * focal), (400.0, 300.0), (800, 600), (*radial, *tangential, 0.0))
    points = np.random.default_rng(seed).uniform([0, 0], [800, 600], (50, 2))
    np.testing.assert_allclose(project(camera, pixel_rays(camera, points)), points, atol=1e-3)


@examples
@given(balls(), st.integers(0, 9999))
def test_reflection_obeys_its_law(ball, seed):
    """The surface's normal halves the angle between ray and reflection; the incidence is the angle to it."""
    random = np.random.default_rng(seed)
    rays = rays_at(ball, random.uniform(0, 0.98, 40), random.uniform(0, 2 * np.pi, 40))
    found = reflect(ball, rays)
    assert found.hit.all()
    normal = found.directions - rays
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    np.testing.assert_allclose(np.linalg.norm(found.directions, axis=-1), 1, atol=1e-9)
    np.testing.assert_allclose(-(normal * rays).sum(-1), found.cos_incidence, atol=1e-6)
    # The normal's line through the point of the surface passes the centre.
    middle = ball.centre_m
    along = (rays * middle).sum(-1)
    point = rays * (along - np.sqrt(along**2 - middle @ middle + ball.radius_m**2))[:, None]
    np.testing.assert_allclose((point - middle) / ball.radius_m, normal, atol=1e-5)


@examples
@given(balls(), angles, elevations, st.integers(0, 9999))
def test_reflection_turns_with_everything(ball, azimuth, elevation, seed):
    random = np.random.default_rng(seed)
    rays = rays_at(ball, random.uniform(0, 0.95, 20), random.uniform(0, 2 * np.pi, 20))
    turn = camera_to_world(azimuth, elevation, 17.0)
    turned = BallFit(turn @ ball.centre_m, ball.radius_m, ball.cone_angle_rad, 0.0)
    np.testing.assert_allclose(
        reflect(turned, rays @ turn.T).directions, reflect(ball, rays).directions @ turn.T, atol=1e-6
    )


@examples
@given(balls(), numbers(800, 6000))
def test_the_outline_gives_back_where_the_ball_is(ball, focal):
    camera = Camera((focal, focal), (0.0, 0.0), (4000, 4000))
    turn = np.linspace(0, 2 * np.pi, 181)[:-1]
    points = project(camera, rays_at(ball, np.ones(180), turn))
    half = float(np.ptp(points[:, 0]) / 2)
    outline = Outline(tuple(points.mean(0)), (half, half), 0.0, points, 0.0)
    found = fit_ball(camera, outline, ball.radius_m)
    np.testing.assert_allclose(found.centre_m, ball.centre_m, rtol=1e-4, atol=1e-5)


@examples
@given(spectra, spectra, numbers(-5, 5))
def test_tristimulus_values_are_linear_in_radiance(one, other, factor):
    together = spectra_to_xyz(one + factor * other)
    np.testing.assert_allclose(
        together, spectra_to_xyz(one) + factor * spectra_to_xyz(other), rtol=1e-9, atol=1e-6
    )


@examples
@given(st.lists(numbers(380, 780), min_size=5, max_size=40, unique=True), numbers(0.01, 100))
def test_resampling_preserves_constants(between, level):
    nm = np.unique(np.round([*between, *np.arange(380.0, 781.0, 20.0)], 1))
    found = resample(nm, np.full(len(nm), level), WAVELENGTHS_NM, name="a constant")
    np.testing.assert_allclose(found, level, rtol=1e-9)


@examples
@given(
    st.lists(st.text("abcXYZ019 ._", min_size=1, max_size=20), min_size=1, max_size=5, unique=True),
    st.tuples(st.integers(1, 40), st.integers(1, 40)),
    st.sampled_from([np.float16, np.float32, np.uint32]),
    st.integers(0, 99),
)
def test_channels_come_back_to_the_bit(tmp_path: Path, names, shape, kind, seed):
    random = np.random.default_rng(seed)
    written = {name: (100 * random.normal(size=shape)).__abs__().astype(kind) for name in names}
    write_channels(tmp_path / "a.exr", written)
    found, _ = read_channels(tmp_path / "a.exr")
    assert set(found) == set(written)
    for name, plane in written.items():
        np.testing.assert_array_equal(found[name], plane)

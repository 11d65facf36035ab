"""What must hold for any input: geometry and spectra, by hypothesis. A few examples; more with SPECTRAL_PROBE_EXAMPLES=1000."""

from functools import cache

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

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
from spectral_probe.render.light_samples import LightSamples, Picture, largest_error
from spectral_probe.render.quadrature import fitted_quadrature
from spectral_probe.spectra.camera import camera_sensitivities
from spectral_probe.spectra.colorimetry import spectra_to_xyz
from spectral_probe.spectra.grid import STEP_NM, WAVELENGTHS_NM, resample
from spectral_probe.spectra.library import FAMILIES
from spectral_probe.spectra.recovery import spectral_recovery


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


@given(angles, elevations, numbers(-179, 179))
def test_camera_rotations_are_proper_and_come_back(azimuth, elevation, roll):
    rotation = camera_to_world(azimuth, elevation, roll)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    found = view_angles(rotation)
    np.testing.assert_allclose(camera_to_world(*found), rotation, atol=1e-9)


@given(angles, elevations)
def test_bearings_and_directions_are_inverse(azimuth, elevation):
    direction = bearing_to_direction(azimuth, elevation)
    np.testing.assert_allclose(np.linalg.norm(direction), 1, atol=1e-12)
    np.testing.assert_allclose(bearing_to_direction(*direction_to_bearing(direction)), direction, atol=1e-12)


@given(st.integers(1, 4096), numbers(0, 1), numbers(0.001, 0.999))
def test_texels_and_directions_are_inverse(height, across, down):
    point = np.array([across * 2 * height % (2 * height), down * height])
    direction = equirectangular_to_direction(point, height, 2 * height)
    found = direction_to_equirectangular(direction, height, 2 * height)
    np.testing.assert_allclose(equirectangular_to_direction(found, height, 2 * height), direction, atol=1e-9)


@given(st.integers(1, 3000), st.integers(1, 3000))
def test_solid_angles_fill_the_sphere(height, width):
    assert panorama_solid_angles(height, width).sum() * width == pytest.approx(4 * np.pi, rel=1e-9)


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


@given(balls(), angles, elevations, st.integers(0, 9999))
def test_reflection_turns_with_everything(ball, azimuth, elevation, seed):
    random = np.random.default_rng(seed)
    rays = rays_at(ball, random.uniform(0, 0.95, 20), random.uniform(0, 2 * np.pi, 20))
    turn = camera_to_world(azimuth, elevation, 17.0)
    turned = BallFit(turn @ ball.centre_m, ball.radius_m, ball.cone_angle_rad, 0.0)
    np.testing.assert_allclose(
        reflect(turned, rays @ turn.T).directions, reflect(ball, rays).directions @ turn.T, atol=1e-6
    )


@given(balls(), numbers(800, 6000))
def test_the_outline_gives_back_where_the_ball_is(ball, focal):
    camera = Camera((focal, focal), (0.0, 0.0), (4000, 4000))
    turn = np.linspace(0, 2 * np.pi, 181)[:-1]
    points = project(camera, rays_at(ball, np.ones(180), turn))
    half = float(np.ptp(points[:, 0]) / 2)
    outline = Outline(tuple(points.mean(0)), (half, half), 0.0, points, 0.0)
    found = fit_ball(camera, outline, ball.radius_m)
    np.testing.assert_allclose(found.centre_m, ball.centre_m, rtol=1e-4, atol=1e-5)


@given(spectra, spectra, numbers(-5, 5))
def test_tristimulus_values_are_linear_in_radiance(one, other, factor):
    together = spectra_to_xyz(one + factor * other)
    np.testing.assert_allclose(
        together, spectra_to_xyz(one) + factor * spectra_to_xyz(other), rtol=1e-9, atol=1e-6
    )


@given(st.lists(numbers(380, 780), min_size=5, max_size=40, unique=True), numbers(0.01, 100))
def test_resampling_preserves_constants(between, level):
    nm = np.unique(np.round([*between, *np.arange(380.0, 781.0, 20.0)], 1))
    found = resample(nm, np.full(len(nm), level), WAVELENGTHS_NM, name="a constant")
    np.testing.assert_allclose(found, level, rtol=1e-9)


@cache
def recovery_of(families):
    return spectral_recovery(camera_sensitivities("Nikon 5100 (NPL)"), families)


recoveries = st.lists(st.sampled_from(list(FAMILIES)), min_size=1, max_size=3, unique=True).map(
    lambda names: recovery_of(tuple(sorted(names)))
)


@given(recoveries, st.integers(0, 9999), numbers(-12, 12))
def test_recovered_light_scales_with_the_responses(recovery, seed, exponent):
    responses = np.random.default_rng(seed).uniform(0.01, 1, (50, 3)).astype(np.float32)
    factor = np.float32(2.0**exponent)
    one, scaled = recovery.recover(responses), recovery.recover(factor * responses)
    np.testing.assert_array_equal(scaled.basis_index, one.basis_index)
    np.testing.assert_allclose(scaled.confidence, one.confidence, atol=1e-3)
    sizes = np.abs(one.weights).max(-1, keepdims=True)
    np.testing.assert_allclose(scaled.weights / factor / sizes, one.weights / sizes, atol=1e-3)


@given(recoveries, st.integers(0, 9999))
def test_recovered_light_has_no_negative_power(recovery, seed):
    """Whatever the camera saw, colours that no light has among it; and no light where it saw none."""
    responses = np.random.default_rng(seed).uniform(-0.05, 1, (50, 3)) ** 3
    found = recovery.recover(np.append(responses, np.zeros((1, 3)), 0))
    light = np.einsum("nk,nkl->nl", found.weights, recovery.bases[found.basis_index])
    assert np.isfinite(light).all()
    assert light.min() >= -1e-6 * light.max()
    assert not light[-1].any()
    assert (found.confidence >= 0).all()
    assert (found.confidence <= 1).all()


@given(recoveries, st.integers(0, 9999))
def test_recovered_light_gives_the_responses_again(recovery, seed):
    """For light of its own kinds: as bright as the camera saw it."""
    random = np.random.default_rng(seed)
    lights = np.concatenate(
        [random.uniform(0, 1, (20, len(basis))) @ np.abs(basis) for basis in recovery.bases]
    )
    responses = lights @ recovery.sensitivities * STEP_NM
    found = recovery.recover(responses)
    again = (
        np.einsum("nk,nkl->nl", found.weights, recovery.bases[found.basis_index])
        @ recovery.sensitivities
        * STEP_NM
    )
    level = (again * responses).sum(-1) / (responses**2).sum(-1)
    np.testing.assert_allclose(level, 1, atol=0.25)


def pictures(seed):
    """Pixels of a diffuse scene: mixtures of three random lights on random surfaces."""
    random = np.random.default_rng(seed)

    def bumps(count, least_nm):
        centres, widths = random.uniform(400, 700, (count, 1)), random.uniform(least_nm, 200, (count, 1))
        return 0.05 + np.exp(-(((WAVELENGTHS_NM - centres) / widths) ** 2))

    lights = random.dirichlet(np.ones(3), 100) @ bumps(3, 60)
    transports = bumps(8, 60)[random.integers(0, 8, 100)][None]
    nothing_held = np.zeros((100, 1, 3))
    return tuple(
        Picture(transports[:, part], (LightSamples(lights[part], nothing_held[part]),))
        for part in (slice(60), slice(60, 100))
    )


@settings(max_examples=2, phases=[Phase.generate])  # dear
@given(st.integers(0, 9999), numbers(2, 4))
def test_a_quadrature_keeps_its_bound(seed, bound):
    """On the pixels held out; its wavelengths are each taken once, and its shares of samples are one render's."""
    training, held_out = pictures(seed)
    plan = fitted_quadrature(training, held_out, bound, 10)
    assert plan is not None
    index = np.searchsorted(WAVELENGTHS_NM, plan.wavelengths_nm)
    assert len(np.unique(index)) == index.size
    assert plan.sample_shares.sum() == pytest.approx(1)
    spectra = np.einsum("npc,pcl->nl", held_out.spectra[:, index], plan.reconstruction)
    errors = held_out.errors(spectra_to_xyz(spectra))
    assert largest_error(errors) <= bound
    assert plan.predicted_de2000 == pytest.approx((errors.mean(), largest_error(errors)))

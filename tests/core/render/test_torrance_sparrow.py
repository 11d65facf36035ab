"""Eq. 12 integrated over a panorama: against closed forms, against reciprocity and for what it must refuse."""

import numpy as np
import pytest

from spectral_probe.errors import RenderError
from spectral_probe.geometry.frames import (
    bearing_to_direction,
    direction_to_equirectangular,
    panorama_directions,
    panorama_solid_angles,
)
from spectral_probe.model import SpectralPanorama
from spectral_probe.render.beckmann import (
    STEEPEST_ALPHA,
    WIDEST_GAMMA_RAD,
    beckmann_alpha,
    beckmann_distribution,
)
from spectral_probe.render.torrance_sparrow import (
    TorranceSparrowSurface,
    groove_shadowing,
    reflected_radiance,
    sphere_image,
)
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.metals import metal_reflectance

UP = np.array([0.0, 0.0, 1.0])
SPECTRUM = np.linspace(1.0, 3.0, 61)


def panorama(weights, bases=SPECTRUM, index=None):
    weights = np.asarray(weights, np.float32)
    return SpectralPanorama(
        weights=weights,
        bases=np.asarray(bases, float).reshape(-1, weights.shape[-1], 61),
        basis_index=np.zeros(weights.shape[:2], np.uint8) if index is None else index,
        wavelengths_nm=WAVELENGTHS_NM,
        valid=np.ones(weights.shape[:2], bool),
        confidence=np.ones(weights.shape[:2], np.float32),
    )


def one_texel(azimuth_deg, elevation_deg, height=180):
    """Light from a texel at about a bearing; also its direction and irradiance across its rays."""
    towards = bearing_to_direction(azimuth_deg, elevation_deg)
    column, row = direction_to_equirectangular(towards, height, 2 * height).astype(int)
    weights = np.zeros((height, 2 * height, 1))
    weights[row, column] = 1.0
    direction = panorama_directions(height, 2 * height)[row, column]
    return panorama(weights), direction, panorama_solid_angles(height, 2 * height)[row, 0] * SPECTRUM


def test_a_diffuse_surface_in_equal_light_has_its_albedo():
    reflectance = np.linspace(0.2, 0.8, 61)
    surface = TorranceSparrowSurface(1.0 / np.pi, 0.0, 0.0, 0.1, reflectance=reflectance)
    generator = np.random.default_rng(1)
    normals = generator.normal(size=(5, 3))
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    reflected = reflected_radiance(panorama(np.ones((64, 128, 1))), surface, normals, normals)
    np.testing.assert_allclose(reflected, np.tile(reflectance * SPECTRUM, (5, 1)), rtol=2e-3)


def test_the_mirror_term_is_fresnel_times_the_light_that_is_mirrored():
    light, direction, _ = one_texel(70.0, 30.0)
    view = bearing_to_direction(-40.0, 50.0)
    normal = direction + view
    normal /= np.linalg.norm(normal)
    surface = TorranceSparrowSurface.metal("Au", beta_mirror=0.7, gamma_rad=0.1)
    expected = 0.7 * metal_reflectance("Au", normal @ view) * SPECTRUM
    np.testing.assert_allclose(reflected_radiance(light, surface, normal, view), expected, rtol=1e-6)


@pytest.mark.parametrize("denominator", ["reflection", "incidence"])
def test_the_lobe_of_one_lamp_is_eq_12_itself(denominator):
    """Every factor by hand for one direction of light, as the equation says."""
    light, towards, irradiance = one_texel(30.0, 40.0)
    view = bearing_to_direction(190.0, 65.0)
    gamma = np.radians(15.0)
    metal = TorranceSparrowSurface.metal("Cu", beta=2.0, gamma_rad=gamma)
    surface = TorranceSparrowSurface(0.0, 2.0, 0.0, gamma, n=metal.n, k=metal.k, denominator=denominator)
    half = (towards + view) / np.linalg.norm(towards + view)
    phi = np.arccos(half[2])
    shadowing = min(1.0, 2 * half[2] * view[2] / (half @ view), 2 * half[2] * towards[2] / (half @ view))
    divisor = view[2] if denominator == "reflection" else towards[2]
    fresnel = metal_reflectance("Cu", np.array(half @ view))
    expected = 2.0 * np.exp(-np.log(2) * (phi / gamma) ** 2) * shadowing * fresnel / divisor * irradiance
    np.testing.assert_allclose(reflected_radiance(light, surface, UP, view), expected, rtol=1e-3)


def test_only_the_corrected_denominator_is_reciprocal():
    """Light and eye exchanged: radiance per irradiance on the surface stays, as printed it does not."""
    lamps = [one_texel(0.0, 25.0), one_texel(140.0, 70.0)]
    ratios = {}
    for denominator in ("reflection", "incidence"):
        surface = TorranceSparrowSurface(0.0, 1.0, 0.0, 0.4, denominator=denominator)
        values = []
        for (light, towards, irradiance), (_, view, _) in (lamps, lamps[::-1]):
            values.append(reflected_radiance(light, surface, UP, view)[30] / (irradiance[30] * towards[2]))
        ratios[denominator] = values[0] / values[1]
    assert ratios["reflection"] == pytest.approx(1.0, abs=0.01)
    assert abs(ratios["incidence"] - 1.0) > 0.5


def test_the_panoramas_size_does_not_matter():
    """A smooth light in 24 and in 384 rows, summed by interpolating and by averaging."""
    surface = TorranceSparrowSurface.metal(
        "Au", alpha=0.1, beta=3.0, beta_mirror=0.2, gamma_rad=np.radians(6.0)
    )
    results = []
    for height in (24, 384):
        rows, columns = np.mgrid[:height, : 2 * height] / height
        weights = 1.2 + np.cos(np.pi * rows) * np.cos(np.pi * columns)
        normal, view = bearing_to_direction(20.0, 30.0), bearing_to_direction(60.0, 50.0)
        results.append(reflected_radiance(panorama(weights[..., None]), surface, normal, view))
    np.testing.assert_allclose(results[0], results[1], rtol=0.01)


def test_each_texel_has_its_own_basis():
    bases = np.stack([SPECTRUM, SPECTRUM[::-1]])[:, None]
    index = np.zeros((32, 64), np.uint8)
    index[:16] = 1
    light = panorama(np.ones((32, 64, 1)), bases, index)
    surface = TorranceSparrowSurface(0.0, 0.0, 1.0, 0.1)
    np.testing.assert_allclose(reflected_radiance(light, surface, UP, UP), SPECTRUM[::-1])
    np.testing.assert_allclose(reflected_radiance(light, surface, -UP, -UP), SPECTRUM)


def test_from_behind_nothing_is_seen():
    surface = TorranceSparrowSurface(1.0, 1.0, 1.0, 0.1)
    assert not reflected_radiance(panorama(np.ones((16, 32, 1))), surface, UP, -UP).any()


def test_a_ball_mirrors_the_world_behind_the_camera():
    """The camera looks along +Y: the middle of the ball shows -Y, its right rim +Y round the right side."""
    weights = np.zeros((64, 128, 1))
    weights[:, 64 + 32 :] = 1.0  # u in 0.75..1: from -Y to -X
    ball = sphere_image(panorama(weights), TorranceSparrowSurface(0.0, 0.0, 1.0, 0.1), 32)
    assert ball.radiance.shape == (32, 32, 61)
    assert ball.coverage.sum() / 32**2 == pytest.approx(np.pi / 4, abs=0.01)
    assert ball.radiance[16, 10, 30] > 0.9
    assert ball.radiance[16, 22, 30] == 0.0
    assert not ball.radiance[0, 0].any()


def test_grooves_shadow_only_what_is_seen_or_lit_aslant():
    assert groove_shadowing(np.array(1.0), np.array(0.9), np.array(0.9), np.array(0.9)) == 1.0
    assert groove_shadowing(np.array(0.5), np.array(0.8), np.array(0.2), np.array(0.8)) == pytest.approx(0.25)


@pytest.mark.parametrize("gamma_deg", [1.0, 3.0, 10.0, 25.0, 45.0])
def test_the_beckmann_lobe_has_the_papers_half_width(gamma_deg):
    fit = beckmann_alpha(np.radians(gamma_deg))
    assert beckmann_distribution(np.cos(np.radians(gamma_deg)), fit.alpha) == pytest.approx(0.5)
    assert fit.half_width_rad == pytest.approx(np.radians(gamma_deg))
    if gamma_deg <= 10.0:
        assert fit.alpha == pytest.approx(np.tan(np.radians(gamma_deg)) / np.sqrt(np.log(2)), rel=0.05)
        assert fit.residual < 0.03


def test_a_lobe_wider_than_beckmanns_is_fitted_and_says_how_badly():
    fit = beckmann_alpha(np.radians(60.0))
    assert fit.alpha <= STEEPEST_ALPHA
    assert fit.half_width_rad > WIDEST_GAMMA_RAD
    assert 0.2 < fit.residual < 0.5
    assert fit.residual > beckmann_alpha(WIDEST_GAMMA_RAD).residual


def test_what_is_no_surface_is_refused():
    with pytest.raises(RenderError, match="gamma"):
        TorranceSparrowSurface(1.0, 1.0, 1.0, 0.0)
    with pytest.raises(RenderError, match="negative"):
        TorranceSparrowSurface(-1.0, 1.0, 1.0, 0.1)
    with pytest.raises(RenderError, match="gamma"):
        beckmann_alpha(2.0)

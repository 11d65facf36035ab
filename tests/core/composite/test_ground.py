"""The ground's reflectance is what makes it look as in the plate."""

from pathlib import Path

import numpy as np
import pytest

from spectral_probe.composite.ground import (
    MOST_REFLECTED,
    faded,
    ground_distance,
    ground_reflectance,
    irradiance,
)
from spectral_probe.composite_model import Backplate
from spectral_probe.geometry.frames import camera_to_world, panorama_directions
from spectral_probe.model import Camera, FloatArray, SpectralPanorama
from spectral_probe.spectra.camera import camera_sensitivities
from spectral_probe.spectra.colorimetry import illuminant
from spectral_probe.spectra.grid import STEP_NM, WAVELENGTHS_NM
from spectral_probe.spectra.uplift import uplift

CAMERA = camera_sensitivities("Nikon 5100 (NPL)")


@pytest.fixture
def panorama() -> SpectralPanorama:
    """Daylight from above, brightest in the zenith; lamplight from the west; no light from below, which the ground cannot see."""
    up = panorama_directions(64, 128)
    weights = np.stack([np.maximum(up[..., 2], 0.0) ** 2, (up[..., 0] < -0.7) & (up[..., 2] > 0)], -1)
    below = up[..., 2] < 0
    weights[below] = 50.0
    return SpectralPanorama(
        weights.astype(np.float32),
        np.stack([illuminant("D65"), illuminant("A")])[None],
        np.zeros((64, 128), np.uint8),
        WAVELENGTHS_NM,
        np.ones((64, 128), bool),
        np.ones((64, 128), np.float32),
    )


@pytest.fixture
def backplate() -> Backplate:
    camera = Camera((60.0, 60.0), (32.0, 24.0), (64, 48))
    position = np.array([0.0, -0.8, 0.6])
    return Backplate(camera, camera_to_world(0.0, 35.0), position, Path(), (64, 48), (0.0, 0.0, 64, 48))


def seen(panorama: SpectralPanorama, rgb: FloatArray) -> FloatArray:
    """What the camera sees of matt ground of a reflectance: spectra, wavelength by wavelength."""
    return uplift(rgb) * irradiance(panorama) / np.pi @ CAMERA * STEP_NM


def test_irradiance_is_the_cosine_weighted_integral(panorama: SpectralPanorama) -> None:
    directions = np.random.default_rng(0).standard_normal((400_000, 3))
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    up = directions[:, 2] > 0
    day = 4 * np.pi * np.where(up, directions[:, 2] ** 3, 0.0).mean()
    west = 4 * np.pi * np.where(up & (directions[:, 0] < -0.7), directions[:, 2], 0.0).mean()
    expected = day * illuminant("D65") + west * illuminant("A")
    np.testing.assert_allclose(irradiance(panorama), expected, rtol=0.02)


def test_reflectances_of_the_ground_are_recovered(panorama: SpectralPanorama, backplate: Backplate) -> None:
    rgb = np.random.default_rng(1).uniform(0.05, 0.85, (48, 64, 3))
    found = ground_reflectance(seen(panorama, rgb), backplate, panorama, CAMERA, 0.3)
    np.testing.assert_allclose(found.pixels, rgb, atol=1e-4)
    close = ground_distance(backplate) < 0.3
    np.testing.assert_allclose(found.mean, rgb[close].mean(0), atol=0.05)


def test_what_shines_is_limited_and_counted(panorama: SpectralPanorama, backplate: Backplate) -> None:
    rgb = np.full((48, 64, 3), (1.4, 1.0, 0.7))
    found = ground_reflectance(seen(panorama, rgb), backplate, panorama, CAMERA, 0.3)
    np.testing.assert_allclose(found.unlimited_mean, (1.4, 1.0, 0.7), atol=1e-3)
    np.testing.assert_allclose(found.mean, np.array([1.4, 1.0, 0.7]) * MOST_REFLECTED / 1.4, atol=1e-3)


def test_highlights_are_no_part_of_the_mean(panorama: SpectralPanorama, backplate: Backplate) -> None:
    rgb = np.full((48, 64, 3), 0.2)
    plate = seen(panorama, rgb)
    plate[20:24, 30:34] *= 30.0
    valid = np.ones((48, 64), bool)
    valid[26:28, 30:34] = False
    plate[26:28, 30:34] *= 3.0
    found = ground_reflectance(plate, backplate, panorama, CAMERA, 0.5, valid)
    np.testing.assert_allclose(found.mean, 0.2, atol=1e-3)


def test_distances_on_the_ground(backplate: Backplate) -> None:
    distance = ground_distance(backplate)
    rows, columns = np.unravel_index(np.argmin(distance), distance.shape)
    local = -backplate.position_m @ backplate.rotation
    expected = local[:2] / local[2] * 60.0 + backplate.camera.principal_px
    np.testing.assert_allclose([columns + 0.5, rows + 0.5], expected, atol=0.8)
    level = Backplate(
        backplate.camera,
        camera_to_world(0.0, 0.0),
        backplate.position_m,
        Path(),
        (64, 48),
        backplate.frame_px,
    )
    assert np.isinf(ground_distance(level)[:24]).all()


def test_the_reflectance_fades_to_its_mean_at_the_border(
    panorama: SpectralPanorama, backplate: Backplate
) -> None:
    found = ground_reflectance(seen(panorama, np.full((48, 64, 3), 0.3)), backplate, panorama, CAMERA, 0.3)
    alpha = faded(found, 6)[..., 3]
    assert alpha[24, 32] == 1.0
    assert alpha[24, 0] == 0.0
    assert np.all(np.diff(alpha[24, :8]) >= 0)

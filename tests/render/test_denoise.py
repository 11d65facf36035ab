"""The assembled image denoised once: less noise, same light, scene untouched."""

import bpy
import numpy as np
import pytest


@pytest.fixture
def denoise(extension):
    return extension("operators.bridge.denoise")


def names():
    """Everything a denoising could leave behind."""
    kinds = ("scenes", "images", "node_groups", "worlds", "objects", "materials")
    return {kind: sorted(block.name for block in getattr(bpy.data, kind)) for kind in kinds}


@pytest.mark.parametrize("guided", [True, False])
def test_noise_goes_and_light_stays(scene, denoise, guided):
    truth = np.full((48, 72, 3), 0.2, np.float32)
    truth[:, 36:] = [2.0, 1.0, 0.5]
    noisy = truth * np.random.default_rng(0).gamma(16, 1 / 16, (48, 72, 1)).astype(np.float32)
    guide = np.zeros((48, 72, 7), np.float32)
    guide[..., :3], guide[..., 5] = truth / 2, 1.0
    before = names()
    result = denoise.denoised(noisy, guide if guided else None)
    assert result.shape == truth.shape
    assert np.abs(result / truth - 1).mean() < 0.5 * np.abs(noisy / truth - 1).mean()
    for half in (slice(0, 30), slice(42, 72)):  # which side is which, and how much light
        np.testing.assert_allclose(result[:, half].mean((0, 1)), truth[0, half.start], rtol=0.03)
    assert names() == before
    assert bpy.context.scene == scene


@pytest.mark.usefixtures("scene")
def test_up_stays_up(denoise):
    image = np.full((40, 40, 3), 0.1, np.float32)
    image[:10] = 1.0
    result = denoise.denoised(image)
    assert result[:5].mean() > 0.9
    assert result[-5:].mean() < 0.15

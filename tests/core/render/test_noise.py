"""Noise of luminance and of colour told apart."""

import numpy as np
import pytest

from spectral_probe.errors import FileFormatError
from spectral_probe.render.noise import noise
from spectral_probe.spectra.colorimetry import white_xyz

RNG = np.random.default_rng(0)
CONVERGED = RNG.uniform(0.2, 1.0, (60, 80, 3))


def test_noise_of_luminance_is_its_relative_deviation() -> None:
    measured = noise(CONVERGED * (1 + 0.1 * RNG.standard_normal((60, 80, 1))), CONVERGED)
    assert measured.luminance_rms == pytest.approx(0.1, rel=0.05)
    assert measured.chroma_p95 == pytest.approx(0.0, abs=1e-12)


def test_noise_of_colour_leaves_luminance_alone() -> None:
    shift = 0.05 * RNG.standard_normal((60, 80, 2))
    noisy = CONVERGED.copy()
    noisy[..., [0, 2]] += CONVERGED[..., 1:2] * shift * white_xyz()[[0, 2]]
    measured = noise(noisy, CONVERGED)
    assert measured.luminance_rms == pytest.approx(0.0, abs=1e-12)
    assert measured.chroma_rms == pytest.approx(0.05 * np.sqrt(2), rel=0.05)
    assert measured.chroma_p95 == pytest.approx(np.percentile(np.linalg.norm(shift, axis=-1), 95), rel=1e-6)


def test_dark_pixels_do_not_count() -> None:
    converged = CONVERGED.copy()
    converged[:5] = 1e-6
    noisy = converged.copy()
    noisy[:5] = 1.0
    assert noise(noisy, converged).luminance_rms == 0.0


def test_unfit_images_are_refused() -> None:
    with pytest.raises(FileFormatError, match="size"):
        noise(CONVERGED, CONVERGED[:5])
    with pytest.raises(FileFormatError, match="black"):
        noise(CONVERGED * 0, CONVERGED * 0)

"""Noise taken out of the ratios between channels, nothing else."""

import numpy as np
import pytest

from spectral_probe.spectra import chromaticity_noise
from spectral_probe.spectra.chromaticity_noise import without_chromaticity_noise

WINDOW, WALL = np.array([3.0, 5.0, 4.0]), np.array([0.06, 0.05, 0.03])


def room(width=512):
    """A window in a wall, (H, W, 3), and where it is."""
    picture = np.tile(WALL, (width // 2, width, 1))
    inside = np.zeros(picture.shape[:2], bool)
    inside[width // 6 : width // 4, width // 3 : width // 2] = True
    picture[inside] = WINDOW
    return picture, inside


def noisy(truth, relative):
    deviation = relative * truth
    return truth + deviation * np.random.default_rng(5).standard_normal(truth.shape), deviation**2


def ratio_error(picture, truth, where):
    ratios = [values[where][:, [0, 2]] / values[where][:, 1:2] for values in (picture, truth)]
    return float(np.std(ratios[0] / ratios[1] - 1))


@pytest.mark.parametrize("largest", [512, 256])
def test_noise_of_the_ratios_goes_and_their_sum_stays(largest, monkeypatch):
    monkeypatch.setattr(
        chromaticity_noise, "_LARGEST_WIDTH", largest
    )  # a finer panorama takes over what is alike
    truth, inside = room()
    seen, variance = noisy(truth, 0.015)
    filtered = without_chromaticity_noise(seen, variance)
    for where in (inside, ~inside):
        assert ratio_error(filtered, truth, where) < 0.7 * ratio_error(seen, truth, where)
    assert filtered.sum(-1) == pytest.approx(seen.sum(-1), rel=1e-4)


def test_edges_do_not_bleed():
    truth, inside = room()
    filtered = without_chromaticity_noise(*noisy(truth, 0.01))
    beside = inside.copy()
    beside[1:-1, 1:-1] ^= inside[:-2, 1:-1] & inside[2:, 1:-1] & inside[1:-1, :-2] & inside[1:-1, 2:]
    assert ratio_error(filtered, truth, beside) < 0.02


def test_what_is_no_noise_is_left_alone():
    """Photographs without noise keep a fine pattern of colours to a thousandth."""
    rng = np.random.default_rng(2)
    pattern = 1.0 + 0.05 * rng.standard_normal((128, 256, 3))
    quiet = without_chromaticity_noise(pattern, np.full(pattern.shape, 1e-8))
    assert np.abs(quiet / pattern - 1).max() < 1e-3


def test_dark_and_negative_responses_are_no_trouble():
    picture = np.random.default_rng(1).normal(0, 1e-3, (64, 128, 3))
    filtered = without_chromaticity_noise(picture, np.full(picture.shape, 1e-6))
    assert np.isfinite(filtered).all()
    assert np.isfinite(without_chromaticity_noise(0 * picture, 0 * picture)).all()

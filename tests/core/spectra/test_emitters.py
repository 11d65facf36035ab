"""Lamps told from surfaces by their luminance."""

import numpy as np
import pytest

from spectral_probe.geometry.frames import panorama_directions
from spectral_probe.spectra.emitters import direct_probability, surface_luminance


def test_a_small_lamp_lights_a_white_surface_by_its_solid_angle():
    """A disc of half angle 10 degrees and radiance L gives the irradiance L pi sin^2(10 deg) where it is overhead."""
    directions = panorama_directions(128, 256)
    lamp = 500.0 * (directions @ np.array([0.3, 0.5, np.sqrt(1 - 0.34)]) > np.cos(np.radians(10)))
    assert surface_luminance(lamp) == pytest.approx(500 * np.sin(np.radians(10)) ** 2, rel=0.05)


def test_the_panoramas_width_does_not_matter():
    rng = np.random.default_rng(3)
    small = rng.random((32, 64)).astype(np.float32)
    large = small.repeat(4, axis=0).repeat(4, axis=1)
    assert surface_luminance(large) == pytest.approx(surface_luminance(small), rel=0.01)


def test_odds_rise_with_luminance_and_are_never_certain():
    chance = direct_probability(np.geomspace(1e-3, 1e3, 50), 1.0)
    assert (np.diff(chance) >= 0).all()
    assert chance[0] > 0
    assert chance[-1] < 1
    assert direct_probability(np.array([0.0, -1.0]), 0.0) == pytest.approx([0.02, 0.02])

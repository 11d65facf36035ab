"""The stained glass of the sample stands where its windows are, and nowhere else."""

import numpy as np
import pytest

from spectral_probe import sample
from spectral_probe.geometry.frames import bearing_to_direction
from spectral_probe.model import SpectralPanorama
from spectral_probe.spectra.edits import edited_mask, remove_all_edits
from spectral_probe.spectra.glass import glass_transmittance
from spectral_probe.spectra.grid import WAVELENGTHS_NM


@pytest.fixture(scope="module")
def even_light():
    shape = (128, 256)
    return SpectralPanorama(
        np.ones((*shape, 1), np.float32),
        np.ones((1, 1, 61)),
        np.zeros(shape, np.uint8),
        WAVELENGTHS_NM,
        np.ones(shape, bool),
        np.ones(shape, np.float32),
    )


def texel(bearing_deg, elevation_deg, height=128):
    x, y, z = bearing_to_direction(bearing_deg, elevation_deg)
    column = (0.5 - np.arctan2(y, x) / (2 * np.pi)) * 2 * height
    return int((0.5 - np.arcsin(z) / np.pi) * height), int(column) % (2 * height)


def test_windows_have_red_yellow_and_green_glass_in_turn(even_light):
    stained = sample.stained_gym(even_light)
    assert [edit.name for edit in stained.edits] == ["red", "yellow", "green"]
    for number, window in enumerate(sample.gym_truth()["windows"]):
        place = texel(window["bearing_deg"], window["elevation_deg"])
        seen = stained.weights[place] @ stained.bases[stained.basis_index[place]]
        np.testing.assert_allclose(seen, glass_transmittance(sample.GLASSES[number % 3]), atol=1e-6)


def test_lamps_and_walls_keep_their_light(even_light):
    stained = sample.stained_gym(even_light)
    panes = np.logical_or.reduce([edited_mask(stained, number) for number in range(3)])
    assert 0.01 < panes.mean() < 0.06
    places = [(lamp["bearing_deg"], lamp["elevation_deg"]) for lamp in sample.gym_truth()["lamps"]]
    assert not any(panes[texel(*place)] for place in [*places, (180.0, 10.0), (4.0, -5.0)])
    np.testing.assert_array_equal(remove_all_edits(stained).basis_index, even_light.basis_index)

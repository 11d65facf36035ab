"""The sample's plate: where its camera was, and that its floor is as bright as the probe says."""

from dataclasses import replace

import numpy as np
import pytest

from spectral_probe import sample_plate
from spectral_probe.composite.ground import ground_distance
from spectral_probe.composite.plate_light import plate_radiance
from spectral_probe.geometry.camera import project
from spectral_probe.model import SpectralPanorama
from spectral_probe.photo.read import read_photograph
from spectral_probe.sample import gym_truth
from spectral_probe.spectra.colorimetry import illuminant, panorama_xyz, xyz_to_rec709
from spectral_probe.spectra.grid import WAVELENGTHS_NM


@pytest.fixture(scope="module")
def light():
    shape = (64, 128)
    return SpectralPanorama(
        np.full((*shape, 1), 3.0, np.float32),
        illuminant("D65")[None, None],
        np.zeros(shape, np.uint8),
        WAVELENGTHS_NM,
        np.ones(shape, bool),
        np.ones(shape, np.float32),
    )


@pytest.fixture(scope="module")
def plate(light):
    return sample_plate.gym_plate(light)


def test_lamps_are_seen_where_the_camera_says(plate):
    """Two lamps in the picture's upper right: saturated where they project to, and not beside them."""
    codes = read_photograph(plate.photo).pixels
    lamps = {lamp["name"]: np.array(lamp["at_m"]) for lamp in gym_truth()["lamps"]}
    seen = 0
    for at_m in lamps.values():
        column, row = project(plate.camera, (at_m - plate.position_m) @ plate.rotation)
        if 20 < column < 700 and 20 < row < 460 and (at_m - plate.position_m) @ plate.rotation[:, 2] > 0:
            seen += 1
            assert codes[int(row), int(column)].min() > 0.9
            assert codes[int(row) + 45, int(column)].min() < 0.9
    assert seen >= 3


def test_gains_are_those_of_the_floor(plate, light):
    """The floor in even light of one spectrum: gain times the probe's light is the floor's median, and light twice as
    bright halves the gain."""
    away_m = ground_distance(plate)
    floor = (away_m > 1.0) & (away_m < 3.5)
    shown, _ = plate_radiance(read_photograph(plate.photo), replace(plate, gain=np.ones(3)))
    level = xyz_to_rec709(panorama_xyz(light))[0, 0]
    np.testing.assert_allclose(plate.gain * level, np.median(shown[floor], axis=0), rtol=0.03)
    brighter = sample_plate.gym_plate(replace(light, weights=2 * light.weights))
    np.testing.assert_allclose(brighter.gain * 2, plate.gain, rtol=1e-6)

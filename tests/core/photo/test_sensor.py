"""Sensor constants from simulated brackets, and typical ones where they cannot be told."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from spectral_probe.model import Exposure, Photograph
from spectral_probe.photo.noise import SensorNoise
from spectral_probe.photo.sensor import sensor_noise

SIZE = 240
EVERYWHERE = np.ones((SIZE, SIZE), bool)


def bracket(full_well, read_noise, seed=0):
    random = np.random.default_rng(seed)
    detail = cv2.GaussianBlur(random.normal(size=(SIZE, SIZE, 3)).astype(np.float32), (0, 0), 8)
    radiance = 0.05 * np.exp(1.5 * detail / detail.std())
    photographs, exposures = [], []
    for time_s, iso in ((0.3, 100.0), (1.2, 100.0), (4.8, 200.0)):
        exposure = Exposure(time_s, iso)
        electrons = full_well * 100.0 / iso
        values = random.poisson(radiance * exposure.relative * electrons) / electrons
        values = np.minimum(values + random.normal(0.0, read_noise, values.shape), 1.0).astype(np.float32)
        photographs.append(Photograph(Path("a.dng"), values, (values >= 0.98).any(-1)))
        exposures.append(exposure)
    return photographs, exposures


@pytest.mark.parametrize(("full_well", "read_noise"), [(30000, 2e-4), (10000, 1e-3), (60000, 1e-4)])
def test_constants_are_found(full_well, read_noise):
    found = sensor_noise(*bracket(full_well, read_noise), EVERYWHERE)
    assert found.full_well_electrons == pytest.approx(full_well, rel=0.1)
    assert found.read_noise == pytest.approx(read_noise, rel=0.15)


def test_what_moved_does_not_count():
    photographs, exposures = bracket(30000, 2e-4)
    pixels = photographs[1].pixels.copy()
    pixels[60:120, 60:120] *= np.float32(0.5)
    found = sensor_noise(
        [photographs[0], replace(photographs[1], pixels=pixels), photographs[2]], exposures, EVERYWHERE
    )
    assert found.full_well_electrons == pytest.approx(30000, rel=0.15)


def test_typical_constants_where_the_bracket_cannot_tell():
    photographs, exposures = bracket(30000, 2e-4)
    typical = SensorNoise()
    assert sensor_noise(photographs[:1], exposures[:1], EVERYWHERE) == typical
    converted = [replace(one, display_referred=True) for one in photographs]
    assert sensor_noise(converted, exposures, EVERYWHERE) == typical
    assert sensor_noise(photographs, exposures, ~EVERYWHERE) == typical
    smooth = [replace(one, pixels=cv2.GaussianBlur(one.pixels, (0, 0), 6)) for one in photographs]
    assert sensor_noise(smooth, exposures, EVERYWHERE) == typical  # a converter took the noise away

"""Light of a measured spectrum: its level comes back from any number of channels, and what is unlike it is doubted."""

import numpy as np
import pytest

from spectral_probe.errors import SpectralDataError
from spectral_probe.spectra.camera import camera_sensitivities
from spectral_probe.spectra.colorimetry import illuminant
from spectral_probe.spectra.grid import STEP_NM
from spectral_probe.spectra.measured_light import measured_light_recovery

CAMERA = camera_sensitivities("Nikon 5100 (NPL)")
TUBE = illuminant("FL11")


def channels(green_filter, filters):
    return np.concatenate([CAMERA, *[CAMERA * green_filter[:, None]] * filters], axis=-1)


@pytest.mark.parametrize("filters", [0, 1])
def test_the_level_comes_back(green_filter, filters):
    curves = channels(green_filter, filters)
    recovery = measured_light_recovery(curves, TUBE)
    levels = np.array([0.01, 1.0, 300.0])
    noise = 1 + 0.005 * np.random.default_rng(0).standard_normal((3, curves.shape[1]))
    found = recovery.recover(levels[:, None] * (TUBE @ curves) * STEP_NM * noise)
    spectra = found.weights @ recovery.bases[0]
    np.testing.assert_allclose(spectra, levels[:, None] * TUBE, rtol=0.01)
    assert found.confidence.min() > 0.9


def test_another_light_is_doubted(green_filter):
    curves = channels(green_filter, 1)
    recovery = measured_light_recovery(curves, TUBE)
    own, other = (
        recovery.recover(light @ curves * STEP_NM).relative_error for light in (TUBE, illuminant("A"))
    )
    assert own < 0.02
    assert other > 0.1


def test_a_light_that_no_channel_sees_is_refused():
    blind = CAMERA * 0.0
    with pytest.raises(SpectralDataError, match="No channel of the camera sees"):
        measured_light_recovery(blind, TUBE)

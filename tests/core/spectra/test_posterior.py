"""What is known of one spectrum: bands, kinds of light, metamer risk, residual."""

import numpy as np
import pytest

from spectral_probe.spectra.camera import camera_sensitivities
from spectral_probe.spectra.colorimetry import illuminant
from spectral_probe.spectra.grid import STEP_NM, WAVELENGTHS_NM
from spectral_probe.spectra.library import daylight, planck
from spectral_probe.spectra.posterior import metamer_risk, posterior
from spectral_probe.spectra.recovery import spectral_recovery

CAMERA = camera_sensitivities("Nikon 5100 (NPL)")
SMOOTH = spectral_recovery(CAMERA, ["incandescent", "daylight"])


def known(light, recovery=SMOOTH, **words):
    return posterior(recovery, light @ recovery.sensitivities * STEP_NM, **words)


def test_it_agrees_with_the_recovery_of_images():
    for light in (planck(2700.0), daylight(5200)):
        found = SMOOTH.recover(light @ CAMERA * STEP_NM)
        about = known(light)
        assert about.mean == pytest.approx(
            found.weights @ SMOOTH.bases[found.basis_index], rel=5e-3, abs=5e-3
        )
        assert about.relative_error == pytest.approx(float(found.relative_error), rel=1e-2)


def test_the_band_is_narrow_where_the_camera_sees_and_wide_where_it_does_not():
    lamp = known(planck(2856.0) * np.linspace(0.3, 0.6, 61), direct=0.05)
    error = lamp.standard_error / lamp.mean
    green = (WAVELENGTHS_NM > 520) & (WAVELENGTHS_NM < 580)
    assert error[green].mean() < 0.5 * error[WAVELENGTHS_NM > 690].mean()


def test_noise_widens_the_band():
    responses = daylight(6500) @ CAMERA * STEP_NM
    quiet = posterior(SMOOTH, responses)
    noisy = posterior(SMOOTH, responses, (0.05 * responses) ** 2)
    assert noisy.relative_error > 1.2 * quiet.relative_error


def test_kinds_sum_to_one_and_a_strange_light_is_unexpected():
    sodium = known(illuminant("LPS"))
    assert sum(sodium.kinds.values()) == pytest.approx(1)
    assert sodium.kinds["unexpected"] > 20 * known(planck(2856.0)).kinds["unexpected"]
    assert sodium.relative_error > 10 * known(planck(2856.0)).relative_error


def test_responses_that_contradict_each_other_leave_a_residual():
    filtered = np.concatenate([CAMERA, CAMERA * np.linspace(0.2, 0.9, 61)[:, None]], axis=1)
    recovery = spectral_recovery(filtered, ["incandescent", "daylight"])
    responses = daylight(5600) @ filtered * STEP_NM
    assert posterior(recovery, responses).residual < 0.01
    responses[3:] *= 1.5  # a filter of another density than stated
    assert posterior(recovery, responses).residual > 0.05


def test_metamer_risk_is_that_of_lights_drawn_from_the_band():
    certain = known(daylight(6500))
    guessed = posterior(spectral_recovery(CAMERA, ["automatic"]), illuminant("FL11") @ CAMERA * STEP_NM)
    assert metamer_risk(certain.mean, 0 * certain.covariance) == pytest.approx(0, abs=1e-6)
    assert metamer_risk(certain.mean, certain.covariance) < 1
    assert metamer_risk(guessed.mean, guessed.covariance) > 2
    assert metamer_risk(np.zeros(61), np.eye(61)) == 0


def test_errors_can_only_be_raised():
    about = known(daylight(6500))
    assert about.at_least(0.0).relative_error == pytest.approx(about.relative_error)
    assert about.at_least(0.5).relative_error == pytest.approx(0.5)

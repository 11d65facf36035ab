"""The classes of light that may be there, and the linear estimate of each."""

import numpy as np
import pytest

from spectral_probe.spectra.camera import camera_sensitivities
from spectral_probe.spectra.estimates import wiener_estimate
from spectral_probe.spectra.grid import STEP_NM
from spectral_probe.spectra.prior import ALIKE, light_classes

CHANNELS = camera_sensitivities("Nikon 5100 (NPL)") * STEP_NM


def test_moments_have_unit_trace_and_shares_sum_to_one():
    classes = light_classes(["incandescent", "daylight", "discharge"])
    for one in classes:
        assert np.trace(one.moment) == pytest.approx(1)
        assert one.shares.sum() == pytest.approx(1)
    for direct in (True, False):
        assert sum(one.share for one in classes if one.direct is direct) == pytest.approx(1)


def test_nothing_is_unexpected_when_all_families_are_allowed():
    names = [one.name for one in light_classes(["automatic"])]
    assert "unexpected" not in names
    assert len(names) == 10
    assert [one.name for one in light_classes(["daylight"])] == ["daylight", "reflected", "unexpected"]


def test_what_is_tried_is_not_among_what_it_is_tried_with():
    for one in light_classes(["incandescent", "fluorescent-triband"]):
        for tried, others in one.folds():
            assert not others[tried].any()
            if one.direct and np.count_nonzero(others & one.members) > 3:
                fits = one.spectra[tried] @ one.spectra[others].T
                assert fits.max() <= ALIKE or not (one.spectra @ one.spectra[tried[0]] <= ALIKE)[others].all()


def test_an_estimates_error_is_that_on_lights_left_out():
    """Recomputed here the long way for one class."""
    triband = light_classes(["fluorescent-triband"])[0]
    estimate = wiener_estimate(triband, CHANNELS)
    squares = []
    for tried, others in triband.folds():
        spectra, shares = triband.spectra[others], triband.shares[others]
        moment = (spectra * shares[:, None]).T @ spectra / shares.sum()
        seen = CHANNELS.T @ moment @ CHANNELS
        noise = 0.005**2 * np.diag(seen).max() * np.eye(3)
        operator = np.linalg.solve(seen + noise, CHANNELS.T @ moment)
        squares.append((triband.spectra[tried] - triband.spectra[tried] @ CHANNELS @ operator) ** 2)
    assert np.diag(estimate.error) == pytest.approx(np.concatenate(squares).mean(0), rel=1e-6)
    assert np.trace(estimate.error) > np.trace(
        np.cov((triband.spectra - triband.spectra @ CHANNELS @ estimate.operator).T)
    )


def test_the_users_own_lights_are_known():
    own = np.eye(61)[[10, 30]] + 0.1
    named = {one.name: one for one in light_classes(["daylight"], own)}
    assert np.trace(wiener_estimate(named["own"], CHANNELS).error) < 0.1

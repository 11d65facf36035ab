import numpy as np
import pytest

from spectral_probe.spectra.library import planck
from spectral_probe.spectra.metrics import (
    colour_temperature,
    goodness_of_fit,
    relative_rmse,
    scaled_to_energy,
)


def test_goodness_of_fit_is_the_cosine(subtests):
    a, b = np.array([1.0, 0.0, 0.0]), np.array([1.0, 1.0, 0.0])
    with subtests.test("angle"):
        assert goodness_of_fit(a, b) == pytest.approx(np.cos(np.pi / 4))
    with subtests.test("level does not matter"):
        assert goodness_of_fit(a, 7 * a) == pytest.approx(1.0)
    with subtests.test("any leading shape"):
        assert goodness_of_fit(np.ones((4, 5, 61)), np.ones(61)).shape == (4, 5)
    with subtests.test("black"):
        assert goodness_of_fit(a, 0 * a) == 0


def test_relative_rmse():
    measured = np.array([1.0, 2.0, 3.0])
    assert relative_rmse(5 * measured, measured) == pytest.approx(0)
    assert relative_rmse(1.1 * measured, measured, same_energy=False) == pytest.approx(0.1)
    swapped = measured[::-1]
    assert relative_rmse(swapped, measured) == pytest.approx(np.sqrt(8 / 14))
    assert np.isnan(relative_rmse(measured, 0 * measured))


def test_scaled_to_energy_keeps_the_shape():
    spectra = np.array([[1.0, 3.0], [0.0, 0.0]])
    np.testing.assert_allclose(scaled_to_energy(spectra, np.array([4.0, 4.0])), [[2.0, 6.0], [0.0, 0.0]])


@pytest.mark.parametrize("kelvin", [2500.0, 2856.0, 4000.0, 6500.0])
def test_black_bodies_have_their_own_temperature(kelvin):
    found, duv = colour_temperature(planck(kelvin) * 3.0)
    assert found == pytest.approx(kelvin, rel=0.004)  # 400-700 nm only
    assert abs(duv) < 3e-4


def test_far_from_the_planckian_locus_there_is_no_colour_temperature():
    green = np.zeros(61)
    green[25:28] = 1.0
    assert colour_temperature(green) is None
    assert colour_temperature(np.zeros(61)) is None

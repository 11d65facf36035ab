import numpy as np
import pytest

from spectral_probe.errors import SpectralDataError
from spectral_probe.spectra.metals import (
    ball_reflectance,
    fresnel_reflectance,
    metal_reflectance,
    refractive_index,
)

AT_450_550_650 = [10, 30, 50]


@pytest.mark.parametrize(
    ("metal", "published"),
    [
        ("Fe", [0.496, 0.512, 0.531]),
        ("Cr", [0.555, 0.555, 0.555]),
        ("Ni", [0.571, 0.644, 0.701]),
        ("Au", [0.408, 0.792, 0.959]),
        ("Ag", [0.980, 0.983, 0.990]),
        ("Cu", [0.538, 0.622, 0.938]),
        ("Al", [0.922, 0.916, 0.906]),
    ],
)
def test_reflectance_at_normal_incidence(metal, published):
    """Reflectances computed independently from the same pages of refractiveindex.info."""
    assert np.abs(metal_reflectance(metal, np.array(1.0))[AT_450_550_650] - published).max() < 1e-3


def test_interpolation_is_cubic_and_passes_through_the_table():
    n, _ = refractive_index("Cu", np.array([548.6]))  # a wavelength of Johnson & Christy (2.26 eV)
    assert n[0] == pytest.approx(1.02, abs=2e-3)
    fine = refractive_index("Au", np.arange(400, 700, 0.5))[0]
    assert np.abs(np.diff(fine, 2)).max() < 2e-3  # no corners, as straight lines would have


def test_fresnel_against_complex_arithmetic():
    """The real-valued formula against the textbook's complex amplitudes."""
    index = 0.6 + 2.1j
    cosine = np.linspace(0.01, 1, 50)
    transmitted = np.sqrt(1 - (1 - cosine**2) / index**2)
    s = (cosine - index * transmitted) / (cosine + index * transmitted)
    p = (index * cosine - transmitted) / (index * cosine + transmitted)
    expected = (np.abs(s) ** 2 + np.abs(p) ** 2) / 2
    assert np.allclose(fresnel_reflectance(np.array(0.6), np.array(2.1), cosine), expected, atol=1e-12)


def test_grazing_light_is_all_reflected():
    assert np.allclose(ball_reflectance("SUS304", np.array(0.0)), 1.0)


def test_sus304_is_the_mixture_of_eq_11():
    mixed = ball_reflectance({"Fe": 74, "Cr": 18, "Ni": 8}, np.array(1.0))
    assert np.allclose(mixed, ball_reflectance("SUS304", np.array(1.0)))
    assert mixed[60] / mixed[0] == pytest.approx(1.141, abs=1e-3)
    at_80_degrees = ball_reflectance("SUS304", np.cos(np.radians(80.0)))
    assert at_80_degrees[60] / at_80_degrees[0] == pytest.approx(0.978, abs=1e-3)


def test_an_ideal_ball_reflects_everything():
    assert (ball_reflectance("ideal", np.linspace(0, 1, 5)) == 1).all()


def test_unknown_names_get_a_suggestion():
    with pytest.raises(SpectralDataError, match=r'no metal called "Gould".*Did you mean "Au"'):
        refractive_index("Gould")
    with pytest.raises(SpectralDataError, match=r'Did you mean "SUS304"'):
        ball_reflectance("SUS 304", np.array(1.0))
    with pytest.raises(SpectralDataError, match="no page"):
        refractive_index("main/Au/Nobody")


def test_data_that_do_not_cover_the_wavelengths_are_refused():
    with pytest.raises(SpectralDataError, match="is known for"):
        refractive_index("Au", np.array([100.0, 500.0]))

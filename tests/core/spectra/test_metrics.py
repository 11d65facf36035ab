import numpy as np
import pytest

from spectral_probe.spectra.colorimetry import colour_matching_functions, illuminant
from spectral_probe.spectra.colour_science import colour
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.library import planck
from spectral_probe.spectra.metrics import (
    colour_temperature,
    compare_spectra,
    goodness_of_fit,
    light_difference,
    light_numbers,
    relative_rmse,
    scaled_to_energy,
    surface_differences,
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


# ---------------------------------------------------------------- all the numbers of an estimate and a measurement


@pytest.mark.parametrize(("name", "ra"), [("FL2", 64), ("FL4", 51), ("FL11", 83), ("A", 100), ("D65", 100)])
def test_rendering_indices_are_those_that_the_cie_publishes(name, ra):
    numbers = light_numbers(5 * illuminant(name))  # of CIE 15:2004, from 380-780 nm
    assert numbers.ra == pytest.approx(ra, abs=0.75)


@pytest.mark.filterwarnings("ignore:Aligning")  # colour-science tells what it does to its own tables
def test_rendering_from_400_700_nm_is_that_from_380_780_nm():
    light = colour.SDS_ILLUMINANTS["FL3.9"].copy().align(colour.SpectralShape(380, 780, 5))
    numbers = light_numbers(light.values, light.wavelengths)
    assert numbers.ra == pytest.approx(colour.colour_rendering_index(light), abs=0.3)
    whole = colour.colour_fidelity_index(light, method="ANSI/IES TM-30-18", additional_data=True)
    assert (numbers.rf, numbers.rg) == pytest.approx((whole.R_f, whole.R_g), abs=0.15)


def test_equal_spectra_differ_in_nothing():
    compared = compare_spectra(7 * illuminant("FL11"), illuminant("FL11"))
    assert compared.gfc == pytest.approx(1)
    assert compared.relative_rmse == pytest.approx(0, abs=1e-12)
    assert compared.delta_cct_kelvin == pytest.approx(0, abs=1e-6)
    assert compared.de2000_light == pytest.approx(0, abs=1e-6)
    assert compared.de2000_colorchecker == pytest.approx((0, 0), abs=1e-6)
    assert compared.de2000_metals == pytest.approx((0, 0), abs=1e-6)


def test_metamers_differ_on_surfaces_only():
    daylight = illuminant("D65")
    cmfs = colour_matching_functions()
    ripple = np.cos(WAVELENGTHS_NM / 12.0)
    unseen = daylight * ripple
    unseen -= daylight * (cmfs @ np.linalg.solve(cmfs.T @ (daylight[:, None] * cmfs), cmfs.T @ unseen))
    metamer = daylight + 0.8 * unseen
    compared = compare_spectra(metamer, daylight)
    assert compared.de2000_light == pytest.approx(0, abs=1e-5)
    assert compared.delta_cct_kelvin == pytest.approx(0, abs=0.01)
    assert compared.gfc < 0.95
    mean, largest = compared.de2000_colorchecker
    assert 0.5 < mean < largest < 10
    assert compared.estimated.ra < 95 < compared.measured.ra


def test_colour_differences_are_those_of_colour_science():
    estimated, measured = 3 * illuminant("A"), illuminant("FL4")
    xyz = [light @ colour_matching_functions() for light in (estimated, measured)]
    d65 = colour.CCS_ILLUMINANTS["CIE 1931 2 Degree Standard Observer"]["D65"]
    labs = [colour.XYZ_to_Lab(value / value[1] * 0.6, d65) for value in xyz]
    expected = colour.delta_E(*labs, method="CIE 2000")
    assert compare_spectra(estimated, measured).de2000_light == pytest.approx(expected, abs=1e-9)
    stacked = light_difference(np.stack([estimated, measured]), measured)
    assert stacked.shape == (2,)
    assert stacked == pytest.approx([expected, 0], abs=1e-9)


def test_a_perfect_diffuser_shows_the_light_itself():
    estimated, measured = illuminant("A"), illuminant("D65")
    white, black = surface_differences(estimated, measured, np.stack([np.ones(61), np.zeros(61)]))
    assert white > 20
    assert black == pytest.approx(0)
    assert surface_differences(4 * measured, measured, np.ones((1, 61))) == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize(
    "light", [np.zeros(61), -np.ones(61), np.full(61, np.nan), np.eye(61)[0], np.eye(61)[60], np.eye(61)[10]]
)
def test_what_is_not_defined_is_none_and_nothing_warns(light):
    daylight = illuminant("D65")
    for compared in (compare_spectra(light, daylight), compare_spectra(daylight, light)):
        assert compared.delta_cct_kelvin is None
        numbers = min((compared.estimated, compared.measured), key=lambda one: one.cct_kelvin is not None)
        assert numbers.cct_kelvin is numbers.duv is numbers.ra is numbers.rf is numbers.rg is None
        assert (compared.de2000_light is None) == (not light.sum() > 0)


def test_the_ends_of_a_wider_grid_do_not_count():
    wide_nm = np.arange(380.0, 781.0, 5.0)
    inside = (wide_nm >= 400) & (wide_nm <= 700)
    light = np.where(inside, np.interp(wide_nm, WAVELENGTHS_NM, illuminant("FL2")), 1e6)
    assert light_numbers(light, wide_nm) == light_numbers(illuminant("FL2"))

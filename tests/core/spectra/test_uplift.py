"""Reflectances from RGB: colours come back under D65, white stays white, nothing reflects more than all or less than none."""

import numpy as np
import pytest

from spectral_probe.spectra.colorimetry import (
    colour_matching_functions,
    delta_e_2000,
    illuminant,
    rec709_to_xyz,
    spectra_to_xyz,
)
from spectral_probe.spectra.colour_science import colour
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.uplift import reflectance_basis, uplift


@pytest.fixture(scope="module")
def colours():
    """A thousand random sRGB colours and the corners of the cube, linear."""
    encoded = np.random.default_rng(2019).random((1000, 3))
    corners = np.stack(np.meshgrid([0.0, 1.0], [0.0, 1.0], [0.0, 1.0]), -1).reshape(-1, 3)
    encoded = np.concatenate([encoded, corners])
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def round_trip_errors(rgb, basis, light, matching):
    """DE2000 of the colours that the reflectances have under a light, its white taken for that of Rec.709."""
    white = rec709_to_xyz(np.ones(3))
    xyz = (rgb @ basis.T * light) @ matching / (light @ matching) * white
    return delta_e_2000(rec709_to_xyz(rgb), xyz, white)


def test_colours_come_back_on_the_grid(colours):
    light, matching = illuminant("D65"), colour_matching_functions()
    errors = round_trip_errors(colours, reflectance_basis(), light, matching)
    assert errors[:1000].mean() <= 0.05
    assert errors.max() <= 0.2
    direct = spectra_to_xyz(uplift(colours) * light) / spectra_to_xyz(light) * rec709_to_xyz(np.ones(3))
    np.testing.assert_allclose(
        delta_e_2000(rec709_to_xyz(colours), direct, rec709_to_xyz(np.ones(3))), errors, atol=1e-6
    )


def test_colours_come_back_over_the_whole_table(colours):
    """What is left on the grid is light beyond 400 and 700 nm, not the basis."""
    table = colour.recovery.MSDS_BASIS_FUNCTIONS_sRGB_MALLETT2019
    nm = np.asarray(table.wavelengths, float)
    assert (nm[0], nm[-1]) == (380.0, 780.0)

    def on(distribution):
        known, values = np.asarray(distribution.wavelengths, float), np.asarray(distribution.values, float)
        columns = values.reshape(len(known), -1).T
        return np.squeeze(np.stack([np.interp(nm, known, column) for column in columns], -1))

    light, matching = (
        on(colour.SDS_ILLUMINANTS["D65"]),
        on(colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]),
    )
    basis = np.asarray(table.values)
    assert round_trip_errors(colours, basis, light, matching).max() <= 0.05
    inside = np.isin(nm, WAVELENGTHS_NM)
    np.testing.assert_allclose(reflectance_basis(), basis[inside], atol=1e-6)


def test_reflectances_are_physical_and_white_is_white(colours):
    basis = reflectance_basis()
    np.testing.assert_allclose(basis.sum(-1), 1.0, rtol=1e-12)
    assert basis.min() >= 0
    spectra = uplift(colours)
    assert spectra.min() >= 0
    assert spectra.max() <= 1 + 1e-12
    np.testing.assert_allclose(uplift(np.full(3, 0.18)), 0.18, rtol=1e-12)

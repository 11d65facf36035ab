import numpy as np
import pytest

from spectral_probe.errors import SpectralDataError
from spectral_probe.spectra.colorimetry import (
    chromaticity,
    delta_e_2000,
    illuminant,
    rec709_to_xyz,
    spectra_to_xyz,
    white_xyz,
    xyz_to_rec709,
)
from spectral_probe.spectra.grid import WAVELENGTHS_NM, resample
from spectral_probe.spectra.uplift import uplift


@pytest.mark.parametrize(
    ("light", "xy"),
    [("D65", (0.3127, 0.3290)), ("A", (0.4476, 0.4074)), ("E", (1 / 3, 1 / 3)), ("FL2", (0.3721, 0.3751))],
)
def test_published_chromaticities(light, xy):
    assert chromaticity(spectra_to_xyz(illuminant(light))) == pytest.approx(xy, abs=5e-4)


def test_sharma_pair():
    """Sharma, Wu & Dalal (2005), pair 1: dE2000 2.0425."""
    from spectral_probe.spectra.colour_science import colour

    white = np.array([0.95047, 1.0, 1.08883])
    xy = white[:2] / white.sum()
    lab = np.array([[50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485]])
    a, b = colour.Lab_to_XYZ(lab, xy)
    assert delta_e_2000(a, b, white) == pytest.approx(2.0425, abs=1e-3)


def test_rec709_round_trip():
    rgb = np.random.default_rng(9).normal(size=(100, 3))
    assert np.allclose(xyz_to_rec709(rec709_to_xyz(rgb)), rgb)


def test_a_grey_uplifts_to_a_flat_reflectance_and_colours_come_back():
    assert np.allclose(uplift(np.array([0.4, 0.4, 0.4])), 0.4)
    colours = np.random.default_rng(10).uniform(0, 1, size=(50, 3))
    light = illuminant("D65")
    xyz = spectra_to_xyz(uplift(colours) * light) / spectra_to_xyz(light)[1]
    assert np.abs(xyz_to_rec709(xyz) - colours).max() < 0.01
    assert white_xyz() == pytest.approx([0.9505, 1, 1.089], abs=2e-3)


def test_unknown_light():
    with pytest.raises(SpectralDataError, match='no light called "D66"'):
        illuminant("D66")


def test_resample_refuses_what_is_not_covered():
    with pytest.raises(SpectralDataError, match="covers 450-700 nm"):
        resample(np.array([450.0, 700.0]), np.array([1.0, 1.0]))
    shuffled = resample(np.array([700.0, 400.0]), np.array([[1.0, 0.0]]))
    assert np.allclose(shuffled[0], (WAVELENGTHS_NM - 400) / 300)

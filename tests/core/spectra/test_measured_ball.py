import numpy as np
import pytest

from spectral_probe.errors import SpectralDataError
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.metals import ball_reflectance, metal_reflectance

DEGREES = np.array([0.0, 20.0, 40.0, 60.0, 70.0, 80.0])
COSINES = np.cos(np.radians(DEGREES))


def write(path, angles, metal):
    """A ball measured at some angles: the exact Fresnel reflectance of a metal."""
    curves = metal_reflectance(metal, np.cos(np.radians(angles)))
    heading = "wavelength_nm," + ",".join(f"{angle:g}deg" for angle in angles)
    rows = [
        f"{nm:g}," + ",".join(f"{value:.6f}" for value in at)
        for nm, at in zip(WAVELENGTHS_NM, curves.T, strict=True)
    ]
    path.write_text("\n".join([heading, *rows]))
    return str(path)


@pytest.mark.parametrize(
    ("metal", "to_60", "to_80"),
    [
        ("Cr", 0.003, 0.014),
        ("Ni", 0.01, 0.07),
        ("stainless steel", 0.011, 0.06),
        ("Ag", 0.007, 0.03),
        ("Al", 1e-5, 1e-5),
    ],
)
def test_from_normal_incidence_alone(tmp_path, metal, to_60, to_80):
    modelled = ball_reflectance(write(tmp_path / "ball.csv", [0], metal), COSINES)
    error = np.abs(modelled - metal_reflectance(metal, COSINES)).max(1)
    assert error[0] < 1e-5
    assert error[:4].max() < to_60
    assert error.max() < to_80


def test_measured_angles_are_met_and_correct_what_lies_between(tmp_path):
    exact = metal_reflectance("Ni", COSINES)
    modelled = ball_reflectance(write(tmp_path / "ball.csv", [0, 40, 70, 80], "Ni"), COSINES)
    assert modelled[[0, 2, 4, 5]] == pytest.approx(exact[[0, 2, 4, 5]], abs=1e-5)
    assert np.abs(modelled - exact).max() < 0.009  # against 0.067 from normal incidence alone
    assert ball_reflectance(str(tmp_path / "ball.csv"), np.array(0.0)) == pytest.approx(1.0, abs=1e-6)


def test_other_wavelengths(tmp_path):
    file = write(tmp_path / "ball.csv", [0], "Cr")
    at = ball_reflectance(file, np.array(1.0), np.array([500.0, 502.5]))
    assert at == pytest.approx(metal_reflectance("Cr", np.array(1.0))[[20]].repeat(2), abs=2e-3)


@pytest.mark.parametrize(
    ("heading", "message"),
    [
        ("nm,0,60,30", "Let its columns ascend"),
        ("nm,45,60,70", "ascend from 0"),
        ("nm,0,60,90", "end below 90"),
    ],
)
def test_angles_that_cannot_be(tmp_path, heading, message):
    rows = [f"{nm},0.5,0.5,0.6" for nm in range(400, 710, 10)]
    (tmp_path / "ball.csv").write_text("\n".join([heading, *rows]))
    with pytest.raises(SpectralDataError, match=message):
        ball_reflectance(str(tmp_path / "ball.csv"), COSINES)


def test_a_ball_in_percent_or_missing(tmp_path):
    (tmp_path / "ball.csv").write_text("\n".join(f"{nm},55" for nm in range(400, 710, 10)))
    with pytest.raises(SpectralDataError, match=r"ball\.csv seems to be in percent"):
        ball_reflectance(str(tmp_path / "ball.csv"), COSINES)
    with pytest.raises(SpectralDataError, match="There is no file at"):
        ball_reflectance(str(tmp_path / "none.csv"), COSINES)


def test_a_real_ball_that_was_measured(shared_dir):
    """The chrome ball of Wytham Woods: darker than clean chromium, and as grey."""
    file = shared_dir / "photos" / "spectral_chromeball_wytham" / "specularReflectance_chromeball.csv"
    normal = ball_reflectance(str(file), np.array(1.0))
    assert normal[[0, 30, 60]] == pytest.approx([0.444, 0.476, 0.498], abs=1e-3)
    steep = ball_reflectance(str(file), COSINES)
    assert ((steep > 0.43) & (steep < 0.56)).all()

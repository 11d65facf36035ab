"""The verb `spectrum`: means over directions and regions, numbers, CSV and plots."""

import json
from dataclasses import replace

import numpy as np
import pytest

from spectral_probe.cli import main
from spectral_probe.errors import FileFormatError, SpectralProbeError
from spectral_probe.files.probe_exr import write_probe
from spectral_probe.geometry.frames import bearing_to_direction, panorama_directions, panorama_solid_angles
from spectral_probe.model import SpectralPanorama, finish
from spectral_probe.spectra.colorimetry import illuminant
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.library import planck
from spectral_probe.spectra.metrics import compare_spectra
from spectral_probe.spectrum_command import (
    DirectionSpectrum,
    disc_texels,
    numbers_of,
    region_spectrum,
    spectrum,
    spectrum_at,
    write_sensitivities,
    write_spectrum,
)

LIGHTS = np.stack([planck(2850.0), illuminant("D65") / 100, illuminant("FL11") / 40])


@pytest.fixture
def panorama():
    """A filament lamp at bearing 330, elevation -10, in daylight; the zenith in a basis of its own, the nadir unseen."""
    directions = panorama_directions(64, 128)
    lamp = directions @ bearing_to_direction(330, -10) > np.cos(np.radians(8))
    weights = np.zeros((64, 128, 3), np.float32)
    weights[..., 1] = 1
    weights[lamp] = (50, 0, 0)
    index = np.zeros((64, 128), np.uint8)
    index[:8] = 1
    valid = np.ones((64, 128), bool)
    valid[-4:] = False
    second = np.stack([LIGHTS[0], LIGHTS[2], np.zeros(61)])
    return SpectralPanorama(
        weights, np.stack([LIGHTS, second]), index, WAVELENGTHS_NM, valid, np.full((64, 128), 0.8, np.float32)
    )


@pytest.fixture
def probe_file(panorama, tmp_path):
    write_probe(tmp_path / "probe.exr", panorama)
    return tmp_path / "probe.exr"


def region_file(folder, name, **region):
    path = folder / f"{name}.json"
    path.write_text(json.dumps(region))
    return path


def test_a_direction_gives_its_light_and_basis(panorama):
    lamp, zenith = spectrum_at(panorama, 330, -10, 2), spectrum_at(panorama, 0, 80, 2)
    np.testing.assert_allclose(lamp.spectrum, 50 * LIGHTS[0], rtol=1e-6)
    np.testing.assert_allclose(zenith.spectrum, LIGHTS[2], rtol=1e-6)
    assert np.array_equal(lamp.basis, LIGHTS)
    assert len(zenith.basis) == 2  # the third is not used


def test_a_mean_is_weighted_by_solid_angle(panorama):
    chosen = np.zeros((64, 128), bool)
    chosen[4, 10] = chosen[30, 10] = chosen[-1, 10] = True  # one in each basis, and one that no view saw
    zenith, horizon = (float(panorama_solid_angles(64, 128)[row, 0]) for row in (4, 30))
    found = region_spectrum(panorama, chosen)
    expected = (zenith * LIGHTS[2] + horizon * LIGHTS[1]) / (zenith + horizon)
    np.testing.assert_allclose(found.spectrum, expected, rtol=1e-6)
    assert found.solid_angle_sr == pytest.approx(zenith + horizon)
    assert len(found.basis) == 3  # of the larger part
    with pytest.raises(FileFormatError, match="No view saw any of the region"):
        region_spectrum(panorama, ~panorama.valid)


def test_the_band_is_two_standard_errors_wide_and_not_below_zero():
    found = DirectionSpectrum(
        WAVELENGTHS_NM[:3], np.array([10.0, 1.0, -2.0]), np.array([1.0, 1.0, 1.0]), confidence=0.5
    )
    lower, upper = found.band_95
    np.testing.assert_allclose(upper, [11.96, 2.96, -0.04], atol=1e-4)
    np.testing.assert_allclose(lower, [8.04, 0.0, -2.0], atol=1e-4)


def test_a_regions_spectrum_against_a_measured_one(probe_file, tmp_path, capsys):
    region = region_file(tmp_path, "north-west", polygon_deg=[[326, -14], [334, -14], [334, -6], [326, -6]])
    rows = [f"{nm:g},{value:g}" for nm, value in zip(WAVELENGTHS_NM, LIGHTS[2], strict=True)]
    (tmp_path / "tube.csv").write_text("wavelength_nm,radiance\n" + "\n".join(rows))
    words = ["spectrum", probe_file, "--region", region, "--measured", tmp_path / "tube.csv", "--json"]
    assert main([str(word) for word in words]) == 0
    numbers = json.loads(capsys.readouterr().out)
    compared = compare_spectra(LIGHTS[0], LIGHTS[2])
    for name in ("gfc", "relative_rmse", "delta_cct_kelvin", "de2000_light"):
        assert numbers[name] == pytest.approx(getattr(compared, name), rel=1e-3), name
    for name in ("cct_kelvin", "duv", "ra", "rf", "rg"):
        assert numbers[name] == pytest.approx(getattr(compared.estimated, name), rel=1e-3, abs=1e-5), name
        assert numbers["measured"][name] == pytest.approx(
            getattr(compared.measured, name), rel=1e-3, abs=1e-5
        )
    assert numbers["de2000_metals_max"] == pytest.approx(compared.de2000_metals[1], rel=1e-3)
    assert numbers["de2000_colorchecker_mean"] == pytest.approx(compared.de2000_colorchecker[0], rel=1e-3)
    assert numbers["region"] == str(region)
    assert 0.015 < numbers["solid_angle_sr"] < 0.025
    table = np.genfromtxt(numbers["csv"], delimiter=",", names=True)
    assert table.dtype.names == (
        "wavelength_nm", "radiance", "standard_error", "lower_95", "upper_95", "measured",
    )  # fmt: skip
    np.testing.assert_allclose(table["radiance"], 50 * LIGHTS[0], rtol=1e-5)
    np.testing.assert_allclose(
        table["upper_95"] - table["radiance"], 1.96 * table["standard_error"], rtol=1e-3
    )
    assert table["measured"].sum() == pytest.approx(table["radiance"].sum(), rel=1e-5)
    for suffix in (".png", ".svg"):
        assert (tmp_path / f"spectrum_north-west{suffix}").stat().st_size > 5000


def test_without_a_measured_spectrum_there_is_no_comparison(probe_file):
    numbers = finish(spectrum(probe_file, (330.0, -10.0), None, None))
    assert not {"gfc", "measured", "families", "metamer_risk_de2000", "residual"} & set(numbers)
    assert numbers["cct_kelvin"] == pytest.approx(2850, abs=20)
    assert numbers["ra"] > 99


def test_the_basis_is_drawn_on_demand(probe_file, tmp_path):
    numbers = finish(spectrum(probe_file, (0.0, 80.0), None, tmp_path / "out", basis=True))
    assert numbers["basis_plot"] == str(tmp_path / "out" / "spectrum_0_80_basis.png")
    table = np.genfromtxt(tmp_path / "out" / "spectrum_0_80_basis.csv", delimiter=",", names=True)
    assert table.dtype.names == ("wavelength_nm", "E1", "E2")
    np.testing.assert_allclose(table["E2"], LIGHTS[2], rtol=1e-5)


def test_what_the_recovery_knows_more_is_told(panorama, tmp_path):
    found = replace(
        spectrum_at(panorama, 330, -10, 2),
        families={"incandescent": 0.9, "daylight": 0.1},
        metamer_risk_de2000=1.25,
        residual=0.004,
    )
    numbers = numbers_of(found)
    assert numbers["families"] == {"incandescent": 0.9, "daylight": 0.1}
    assert (numbers["metamer_risk_de2000"], numbers["residual"]) == (1.25, 0.004)
    json.dumps(numbers)
    write_spectrum(tmp_path / "s", found, None, "Lamp")
    write_spectrum(tmp_path / "without", replace(found, families=None), None, "Lamp")
    assert (tmp_path / "s.svg").stat().st_size > (tmp_path / "without.svg").stat().st_size + 2000


def test_a_probe_on_another_grid(panorama, tmp_path):
    wide_nm = np.arange(380.0, 781.0, 10.0)
    bases = np.stack([[np.interp(wide_nm, WAVELENGTHS_NM, row) for row in basis] for basis in panorama.bases])
    write_probe(tmp_path / "wide.exr", replace(panorama, bases=bases, wavelengths_nm=wide_nm))
    (tmp_path / "flat.csv").write_text("400,1\n700,1\n")
    numbers = finish(spectrum(tmp_path / "wide.exr", (330.0, -10.0), tmp_path / "flat.csv", None))
    assert numbers["cct_kelvin"] == pytest.approx(2850, abs=20)
    table = np.genfromtxt(numbers["csv"], delimiter=",", names=True)
    assert np.array_equal(table["wavelength_nm"], wide_nm)
    assert np.array_equal(np.isnan(table["measured"]), (wide_nm < 400) | (wide_nm > 700))


def test_black_light_is_told_without_numbers(panorama, tmp_path):
    write_probe(tmp_path / "probe.exr", replace(panorama, weights=np.zeros_like(panorama.weights)))
    numbers = finish(spectrum(tmp_path / "probe.exr", (330.0, -10.0), None, None))
    assert numbers["xy"] is numbers["cct_kelvin"] is numbers["ra"] is None


def test_sensitivities_are_drawn_and_listed(tmp_path):
    curves = LIGHTS.T
    plot = write_sensitivities(tmp_path / "sensitivities", curves, "A camera")
    assert plot == str(tmp_path / "sensitivities.png")
    table = np.genfromtxt(tmp_path / "sensitivities.csv", delimiter=",", names=True)
    np.testing.assert_allclose(np.stack([table[name] for name in "rgb"], -1), curves, rtol=1e-5)
    write_sensitivities(tmp_path / "two", np.hstack([curves, curves / 2]), "A camera", ["plain", "red glass"])
    table = np.genfromtxt(tmp_path / "two.csv", delimiter=",", names=True)
    np.testing.assert_allclose(table["g_2"], curves[:, 1] / 2, rtol=1e-5)


def test_a_direction_or_a_region_but_not_both(probe_file, tmp_path, capsys):
    region = region_file(tmp_path, "r", seed_deg=[330, -10])
    for at, path in ((None, None), ((0.0, 0.0), region)):
        with pytest.raises(SpectralProbeError, match="Give either a direction or a region"):
            finish(spectrum(probe_file, at, None, None, region_path=path))
    with pytest.raises(SystemExit):
        main(["spectrum", str(probe_file), "--at", "0,0", "--region", str(region)])
    assert "not allowed with argument" in capsys.readouterr().err


@pytest.mark.parametrize("bearing", [(10.0, 0.0), (269.9, 12.0), (0.0, 90.0), (200.0, -88.0), (33.3, 44.4)])
@pytest.mark.parametrize("radius_deg", [0.01, 0.5, 20.0, 90.0])
def test_a_discs_texels_are_those_near_enough(bearing, radius_deg):
    """The same as looking at every texel of the panorama."""
    closeness = panorama_directions(64, 128) @ bearing_to_direction(*bearing)
    expected = closeness >= min(np.cos(np.radians(radius_deg)), closeness.max())
    found = np.zeros((64, 128), bool)
    found[disc_texels(64, 128, *bearing, radius_deg)] = True
    assert np.array_equal(found, expected)

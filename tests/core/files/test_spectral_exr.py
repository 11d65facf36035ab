"""Spectral images: the layout of Fichet et al. and Indigo's channels, against files made by hand and colour-science's reader."""

import numpy as np
import OpenEXR
import pytest

from spectral_probe.commands import read_tristimulus, read_xyz
from spectral_probe.compare_command import compare
from spectral_probe.errors import FileFormatError, SpectralDataError
from spectral_probe.files.image_exr import write_channels
from spectral_probe.files.spectral_channels import spectrum_of_text, text_of_spectrum
from spectral_probe.files.spectral_exr import read_spectral, read_spectral_image, write_spectral
from spectral_probe.model import finish
from spectral_probe.spectra.colorimetry import illuminant, spectra_to_xyz, white_xyz
from spectral_probe.spectra.colour_science import colour
from spectral_probe.spectra.grid import WAVELENGTHS_NM

WIDE_NM = np.arange(380.0, 781.0, 10.0)


@pytest.fixture
def wide():
    """A spectral image on 380-780 nm."""
    return np.random.default_rng(21).uniform(0.1, 0.9, size=(3, 5, len(WIDE_NM))).astype(np.float32)


def written(path, channels, header=None):
    """A file with channels of one value each."""
    write_channels(
        path, {name: np.full((2, 3), value, np.float32) for name, value in channels.items()}, header
    )
    return path


@pytest.mark.parametrize("quantity", ["emissive", "reflective"])
def test_any_grid_comes_back(wide, tmp_path, quantity):
    valid = np.ones((3, 5), bool)
    valid[1, 2] = False
    shuffled = np.random.default_rng(1).permutation(len(WIDE_NM))
    path = tmp_path / "s.exr"
    write_spectral(
        path, wide[..., shuffled], WIDE_NM[shuffled], valid, quantity=quantity, attributes={"EV": 0.5}
    )
    image = read_spectral_image(path)
    assert np.array_equal(image.spectra, wide)
    assert np.array_equal(image.wavelengths_nm, WIDE_NM)
    assert np.array_equal(image.valid, valid)
    assert image.quantity == quantity
    assert image.attributes["EV"] == 0.5
    assert image.attributes["spectralLayoutVersion"] == "1.0"
    assert ("emissiveUnits" in image.attributes) == (quantity == "emissive")
    assert image.remarks == ()


@pytest.mark.parametrize(
    "name",
    ["S0.550,000000nm", "S0.550nm", "S0.550.5nm", "S0.5,5E2nm", "S0.0,55um", "S0.5.5e-7m", "S0.545,0771963636THz",
     "S0.5.450771963636e2THz", "left.S0.550,0nm"],
)  # fmt: skip
def test_every_way_to_write_a_wavelength(tmp_path, name):
    path = written(tmp_path / "s.exr", {name: 2.0, name.split("S0.")[0] + "S0.600,0nm": 3.0})
    spectra, wavelengths_nm = read_spectral(path)
    assert wavelengths_nm == pytest.approx([550.5 if "550.5" in name else 550.0, 600.0], abs=2e-6)
    assert spectra[0, 0].tolist() == [2.0, 3.0]


def test_frequencies_ascend_in_wavelength(tmp_path):
    path = written(tmp_path / "s.exr", {"S0.400THz": 1.0, "S0.700THz": 2.0, "S0.6,0e14Hz": 3.0})
    spectra, wavelengths_nm = read_spectral(path)
    assert wavelengths_nm == pytest.approx(299_792.458 / np.array([700, 600, 400]), abs=1e-6)
    assert spectra[0, 0].tolist() == [2.0, 3.0, 1.0]


def test_of_polarised_light_the_intensity_is_read_and_said(tmp_path):
    channels = {f"S{k}.{nm},0nm": 10.0 * k + nm for k in range(4) for nm in (500, 600)}
    image = read_spectral_image(written(tmp_path / "s.exr", channels, {"polarisationHandedness": "left"}))
    assert image.spectra[1, 1].tolist() == [500.0, 600.0]
    assert image.remarks == ("s.exr is polarised: its intensity S0 is used, S1 to S3 are not.",)
    assert image.attributes["polarisationHandedness"] == "left"


def test_emissive_and_reflective_in_one_file(tmp_path):
    path = written(tmp_path / "s.exr", {"S0.500nm": 5.0, "S0.600nm": 6.0, "T.500nm": 0.1, "T.600nm": 0.2})
    emissive, reflective = read_spectral_image(path), read_spectral_image(path, "reflective")
    assert emissive.spectra[0, 0].tolist() == [5.0, 6.0]
    assert reflective.spectra[0, 0] == pytest.approx([0.1, 0.2])
    assert "its emissive part is used" in emissive.remarks[0]
    with pytest.raises(FileFormatError, match="holds reflectances, but no emissive channels"):
        read_spectral_image(written(tmp_path / "t.exr", {"T.500nm": 0.1, "T.600nm": 0.2}), "emissive")


def test_header_attributes_of_the_layout_are_kept(tmp_path):
    response = text_of_spectrum(WAVELENGTHS_NM, illuminant("A"))
    header = {
        "EV": 1.25,
        "cameraResponse": response,
        "lensTransmission": "400nm:0.9;700nm:0.95",
        "owner": "x",
    }
    image = read_spectral_image(written(tmp_path / "s.exr", {"S0.400nm": 1.0, "S0.700nm": 1.0}, header))
    assert image.attributes == {key: header[key] for key in ("EV", "cameraResponse", "lensTransmission")}
    wavelengths_nm, values = spectrum_of_text(image.attributes["cameraResponse"])
    np.testing.assert_allclose(wavelengths_nm, WAVELENGTHS_NM)
    np.testing.assert_allclose(values, illuminant("A"), rtol=1e-8)
    with pytest.raises(FileFormatError, match='"400nm" is no sample of a spectrum'):
        spectrum_of_text("400nm;500nm:1")


def test_indigos_buckets_stand_for_their_middles(tmp_path):
    path = written(tmp_path / "i.exr", {f"wavelength{nm}": nm for nm in (400, 500, 600)})
    spectra, wavelengths_nm = read_spectral(path)
    assert wavelengths_nm.tolist() == [450.0, 550.0, 650.0]
    assert spectra[0, 0].tolist() == [400.0, 500.0, 600.0]
    path = written(tmp_path / "i.exr", {"wavelength400": 1, "wavelength430_25": 2, "R": 9, "alpha": 1})
    assert read_spectral(path)[1].tolist() == [415.125, 445.375]
    path = written(tmp_path / "i.exr", {"spectral.wavelength400": 1, "spectral.wavelength430.5": 2})
    assert read_spectral(path)[1].tolist() == [415.25, 445.75]


@pytest.mark.parametrize(
    ("channels", "message"),
    [
        (["T.400nm", "T.500nm", "T.400,0nm.500,0nm"], "s.exr is bispectral"),
        (["T.400,0nm.500,0nm"], "s.exr is bispectral"),
        (["S0.500nm", "S0.500,0nm"], "for 500 nm. Give each wavelength once"),
        (["a.S0.500nm", "b.S0.500nm"], r"in several layers \(a, b\)"),
        (["wavelength400"], "has one wavelength only"),
        (["S1.500nm", "S2.500nm"], "is no spectral image"),
        (["R", "G", "B", "S0.nm", "S0.0nm"], "is no spectral image"),
    ],
)
def test_files_that_cannot_be_used_are_explained(tmp_path, channels, message):
    with pytest.raises(FileFormatError, match=message):
        read_spectral_image(written(tmp_path / "s.exr", dict.fromkeys(channels, 1.0)))


def test_what_cannot_be_written_is_explained(tmp_path):
    with pytest.raises(SpectralDataError, match="does not fit 3 wavelengths"):
        write_spectral(tmp_path / "s.exr", np.ones((2, 2, 2)), np.array([400.0, 500.0, 600.0]))
    with pytest.raises(SpectralDataError, match="Two wavelengths of the spectral image are the same"):
        write_spectral(tmp_path / "s.exr", np.ones((2, 2, 2)), np.array([400.0, 400.0]))
    assert not list(tmp_path.iterdir())


def test_values_that_are_no_numbers_are_not_valid(wide, tmp_path):
    wide[0, 0, 7], wide[2, 4, 0] = np.nan, np.inf
    write_spectral(tmp_path / "s.exr", wide, WIDE_NM)
    expected = np.ones((3, 5), bool)
    expected[0, 0] = expected[2, 4] = False
    assert np.array_equal(read_spectral_image(tmp_path / "s.exr").valid, expected)


# ---------------------------------------------------------------- as an image of colours


def test_a_wider_grid_is_cut(tmp_path):
    light = illuminant("A").astype(np.float32)
    narrow, wide_nm = np.broadcast_to(light, (2, 2, 61)), np.arange(300.0, 831.0, 5.0)
    wider = np.full((2, 2, len(wide_nm)), 1e4, np.float32)  # far too much where it must not count
    wider[..., (wide_nm >= 400) & (wide_nm <= 700)] = light
    write_spectral(tmp_path / "narrow.exr", narrow, WAVELENGTHS_NM)
    write_spectral(tmp_path / "wider.exr", wider, wide_nm)
    np.testing.assert_allclose(read_xyz(tmp_path / "wider.exr"), read_xyz(tmp_path / "narrow.exr"), rtol=1e-5)
    np.testing.assert_allclose(read_xyz(tmp_path / "narrow.exr")[0, 0], spectra_to_xyz(light), rtol=1e-3)


def test_buckets_reach_half_a_step_beyond_their_middles(tmp_path):
    path = written(tmp_path / "i.exr", {f"wavelength{nm}": 2.0 for nm in range(400, 700, 10)})
    assert read_xyz(path)[1, 2] == pytest.approx(spectra_to_xyz(np.full(61, 2.0)), rel=1e-5)
    path = written(tmp_path / "j.exr", {f"wavelength{nm}": 2.0 for nm in range(410, 700, 10)})
    with pytest.raises(SpectralDataError, match="covers 410-700 nm, but 400-700 nm is needed"):
        read_xyz(path)


def test_a_preview_beside_the_spectrum_does_not_count(tmp_path):
    channels = {f"S0.{nm}nm": 2.0 for nm in (380, 780)} | {"R": 9.0, "G": 9.0, "B": 9.0}
    found = read_xyz(written(tmp_path / "s.exr", channels))[0, 0]
    assert found == pytest.approx(spectra_to_xyz(np.full(61, 2.0)))


def test_reflectances_are_seen_under_d65(tmp_path):
    image = read_tristimulus(written(tmp_path / "t.exr", {"T.400nm": 0.5, "T.700nm": 0.5}))
    assert image.xyz[0, 0] == pytest.approx(0.5 * white_xyz(), rel=1e-5)
    assert image.remarks == ("t.exr holds reflectances: they are shown under D65.",)


def test_compare_says_what_it_did_not_use(tmp_path):
    channels = {f"S{k}.{nm}nm": 1.0 for k in range(4) for nm in (380, 780)}
    written(tmp_path / "polarised.exr", channels)
    write_channels(tmp_path / "rgb.exr", {name: np.ones((2, 3), np.float32) for name in "RGB"})
    numbers = finish(compare(tmp_path / "polarised.exr", tmp_path / "rgb.exr", tmp_path / "out"))
    assert numbers["remarks"] == ["polarised.exr is polarised: its intensity S0 is used, S1 to S3 are not."]


# ---------------------------------------------------------------- against colour-science's reader and writer


@pytest.mark.parametrize(("quantity", "component"), [("emissive", "S0"), ("reflective", "T")])
def test_colour_science_reads_what_we_write(wide, tmp_path, quantity, component):
    wavelengths_nm = WIDE_NM + 0.125
    path = tmp_path / "s.exr"
    write_spectral(path, wide, wavelengths_nm, quantity=quantity)
    components, specification = colour.read_spectral_image_Fichet2021(path, additional_data=True)
    assert list(components) == [component]
    order = np.argsort(components[component][0])
    np.testing.assert_allclose(components[component][0][order], wavelengths_nm)
    assert np.array_equal(components[component][1][..., order], wide)
    assert specification.is_emissive == (quantity == "emissive")
    assert not specification.is_polarised
    attributes = {attribute.name: attribute.value for attribute in specification.attributes}
    assert attributes["spectralLayoutVersion"] == "1.0"


@pytest.mark.filterwarnings("ignore:Aligning")  # of a light for the preview that colour-science adds
def test_we_read_what_colour_science_writes(tmp_path):
    path = tmp_path / "checker.exr"
    chart = colour.SDS_COLOURCHECKERS["ISO 17321-1"]
    colour.write_spectral_image_Fichet2021(chart.values(), str(path), "float32", shape=(4, 6, -1))
    image = read_spectral_image(path)
    assert image.quantity == "reflective"
    assert image.spectra.shape[:2] == (4, 6)
    first = next(iter(chart.values()))
    wanted = np.interp(image.wavelengths_nm, first.wavelengths, first.values)
    np.testing.assert_allclose(image.spectra[0, 0], wanted, atol=1e-6)
    assert set(OpenEXR.File(str(path), separate_channels=True).channels()) > {"R", "G", "B"}
    light = colour.SDS_ILLUMINANTS["D65"]
    specification = colour.io.Specification_Fichet2021(is_emissive=True)
    colour.write_spectral_image_Fichet2021(light, str(path), "float32", specification=specification)
    image = read_spectral_image(path)
    assert image.quantity == "emissive"
    np.testing.assert_allclose(image.spectra[0, 0], light.values, rtol=1e-6)
    np.testing.assert_allclose(image.wavelengths_nm, light.wavelengths)
    assert isinstance(image.attributes["EV"], float)

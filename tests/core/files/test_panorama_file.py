import numpy as np
import pytest

from spectral_probe.errors import FileFormatError, SpectralDataError
from spectral_probe.files.image_exr import write_channels, write_rgb
from spectral_probe.files.panorama_file import read_panorama
from spectral_probe.files.probe_exr import write_probe
from spectral_probe.files.spectral_exr import read_spectral_image, write_spectral
from spectral_probe.model import SpectralPanorama, finish
from spectral_probe.spectra.colorimetry import illuminant
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.library import surface_reflectances, training_lights
from spectral_probe.spectrum_command import spectrum

WIDE_NM = np.arange(380.0, 781.0, 5.0)


def recovered(panorama):
    return panorama.weights @ panorama.bases[0]


@pytest.fixture
def room():
    """Light of four lamps off 24 surfaces, a lamp ten thousand times brighter among them, (16, 32, 61)."""
    rng = np.random.default_rng(31)
    lamps = np.stack([illuminant(name) / illuminant(name).mean() for name in ("A", "D65", "FL2", "LED-B3")])
    spectra = rng.uniform(size=(16, 32, 4)) @ lamps
    spectra = spectra * surface_reflectances()[rng.integers(0, 24, (16, 32))]
    spectra[3, 4] = 1e4 * lamps[0]
    return spectra.astype(np.float32)


def test_a_probe_stays_what_it_is(tmp_path):
    rng = np.random.default_rng(1)
    panorama = SpectralPanorama(
        rng.normal(size=(4, 8, 3)).astype(np.float32),
        rng.uniform(size=(1, 3, 61)),
        np.zeros((4, 8), np.uint8),
        WAVELENGTHS_NM,
        np.ones((4, 8), bool),
        rng.uniform(size=(4, 8)).astype(np.float32),
    )
    write_probe(tmp_path / "probe.exr", panorama)
    back = read_panorama(tmp_path / "probe.exr")
    assert np.array_equal(back.weights, panorama.weights)
    assert np.array_equal(back.bases, panorama.bases)


def test_light_of_few_spectra_comes_back_exactly(tmp_path):
    lights = training_lights(["fluorescent-triband"])[:5]
    spectra = np.random.default_rng(2).uniform(size=(8, 16, 5)) @ lights
    valid = np.ones((8, 16), bool)
    valid[-1] = False
    write_spectral(tmp_path / "s.exr", spectra.astype(np.float32), WAVELENGTHS_NM, valid)
    panorama = read_panorama(tmp_path / "s.exr")
    written = read_spectral_image(tmp_path / "s.exr").spectra
    assert panorama.bases.shape[1] <= 6
    assert np.array_equal(panorama.valid, valid)
    assert np.array_equal(panorama.confidence, valid)
    error = np.linalg.norm(recovered(panorama) - written, axis=-1) / np.linalg.norm(written, axis=-1)
    assert error[valid].max() < 2e-3  # 16-bit pixels


def test_a_bright_lamp_does_not_spoil_the_rest(room, tmp_path):
    write_spectral(tmp_path / "s.exr", room, WAVELENGTHS_NM)
    panorama = read_panorama(tmp_path / "s.exr")
    assert panorama.bases.shape[1] <= 12
    error = np.linalg.norm(recovered(panorama) - room, axis=-1) / np.linalg.norm(room, axis=-1)
    assert np.median(error) < 0.015  # of 96 spectra in 12
    assert error.max() < 0.05
    assert error[3, 4] < 1e-3
    assert float(panorama.provenance["residual"]) < 1e-5


def test_a_panorama_of_indigos_buckets_gives_its_spectrum(tmp_path):
    light = np.interp(WIDE_NM + 2.5, WAVELENGTHS_NM, illuminant("A"))
    planes = {
        f"wavelength{nm:g}": np.full((16, 32), value, np.float32)
        for nm, value in zip(WIDE_NM, light, strict=True)
    }
    write_channels(tmp_path / "indigo.exr", planes)
    numbers = finish(spectrum(tmp_path / "indigo.exr", (10.0, 20.0), None, None))
    assert numbers["cct_kelvin"] == pytest.approx(2864, abs=3)
    assert numbers["confidence"] == 1.0


def test_what_is_no_panorama_is_explained(tmp_path):
    write_spectral(tmp_path / "square.exr", np.ones((4, 4, 61)), WAVELENGTHS_NM)
    with pytest.raises(
        FileFormatError, match=r"square\.exr is 4 x 4 pixels, but a panorama is twice as wide"
    ):
        read_panorama(tmp_path / "square.exr")
    write_spectral(tmp_path / "t.exr", np.ones((2, 4, 61)), WAVELENGTHS_NM, quantity="reflective")
    with pytest.raises(FileFormatError, match="holds reflectances, but no emissive"):
        read_panorama(tmp_path / "t.exr")
    write_spectral(tmp_path / "narrow.exr", np.ones((2, 4, 3)), np.array([450.0, 500.0, 550.0]))
    with pytest.raises(SpectralDataError, match=r"narrow\.exr covers .* but 400-700 nm is needed"):
        read_panorama(tmp_path / "narrow.exr")
    write_rgb(tmp_path / "rgb.exr", np.ones((2, 4, 3)))
    with pytest.raises(FileFormatError, match=r"was not written as a probe\.exr"):
        read_panorama(tmp_path / "rgb.exr")

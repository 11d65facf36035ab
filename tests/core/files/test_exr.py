import resource
from dataclasses import replace

import numpy as np
import OpenEXR
import pytest

from spectral_probe.errors import FileFormatError
from spectral_probe.files.image_exr import read_rgb, write_channels, write_rgb
from spectral_probe.files.probe_exr import read_layers, read_probe, write_layers, write_probe
from spectral_probe.files.spectral_exr import read_spectral, write_spectral, write_spectral_panorama
from spectral_probe.model import SpectralPanorama
from spectral_probe.render_model import LightLayers
from spectral_probe.spectra.grid import WAVELENGTHS_NM


@pytest.fixture
def panorama():
    rng = np.random.default_rng(11)
    return SpectralPanorama(
        weights=rng.normal(size=(8, 16, 4)).astype(np.float32),
        bases=rng.uniform(size=(2, 4, 61)),
        basis_index=rng.integers(0, 2, size=(8, 16)).astype(np.uint8),
        wavelengths_nm=WAVELENGTHS_NM,
        valid=rng.random((8, 16)) > 0.3,
        confidence=rng.random((8, 16)).astype(np.float32),
        provenance={"camera": "Nikon 5100 (NPL)"},
    )


def test_a_probe_comes_back_bit_for_bit(panorama, tmp_path):
    write_probe(tmp_path / "probe.exr", panorama)
    back = read_probe(tmp_path / "probe.exr")
    for field in ("weights", "bases", "basis_index", "wavelengths_nm", "valid", "confidence"):
        assert np.array_equal(getattr(back, field), getattr(panorama, field)), field
    assert back.provenance == panorama.provenance
    channels = set(OpenEXR.File(str(tmp_path / "probe.exr"), separate_channels=True).channels())
    assert channels == {"eps.0", "eps.1", "eps.2", "eps.3", "valid", "confidence", "basis_index"}


def test_the_error_of_directions_comes_back(panorama, tmp_path):
    error = np.linspace(0, np.pi, 128, dtype=np.float32).reshape(8, 16)
    write_probe(tmp_path / "probe.exr", replace(panorama, direction_error_rad=error))
    assert np.array_equal(read_probe(tmp_path / "probe.exr").direction_error_rad, error)
    write_probe(tmp_path / "probe.exr", panorama)
    assert read_probe(tmp_path / "probe.exr").direction_error_rad is None


def test_a_full_disk_is_one_sentence_and_leaves_no_file(tmp_path):
    """A limit on the size of files fails writing as a full disk does."""
    noise = np.random.default_rng(13).random((200, 200)).astype(np.float32)
    _, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, hard))
    try:
        with pytest.raises(FileFormatError, match="Make room") as caught:
            write_channels(tmp_path / "noise.exr", {"Y": noise})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))
    assert "\n" not in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_layers_come_back(tmp_path):
    rng = np.random.default_rng(12)
    layers = LightLayers(
        rng.random((4, 8, 3)).astype(np.float32), rng.normal(size=(3, 61)), WAVELENGTHS_NM, 0.01
    )
    write_layers(tmp_path / "layers.exr", layers)
    back = read_layers(tmp_path / "layers.exr")
    assert np.array_equal(back.weights, layers.weights)
    assert np.array_equal(back.spectra, layers.spectra)
    assert back.residual == 0.01


def test_a_spectral_panorama_holds_the_spectra(panorama, tmp_path):
    write_spectral_panorama(tmp_path / "spectral.exr", panorama)
    spectra, wavelengths = read_spectral(tmp_path / "spectral.exr")
    assert np.array_equal(wavelengths, WAVELENGTHS_NM)
    expected = np.einsum("hwk,hwkl->hwl", panorama.weights, panorama.bases[panorama.basis_index])
    assert np.abs(spectra - expected).max() < 2e-3 * np.abs(expected).max()  # 16-bit floats
    file = OpenEXR.File(str(tmp_path / "spectral.exr"), separate_channels=True)
    assert "S0.550,000000nm" in file.channels()
    assert file.header()["spectralLayoutVersion"] == "1.0"
    assert file.header()["emissiveUnits"] == "W.m^-2.sr^-1.nm^-1"


def test_faint_and_bright_spectra_keep_their_precision(tmp_path):
    for scale in (1e-6, 1e6):
        spectra = scale * np.random.default_rng(13).uniform(size=(4, 4, 61)).astype(np.float32)
        write_spectral(tmp_path / "s.exr", spectra, WAVELENGTHS_NM)
        assert np.array_equal(read_spectral(tmp_path / "s.exr")[0], spectra)


def test_a_failed_write_leaves_the_old_file(tmp_path):
    path = tmp_path / "a.exr"
    write_rgb(path, np.ones((2, 2, 3)))
    mismatched = {"R": np.zeros((2, 2), np.float32), "G": np.zeros((3, 5), np.float32)}
    with pytest.raises((ValueError, RuntimeError)):
        write_channels(path, mismatched)
    assert np.array_equal(read_rgb(path), np.ones((2, 2, 3), np.float32))
    assert [file.name for file in tmp_path.iterdir()] == ["a.exr"]


def test_wrong_files_are_explained(tmp_path):
    picture, text = tmp_path / "rgb.exr", tmp_path / "text.exr"
    write_rgb(picture, np.ones((2, 2, 3)))
    text.write_text("no picture")
    with pytest.raises(FileFormatError, match=r"There is no file"):
        read_probe(tmp_path / "none.exr")
    with pytest.raises(FileFormatError, match="is not an OpenEXR image"):
        read_probe(text)
    with pytest.raises(FileFormatError, match=r"was not written as a probe\.exr"):
        read_probe(picture)
    with pytest.raises(FileFormatError, match=r"was not written as a layers\.exr"):
        read_layers(picture)
    with pytest.raises(FileFormatError, match="is no spectral image"):
        read_spectral(picture)
    with pytest.raises(FileFormatError, match="has no channels X, Y, Z"):
        read_rgb(picture, ("X", "Y", "Z"))
    picture.write_bytes(picture.read_bytes()[:200])
    with pytest.raises(FileFormatError, match="cannot be read: it is cut short"):
        read_rgb(picture)

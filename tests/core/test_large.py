"""What is done strip by strip is what is done at once, and arrays in files are let go without losing what they hold."""

import resource
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from spectral_probe import large, parallel
from spectral_probe.figures.display import exposure_for_key
from spectral_probe.figures.panorama import panorama_preview
from spectral_probe.geometry.sphere import fill_unknown, resized
from spectral_probe.large import large_array, let_go, strips
from spectral_probe.model import SpectralPanorama
from spectral_probe.render.layers import light_layers
from spectral_probe.spectra import chromaticity_noise
from spectral_probe.spectra.chromaticity_noise import without_chromaticity_noise
from spectral_probe.spectra.colorimetry import panorama_rec709
from spectral_probe.spectra.grid import WAVELENGTHS_NM

HEIGHT, WIDTH = 64, 128


@pytest.fixture
def panorama():
    rng = np.random.default_rng(5)
    base = np.exp(-((np.linspace(-2, 2, 61) - np.array([[-1.0], [0.0], [1.0]])) ** 2))
    return SpectralPanorama(
        weights=rng.exponential(size=(HEIGHT, WIDTH, 3)).astype(np.float32),
        bases=np.stack([base, base[::-1] ** 2]),
        basis_index=rng.integers(0, 2, (HEIGHT, WIDTH)).astype(np.uint8),
        wavelengths_nm=WAVELENGTHS_NM,
        valid=rng.random((HEIGHT, WIDTH)) < 0.8,
        confidence=rng.random((HEIGHT, WIDTH)).astype(np.float32),
    )


def in_strips(monkeypatch):
    monkeypatch.setattr(large, "TEXELS_A_STRIP", 8 * WIDTH)
    assert len(strips(HEIGHT, WIDTH)) == 8


def test_an_array_in_a_file_keeps_what_was_let_go(monkeypatch):
    monkeypatch.setattr(large, "LARGEST_IN_MEMORY_BYTES", 1000)
    array = large_array((512, 1024))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_majflt
    assert not array.any()
    array[:] = np.arange(1024)
    let_go(array[3:5])  # of a part of it the whole goes
    assert (array == np.arange(1024)).all()
    assert array.dtype == np.float32
    assert resource.getrusage(resource.RUSAGE_SELF).ru_majflt >= before


@pytest.mark.skipif(sys.platform != "linux", reason="other systems tell it otherwise")
def test_pages_that_were_let_go_are_not_resident(monkeypatch):
    monkeypatch.setattr(large, "LARGEST_IN_MEMORY_BYTES", 1000)
    array = large_array((64, 1 << 20))

    def resident_mb():
        return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() / 1e6

    start = resident_mb()
    for row in array:
        row[:] = 1.0
        let_go(array)
        assert resident_mb() < start + 100
    assert float(array[:, ::4096].sum()) == 64 * 256


def test_without_room_in_files_arrays_are_in_memory(monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(large, "LARGEST_IN_MEMORY_BYTES", 1000)
    monkeypatch.setattr(large.os, "posix_fallocate", full)
    array = large_array((64, 64))
    array[:] = 2
    let_go(array)
    assert float(array.sum()) == 2 * 64 * 64


def test_layers_by_parts_are_those_at_once(panorama, monkeypatch):
    whole = light_layers(panorama)
    monkeypatch.setattr(parallel, "_TEXELS_AT_A_TIME", 4 * WIDTH)
    assert len(parallel.row_blocks(WIDTH)) == 16
    parts = light_layers(panorama)
    np.testing.assert_allclose(parts.weights, whole.weights, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(parts.spectra, whole.spectra, rtol=1e-9)
    assert parts.residual == pytest.approx(whole.residual, rel=1e-9)


def test_colours_by_strips_are_those_at_once(panorama, monkeypatch):
    whole, picture = panorama_rec709(panorama), panorama_preview(panorama, max_width_px=32)
    rows = panorama_rec709(panorama, slice(10, 30))
    np.testing.assert_allclose(rows, whole[10:30], rtol=1e-6)
    in_strips(monkeypatch)
    np.testing.assert_allclose(panorama_rec709(panorama), whole, rtol=1e-6)
    shown = panorama_preview(panorama, max_width_px=32)
    assert np.abs(shown.astype(int) - picture).max() <= 1


def test_the_median_of_many_is_the_one_that_sorting_finds(monkeypatch):
    rng = np.random.default_rng(7)
    luminance = rng.lognormal(sigma=3, size=(HEIGHT, WIDTH)).astype(np.float32)
    valid = rng.random(luminance.shape) < 0.7
    weights = rng.random((HEIGHT, 1))
    whole = exposure_for_key(luminance, valid, weights), exposure_for_key(luminance, valid)
    in_strips(monkeypatch)
    monkeypatch.setattr("spectral_probe.figures.display.TEXELS_A_STRIP", 8 * WIDTH)
    assert (exposure_for_key(luminance, valid, weights), exposure_for_key(luminance, valid)) == whole


def test_colour_noise_taken_out_by_strips_is_as_at_once(monkeypatch):
    rng = np.random.default_rng(9)
    seen = rng.lognormal(sigma=0.5, size=(HEIGHT, WIDTH, 3)).astype(np.float32)
    variance = 0.01 * seen
    monkeypatch.setattr(chromaticity_noise, "_LARGEST_WIDTH", WIDTH // 2)
    whole = without_chromaticity_noise(seen, variance)
    in_strips(monkeypatch)
    np.testing.assert_allclose(without_chromaticity_noise(seen.copy(), variance), whole, rtol=2e-6)
    own = seen.copy()
    assert without_chromaticity_noise(own, variance, in_place=True) is own
    np.testing.assert_allclose(own, whole, rtol=2e-6)


def test_filling_by_strips_is_as_at_once(monkeypatch):
    rng = np.random.default_rng(11)
    values, known = rng.random((HEIGHT, WIDTH, 2)).astype(np.float32), rng.random((HEIGHT, WIDTH)) < 0.6
    monkeypatch.setattr("spectral_probe.geometry.sphere._FILL_WIDTH", WIDTH // 2)
    whole = fill_unknown(values, known)
    in_strips(monkeypatch)
    assert np.array_equal(fill_unknown(values, known), whole)
    own = values.copy()
    assert fill_unknown(own, known, in_place=True) is own
    assert np.array_equal(own, whole)


def test_rows_made_larger_are_those_of_the_whole():
    values = np.random.default_rng(13).random((16, 32, 3)).astype(np.float32)
    assert np.array_equal(resized(values, 200, slice(40, 71)), resized(values, 200)[40:71])
    assert np.array_equal(resized(values, 16, slice(2, 5)), resized(values, 16)[2:5])


def test_the_posterior_of_many_texels_is_the_same_by_strips(panorama, monkeypatch):
    from spectral_probe.spectra.camera import camera_sensitivities
    from spectral_probe.spectra.recorded import ENTRY, light_posterior, record
    from spectral_probe.spectra.recovery import spectral_recovery

    recovery = spectral_recovery(camera_sensitivities("Nikon 5100 (NPL)"), ["incandescent", "daylight"])
    count = recovery.bases.shape[1]
    weights = np.zeros((HEIGHT, WIDTH, count), np.float32)
    weights[..., :3] = panorama.weights
    index = (panorama.basis_index % len(recovery.bases)).astype(np.uint8)
    probe = replace(
        panorama,
        weights=weights,
        basis_index=index,
        bases=recovery.bases,
        further={ENTRY: record([(0, recovery)], 1.0)},
    )
    whole = light_posterior(probe, probe.valid)
    in_strips(monkeypatch)
    parts = light_posterior(probe, probe.valid)
    np.testing.assert_allclose(parts.mean, whole.mean, rtol=1e-6)
    np.testing.assert_allclose(parts.covariance, whole.covariance, rtol=1e-6, atol=1e-12)

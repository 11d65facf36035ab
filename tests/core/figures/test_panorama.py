import numpy as np
import pytest

from spectral_probe.figures.panorama import draw_panorama, panorama_preview
from spectral_probe.figures.style import house_style, new_figure
from spectral_probe.model import SpectralPanorama
from spectral_probe.spectra.colorimetry import illuminant, panorama_xyz, spectra_to_xyz
from spectral_probe.spectra.grid import WAVELENGTHS_NM


@pytest.fixture
def panorama():
    """Two bases: daylight in the left half, incandescent in the right; a hole below."""
    bases = np.stack([np.stack([illuminant("D65"), np.ones(61)]), np.stack([illuminant("A"), np.ones(61)])])
    weights = np.ones((16, 32, 2), np.float32) * np.array([0.01, 0.2], np.float32)
    index = np.zeros((16, 32), np.uint8)
    index[:, 16:] = 1
    weights[3, 5] *= 1000  # a lamp
    valid = np.ones((16, 32), bool)
    valid[12:, 8:24] = False
    return SpectralPanorama(weights, bases, index, WAVELENGTHS_NM, valid, valid.astype(np.float32))


def test_xyz_of_every_pixel_is_that_of_its_spectrum(panorama):
    spectra = np.einsum("hwk,hwkl->hwl", panorama.weights, panorama.bases[panorama.basis_index])
    np.testing.assert_allclose(panorama_xyz(panorama), spectra_to_xyz(spectra), rtol=1e-4)


def test_other_wavelength_grids_give_the_same_colours(panorama):
    nm = np.arange(380.0, 781.0, 1.0)
    bases = np.stack([[np.interp(nm, WAVELENGTHS_NM, row) for row in basis] for basis in panorama.bases])
    finer = SpectralPanorama(
        panorama.weights, bases, panorama.basis_index, nm, panorama.valid, panorama.confidence
    )
    np.testing.assert_allclose(panorama_xyz(finer), panorama_xyz(panorama), rtol=1e-5)


def test_preview_is_exposed_for_the_room_and_marks_what_is_unseen(panorama):
    picture = panorama_preview(panorama)
    assert picture.shape == (16, 32, 3)
    assert picture.dtype == np.uint8
    lamp = picture[3, 5].astype(int)
    left, right = picture[5, 4].astype(int), picture[5, 28].astype(int)
    assert lamp.min() > 240
    assert 60 < left.mean() < 190
    assert right[0] - right[2] > left[0] - left[2] + 40  # incandescent is redder than daylight
    unseen = picture[~panorama.valid].astype(int)
    assert (np.ptp(unseen, axis=1) == 0).all()  # no colour is claimed
    assert len(np.unique(unseen[:, 0])) >= 2  # hatched
    brighter = panorama_preview(panorama, exposure=10.0)
    assert brighter[5, 4].min() > left.max()


def test_wide_panoramas_are_reduced_in_linear_light():
    weights = np.zeros((8, 16, 1), np.float32)
    weights[:, ::2] = 1.0
    valid = np.ones((8, 16), bool)
    basis = illuminant("D65")[None, None] / 100
    panorama = SpectralPanorama(
        weights, basis, np.zeros((8, 16), np.uint8), WAVELENGTHS_NM, valid, np.ones((8, 16), np.float32)
    )
    level = 0.3 / float(spectra_to_xyz(basis[0, 0])[1])
    small = panorama_preview(panorama, exposure=2 * level, max_width_px=8)
    assert small.shape == (4, 8, 3)
    np.testing.assert_allclose(small, 255 * (1.055 * 0.3 ** (1 / 2.4) - 0.055), atol=3)


def test_bearings_are_where_blender_has_them(panorama):
    with house_style():
        axes = new_figure(4, 2).add_axes((0, 0, 1, 1))
        draw_panorama(axes, panorama_preview(panorama))
    # Blender's equirectangular: u = 0.5 - atan2(y, x) / 2 pi, so +Y (bearing 0) is at a quarter, +X (90) in the middle.
    left, right = axes.get_xlim()
    for bearing_deg, u in ((0, 0.25), (90, 0.5), (180, 0.75)):
        assert (bearing_deg - left) / (right - left) == pytest.approx(u)
    labels = dict(zip(axes.get_xticks(), (label.get_text() for label in axes.get_xticklabels()), strict=True))
    assert labels[0] == "0°"
    assert labels[-45] == "315°"

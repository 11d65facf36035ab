"""Kinds of light as a picture: the colours say what the recovery says."""

import numpy as np
import pytest

from spectral_probe.errors import FileFormatError
from spectral_probe.figures.kinds import kinds_preview
from spectral_probe.model import SpectralPanorama
from spectral_probe.spectra.camera import camera_sensitivities
from spectral_probe.spectra.colorimetry import illuminant
from spectral_probe.spectra.edits import apply_edit, lamp_edit
from spectral_probe.spectra.grid import STEP_NM, WAVELENGTHS_NM
from spectral_probe.spectra.recorded import ENTRY, REPLACED, light_kinds, record
from spectral_probe.spectra.recovery import spectral_recovery


@pytest.fixture(scope="module")
def panorama():
    """Bright light of a filament on the left and of daylight on the right, recovered; the lowest rows unseen."""
    camera = camera_sensitivities("Nikon 5100 (NPL)")
    recovery = spectral_recovery(camera, ["incandescent", "daylight"])
    lights = np.stack([illuminant("A"), illuminant("D65")])[[0] * 16 + [1] * 16][None].repeat(16, 0)
    found = recovery.recover(lights @ camera * STEP_NM)
    valid = np.ones((16, 32), bool)
    valid[-3:] = False
    return SpectralPanorama(
        found.weights,
        recovery.bases,
        found.basis_index,
        WAVELENGTHS_NM,
        valid,
        found.confidence,
        further={ENTRY: record([(0, recovery)], 1e-6)},
    )


def test_each_texel_has_the_kind_of_its_light(panorama):
    kinds = light_kinds(panorama)
    assert {kinds.names[number] for number in np.unique(kinds.index[:, :16])} == {"incandescent"}
    assert {kinds.names[number] for number in np.unique(kinds.index[:, 16:])} == {"daylight"}
    assert kinds.probability.min() > 0.3
    assert kinds.probability.max() <= 1 + 1e-6


def test_a_replaced_lamp_is_told(panorama):
    left = np.arange(32)[None].repeat(16, 0) < 8
    kinds = light_kinds(apply_edit(panorama, lamp_edit(panorama, "LED-B3", "left"), left))
    assert np.array_equal(kinds.index == kinds.names.index(REPLACED), left)


def test_the_picture_has_a_colour_for_each_and_a_legend(panorama):
    picture = kinds_preview(panorama)
    assert picture.shape[1] == 640
    assert 320 < len(picture) < 420
    left, right = picture[100, 100].astype(int), picture[100, 500].astype(int)
    assert np.ptp(left) > 30
    assert np.ptp(right) > 30
    assert np.abs(left - right).max() > 60
    unseen = picture[315, 300]
    assert unseen.max() == unseen.min()


def test_a_panorama_of_another_program_has_no_kinds(panorama):
    from dataclasses import replace

    with pytest.raises(FileFormatError, match="does not tell how its light was recovered"):
        kinds_preview(replace(panorama, further={}))

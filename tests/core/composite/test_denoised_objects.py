"""A denoised render gives the composite its objects, and nothing else."""

import numpy as np
import pytest

from spectral_probe.composite.denoised_objects import denoised_in_camera, denoised_xyz
from spectral_probe.composite_model import ObjectCoverage
from spectral_probe.files.image_exr import write_rgb
from spectral_probe.render.outputs import DENOISED_NOTE, picture_header, picture_rgb
from spectral_probe.spectra.camera import camera_sensitivities
from spectral_probe.spectra.colorimetry import spectra_to_xyz, white_xyz
from spectral_probe.spectra.grid import STEP_NM, WAVELENGTHS_NM
from spectral_probe.spectra.library import planck
from spectral_probe.spectra.white import parse_white
from spectral_probe.spectra.working_space import working_space

SIZE = 40
NIKON = "Nikon 5100 (NPL)"
PICTURE = np.random.default_rng(2).uniform(0.1, 0.9, (8, 9, 1)) * white_xyz()


def denoise(folder, xyz, *, white="A", note=DENOISED_NOTE):
    """image.exr as a render leaves it: adapted, and said to be denoised."""
    stated = parse_white(white)
    header = picture_header(working_space(), stated, "of a test")
    header["comments"] += f"; {note}"
    write_rgb(folder / "image.exr", picture_rgb(xyz, working_space(), stated), header=header)


@pytest.mark.parametrize("note", ["", "no denoising"])
def test_an_image_that_was_not_denoised_is_not_taken(tmp_path, note):
    assert denoised_xyz(tmp_path) is None
    denoise(tmp_path, PICTURE, note=note)
    assert denoised_xyz(tmp_path) is None


def test_adaptation_is_undone(tmp_path):
    denoise(tmp_path, PICTURE, white="A")
    np.testing.assert_allclose(denoised_xyz(tmp_path), PICTURE, rtol=1e-4)


def test_two_metals_under_noise_are_told_apart():
    """Two coloured halves, noise of 30 %: within 1 % of what the camera sees without noise, also where they meet."""
    random = np.random.default_rng(3)
    light = planck(2856.0)
    left = np.zeros((SIZE, SIZE), np.float32)
    left[:, : SIZE // 2] = 1
    colours = [np.linspace(0.2, 0.9, 61), np.where(WAVELENGTHS_NM < 520, 0.35, 0.95)]
    curves = camera_sensitivities(NIKON) * STEP_NM
    share = np.stack([left, 1 - left], -1)
    exact_xyz = share @ spectra_to_xyz(light * colours)
    exact_rgb = share @ (light * colours @ curves)
    noise = random.normal(1.0, 0.3, (SIZE, SIZE, 1))
    own = random.normal(1.0, 0.03, (2, SIZE, SIZE, 3))  # of its own in each channel, from unlike wavelengths
    general = np.linalg.lstsq(spectra_to_xyz(light[None]), (light @ curves)[None], rcond=None)[0].T
    cover = ObjectCoverage({"one": left, "other": 1 - left}, np.ones_like(left), np.zeros_like(left))
    images = (
        np.float32(image) for image in (exact_xyz, exact_xyz * noise * own[0], exact_rgb * noise * own[1])
    )
    seen = denoised_in_camera(*images, cover, general)
    np.testing.assert_allclose(seen.mean((0, 1)), exact_rgb.mean((0, 1)), rtol=5e-3)
    error = np.abs(seen / exact_rgb - 1)
    assert error.mean() < 0.01
    assert error[:, SIZE // 2 - 2 : SIZE // 2 + 2].mean() < 0.015


def test_black_objects_stay_black():
    nothing, one = np.zeros((8, 8, 3), np.float32), np.ones((8, 8), np.float32)
    cover = ObjectCoverage({"black": one}, one, 0 * one)
    np.testing.assert_array_equal(denoised_in_camera(nothing, nothing, nothing, cover, np.eye(3)), nothing)

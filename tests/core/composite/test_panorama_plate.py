"""A panorama as the background: every pixel shows its direction's light."""

import json
from pathlib import Path

import numpy as np
import pytest

from spectral_probe.cli import main
from spectral_probe.composite.backplate_file import save_backplate
from spectral_probe.composite.panorama_plate import is_probe, panorama_plate, seen_by
from spectral_probe.composite_model import Backplate, ObjectCoverage
from spectral_probe.files.image_exr import read_rgb, write_channels, write_rgb
from spectral_probe.files.objects_exr import write_objects
from spectral_probe.files.probe_exr import write_probe
from spectral_probe.geometry.camera import pixel_rays
from spectral_probe.geometry.frames import camera_to_world, panorama_directions
from spectral_probe.model import Camera, SpectralPanorama
from spectral_probe.spectra.colorimetry import spectra_to_xyz, xyz_to_rec709
from spectral_probe.spectra.grid import WAVELENGTHS_NM

SPECTRUM = np.linspace(0.004, 0.01, 61)


def panorama(height=128):
    """Light of one spectrum, brighter towards +X and up."""
    directions = panorama_directions(height, 2 * height)
    weights = (2 + directions[..., :1] + 0.5 * directions[..., 2:]).astype(np.float32)
    return SpectralPanorama(
        weights,
        SPECTRUM[None, None],
        np.zeros(weights.shape[:2], np.uint8),
        WAVELENGTHS_NM,
        np.ones(weights.shape[:2], bool),
        np.ones(weights.shape[:2], np.float32),
    )


def looking(azimuth_deg):
    """A camera of 32 x 20 pixels, a little off its middle, that looks down a little."""
    camera = Camera((30.0, 30.0), (15.0, 11.0), (32, 20))
    rotation = camera_to_world(azimuth_deg, 10.0, 3.0)
    return Backplate(camera, rotation, np.zeros(3), Path(), (32, 20), (0.0, 0.0, 32, 20))


@pytest.mark.parametrize("azimuth_deg", [0.0, 90.0, 268.0])  # across the panorama's seam
def test_each_pixel_shows_the_light_of_its_direction(azimuth_deg):
    backplate = looking(azimuth_deg)
    points = np.stack(np.meshgrid(np.arange(32) + 0.5, np.arange(20) + 0.5), -1)
    directions = pixel_rays(backplate.camera, points) @ backplate.rotation.T
    level = 2 + directions[..., :1] + 0.5 * directions[..., 2:]
    unit = xyz_to_rec709(spectra_to_xyz(SPECTRUM))
    np.testing.assert_allclose(seen_by(panorama(), backplate), level * unit, rtol=2e-3)


def test_objects_stand_before_the_panorama(tmp_path):
    write_probe(tmp_path / "probe.exr", panorama(32))
    cover = np.zeros((20, 32), np.float32)
    cover[5:10, 5:10] = 1
    render = tmp_path / "render"
    write_objects(render / "objects.exr", ObjectCoverage({"box": cover}, cover, 0 * cover))
    write_channels(render / "xyz.exr", dict.fromkeys("XYZ", cover) | {"A": cover})
    words = ["composite", str(render), "--plate", str(tmp_path / "probe.exr"), "-o", str(tmp_path / "out")]
    assert main(words) == 2  # nothing says where the camera looks
    save_backplate(render / "backplate.json", looking(20.0))
    assert main(words) == 0
    found, plate = (read_rgb(tmp_path / "out" / f"{name}.exr") for name in ("composite", "plate"))
    np.testing.assert_array_equal(found[cover == 0], plate[cover == 0])
    assert json.loads((tmp_path / "out" / "composite.json").read_text())["camera"] == "Rec.709"


def test_a_photograph_is_no_panorama(tmp_path):
    write_rgb(tmp_path / "photo.exr", np.ones((4, 4, 3), np.float32))
    write_probe(tmp_path / "probe.exr", panorama(8))
    assert (is_probe(tmp_path / "photo.exr"), is_probe(tmp_path / "probe.exr")) == (False, True)
    assert panorama_plate(tmp_path / "probe.exr", looking(0.0)).pixels.shape == (20, 32, 3)

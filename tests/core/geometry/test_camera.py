from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from spectral_probe.errors import CaptureError
from spectral_probe.geometry.camera import camera_for, pixel_rays, project
from spectral_probe.model import Camera, CameraSettings, Photograph

CAMERA = Camera((900.0, 950.0), (310.0, 250.0), (640, 480))
PHOTOGRAPH = Photograph(Path("a.jpg"), np.zeros((480, 640, 3), np.float32), np.zeros((480, 640), bool))


@pytest.mark.parametrize("distortion", [(0.0,) * 5, (-0.2, 0.08, 0.001, -0.002, 0.01)])
def test_rays_project_back(distortion):
    camera = replace(CAMERA, distortion=distortion)
    points = np.random.default_rng(3).uniform([20, 20], [620, 460], size=(500, 2))
    rays = pixel_rays(camera, points)
    assert np.allclose(np.linalg.norm(rays, axis=-1), 1)
    assert np.abs(project(camera, rays * 3.0) - points).max() < 1e-5


def test_focal_length_from_millimetres_and_sensor():
    settings = CameraSettings(focal_mm=50, sensor_width_mm=36)
    assert camera_for(settings, PHOTOGRAPH).focal_px == pytest.approx((640 * 50 / 36,) * 2)


def test_focal_length_from_exif():
    photograph = replace(PHOTOGRAPH, focal_mm=16.0, focal_35mm=24.0)
    camera = camera_for(CameraSettings(), photograph)
    assert camera.focal_px[0] == pytest.approx(24 / 43.2666 * 800)
    assert "EXIF" in camera.source
    assert camera.principal_px == (320, 240)


def test_no_focal_length_is_said():
    with pytest.raises(CaptureError, match=r"a\.jpg does not say its focal length\. Add focal_px"):
        camera_for(CameraSettings(), PHOTOGRAPH)


def test_calibration_of_another_size_is_refused(tmp_path):
    file = tmp_path / "camera.json"
    file.write_text('{"focal_px": [900, 900], "principal_px": [300, 200], "image_size_px": [600, 400]}')
    with pytest.raises(CaptureError, match="600 x 400"):
        camera_for(CameraSettings(calibration=file), PHOTOGRAPH)

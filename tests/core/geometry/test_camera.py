import json
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


def test_focal_length_from_the_sensor_that_exif_describes():
    photograph = replace(PHOTOGRAPH, focal_mm=16.0, focal_35mm=24.0, sensor_width_mm=23.4)
    camera = camera_for(CameraSettings(), photograph)
    assert camera.focal_px[0] == pytest.approx(16 / 23.4 * 640)
    assert camera.source == "EXIF (the photograph presumed uncropped)"
    given = camera_for(CameraSettings(focal_mm=18), photograph)
    assert given.focal_px[0] == pytest.approx(18 / 23.4 * 640)
    assert "focal length from capture file, sensor width from EXIF" in given.source


def test_a_quarter_turn_keeps_the_focal_length_and_the_centre():
    photograph = replace(PHOTOGRAPH, focal_mm=16.0, sensor_width_mm=23.4)
    upright = replace(photograph, pixels=PHOTOGRAPH.pixels.swapaxes(0, 1))
    lying, standing = (camera_for(CameraSettings(), photo) for photo in (photograph, upright))
    assert standing.focal_px == lying.focal_px
    assert (lying.principal_px, standing.principal_px) == ((320, 240), (240, 320))


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (CameraSettings(focal_px=(100.0, 100.0)), "a focal length of 100 px for an image 640 px wide"),
        (CameraSettings(focal_px=(0.0, 0.0)), "the focal length 0 px is not possible"),
        (CameraSettings(focal_px=(900.0, 9000.0)), "differ too much"),
        (
            CameraSettings(focal_px=(900.0, 900.0), principal_px=(9000.0, 200.0)),
            "principal point 9000, 200 lies too far",
        ),
        (
            CameraSettings(focal_px=(600.0, 600.0), distortion=(-2.0, 0.0, 0.0, 0.0, 0.0)),
            "folds the image over itself",
        ),
        (CameraSettings(focal_mm=16.0), r"nothing says how large the sensor is\. Add sensor_width_mm"),
    ],
)
def test_impossible_cameras_are_refused(settings, message):
    with pytest.raises(CaptureError, match=message) as error:
        camera_for(settings, PHOTOGRAPH)
    assert "a.jpg" in str(error.value)
    assert "\n" not in str(error.value)


def test_a_crop_may_lie_off_the_optical_axis():
    camera = camera_for(CameraSettings(focal_px=(5720.0, 5720.0), principal_px=(-1500.0, 900.0)), PHOTOGRAPH)
    assert camera.principal_px == (-1500.0, 900.0)


@pytest.mark.parametrize(
    ("size", "factor"),
    [((1280, 960), 0.5), ((1281, 961), 0.5), ((640, 480), 1.0), ((1922, 1441), 1 / 3), ((320, 240), 2.0)],
)
def test_a_calibration_serves_other_sizes_of_the_same_frame(tmp_path, size, factor):
    """Half-size raw leaves over a last odd row or column; scaled, rays of the same place are the same."""
    lens = Camera(
        (900 / factor, 950 / factor), (310 / factor, 250 / factor), size, (-0.2, 0.08, 0.001, -0.002, 0.01)
    )
    file = tmp_path / "camera.json"
    file.write_text(
        json.dumps({
            "focal_px": lens.focal_px, "principal_px": lens.principal_px, "distortion": lens.distortion, "image_size_px": size,
        })
    )  # fmt: skip
    camera = camera_for(CameraSettings(calibration=file), PHOTOGRAPH)
    assert camera.size_px == (640, 480)
    points = np.random.default_rng(3).uniform([20, 20], [620, 460], size=(50, 2))
    assert pixel_rays(camera, points) == pytest.approx(pixel_rays(lens, points / factor), abs=1e-9)
    assert ("scaled by" in camera.source) == (factor != 1.0)


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", '{"focal_px": [1]}', '{"focal_px": 3, "principal_px": 4, "image_size_px": 5}']
)
def test_a_file_that_is_no_calibration(tmp_path, text):
    file = tmp_path / "camera.json"
    file.write_text(text)
    with pytest.raises(CaptureError, match=r"camera\.json is not a camera calibration\. Make one"):
        camera_for(CameraSettings(calibration=file), PHOTOGRAPH)


def test_calibration_of_another_size_is_refused(tmp_path):
    file = tmp_path / "camera.json"
    file.write_text('{"focal_px": [900, 900], "principal_px": [300, 200], "image_size_px": [600, 400]}')
    with pytest.raises(CaptureError, match="600 x 400"):
        camera_for(CameraSettings(calibration=file), PHOTOGRAPH)

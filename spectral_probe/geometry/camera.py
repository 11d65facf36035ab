"""The camera's intrinsics K (eq. 1): rays of pixels and pixels of points.

Where the intrinsics come from, in order: a calibration file, the capture file, EXIF.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from ..errors import CaptureError
from ..model import Camera, CameraSettings, FloatArray, Photograph

_FULL_FRAME_DIAGONAL_MM = 43.2666
_UNDISTORTION_CRITERIA = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-12)


def camera_for(settings: CameraSettings, photograph: Photograph) -> Camera:
    """The pinhole camera that took a photograph.

    Parameters
    ----------
    settings
        `[camera]` of the capture file.
    photograph
        The first photograph of a view, for its size and EXIF.

    Raises
    ------
    CaptureError
        If nothing says what the focal length is, or the calibration does not fit the photograph.
    """
    height, width = photograph.pixels.shape[:2]
    if settings.calibration is not None:
        return _calibrated(settings.calibration, (width, height))
    focal_px, source = _focal_length_px(settings, photograph)
    principal_px = settings.principal_px or (width / 2, height / 2)
    return Camera(focal_px, principal_px, (width, height), tuple(settings.distortion), source)


def _focal_length_px(settings: CameraSettings, photograph: Photograph) -> tuple[tuple[float, float], str]:
    height, width = photograph.pixels.shape[:2]
    if settings.focal_px is not None:
        return settings.focal_px, "capture file"
    focal_mm = settings.focal_mm or photograph.focal_mm
    if focal_mm and settings.sensor_width_mm:
        focal = focal_mm / settings.sensor_width_mm * max(width, height)
        return (
            focal,
            focal,
        ), "capture file" if settings.focal_mm else "EXIF and the capture file's sensor width"
    if photograph.focal_35mm:
        focal = photograph.focal_35mm / _FULL_FRAME_DIAGONAL_MM * float(np.hypot(width, height))
        return (focal, focal), "EXIF (35 mm equivalent, uncropped photograph assumed)"
    raise CaptureError(
        f"{photograph.path.name} does not say its focal length. Add focal_px, or focal_mm and sensor_width_mm, "
        "to [camera] in the capture file."
    )


def _calibrated(path: Path, size_px: tuple[int, int]) -> Camera:
    try:
        data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        focal, principal = data["focal_px"], data["principal_px"]
        camera = Camera(
            (float(focal[0]), float(focal[1])),
            (float(principal[0]), float(principal[1])),
            (int(data["image_size_px"][0]), int(data["image_size_px"][1])),
            tuple(float(value) for value in data.get("distortion", (0,) * 5)),
            f"calibration {path.name}",
        )
    except FileNotFoundError:
        raise CaptureError(f"There is no camera calibration at {path}. Check the path.") from None
    except (OSError, json.JSONDecodeError, KeyError, TypeError, ValueError, IndexError):
        raise CaptureError(
            f"{path.name} is not a camera calibration. Make one from photographs of a chessboard."
        ) from None
    if camera.size_px != size_px:
        raise CaptureError(
            f"{path.name} was made at {camera.size_px[0]} x {camera.size_px[1]} pixels, but the photographs have "
            f"{size_px[0]} x {size_px[1]}. Calibrate at the size of the photographs."
        )
    return camera


def intrinsic_matrix(camera: Camera) -> FloatArray:
    """The matrix K of eq. 1, (3, 3), for pixel centres at integer + 0.5."""
    (focal_x, focal_y), (principal_x, principal_y) = camera.focal_px, camera.principal_px
    return np.array([[focal_x, 0.0, principal_x], [0.0, focal_y, principal_y], [0.0, 0.0, 1.0]])


def pixel_rays(camera: Camera, points_px: FloatArray) -> FloatArray:
    """Unit viewing directions V of image points in the camera's frame (eq. 1), (..., 2) -> (..., 3).

    Examples
    --------
    >>> camera = Camera((100.0, 100.0), (50.0, 50.0), (100, 100))
    >>> pixel_rays(camera, np.array([50.0, 50.0])).tolist()
    [0.0, 0.0, 1.0]
    """
    points = np.asarray(points_px, float)
    flat = points.reshape(-1, 1, 2)
    if any(camera.distortion):
        plane = cv2.undistortPoints(
            flat, intrinsic_matrix(camera), np.array(camera.distortion), criteria=_UNDISTORTION_CRITERIA
        )
    else:
        plane = (flat - np.array(camera.principal_px)) / np.array(camera.focal_px)
    rays = np.concatenate([plane.reshape(-1, 2), np.ones((len(flat), 1))], axis=-1)
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    return rays.reshape((*points.shape[:-1], 3))


def project(camera: Camera, points: FloatArray) -> FloatArray:
    """Image points of points in the camera's frame, (..., 3) -> (..., 2) pixels; the inverse of `pixel_rays`.

    Points must be in front of the camera (z > 0).
    """
    points = np.asarray(points)
    if any(camera.distortion):
        flat = np.asarray(points, float).reshape(-1, 1, 3)
        zero = np.zeros(3)
        image, _ = cv2.projectPoints(flat, zero, zero, intrinsic_matrix(camera), np.array(camera.distortion))
        return np.asarray(image.reshape((*points.shape[:-1], 2)))
    image = np.empty((*points.shape[:-1], 2), points.dtype)
    for axis, (focal, principal) in enumerate(zip(camera.focal_px, camera.principal_px, strict=True)):
        image[..., axis] = points[..., axis] / points[..., 2] * points.dtype.type(focal)
        image[..., axis] += points.dtype.type(principal)
    return image

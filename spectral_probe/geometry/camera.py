"""The camera's intrinsics K (eq. 1): rays of pixels and pixels of points.

Where the intrinsics come from, in order: a calibration file, the capture file, EXIF.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from ..errors import CaptureError
from ..files.json_object import UNREADABLE, read_object
from ..model import Camera, CameraSettings, FloatArray, Photograph

_FULL_FRAME_DIAGONAL_MM = 43.2666
_UNCROPPED = "the photograph presumed uncropped"
_DISTORTION_LENGTHS = (4, 5, 8)
_SHORTEST_FOCAL, _LONGEST_FOCAL = 0.2, 200.0
"""Of the image's longer side: a field of view of 136 degrees, beyond any rectilinear lens, and of 0.3 degrees."""

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
        camera = _calibrated(settings.calibration, (width, height))
    else:
        focal_px, source = _focal_length_px(settings, photograph)
        principal_px = settings.principal_px or (width / 2, height / 2)
        camera = Camera(focal_px, principal_px, (width, height), tuple(settings.distortion), source)
    _check_possible(camera, settings.calibration.name if settings.calibration else photograph.path.name)
    return camera


def _focal_length_px(settings: CameraSettings, photograph: Photograph) -> tuple[tuple[float, float], str]:
    """The focal length in pixels, and where it comes from; a sensor's width is that of its longer side."""
    height, width = photograph.pixels.shape[:2]
    if settings.focal_px is not None:
        return settings.focal_px, "capture file"
    focal_mm = settings.focal_mm or photograph.focal_mm
    told = "capture file" if settings.focal_mm else "EXIF"
    for sensor_mm, sensor_told in (
        (settings.sensor_width_mm, "capture file"),
        (photograph.sensor_width_mm, "EXIF"),
    ):
        if focal_mm and sensor_mm:
            focal = focal_mm / sensor_mm * max(width, height)
            told = (
                told if told == sensor_told else f"focal length from {told}, sensor width from {sensor_told}"
            )
            return (focal, focal), f"{told} ({_UNCROPPED})" if "EXIF" in told else told
    if photograph.focal_35mm and not settings.focal_mm:
        focal = photograph.focal_35mm / _FULL_FRAME_DIAGONAL_MM * float(np.hypot(width, height))
        return (focal, focal), f"EXIF (35 mm equivalent, {_UNCROPPED})"
    if focal_mm:
        raise CaptureError(
            f"{photograph.path.name} has a focal length of {focal_mm:g} mm, but nothing says how large the sensor is. Add "
            "sensor_width_mm, or focal_px, to [camera] in the capture file."
        )
    raise CaptureError(
        f"{photograph.path.name} does not say its focal length. Add focal_px, or focal_mm and sensor_width_mm, "
        "to [camera] in the capture file."
    )


def _calibrated(path: Path, size_px: tuple[int, int]) -> Camera:
    try:
        if not path.exists():
            raise CaptureError(f"There is no camera calibration at {path}. Check the path.")
        data = read_object(path)
        focal, principal = data["focal_px"], data["principal_px"]
        camera = Camera(
            (float(focal[0]), float(focal[1])),
            (float(principal[0]), float(principal[1])),
            (int(data["image_size_px"][0]), int(data["image_size_px"][1])),
            tuple(float(value) for value in data.get("distortion", (0,) * 5)),
            f"calibration {path.name}",
        )
        if min(camera.size_px) < 1:
            raise ValueError("no size")
    except UNREADABLE:
        raise CaptureError(
            f"{path.name} is not a camera calibration. Make one with `calibrate` from photographs of a chessboard."
        ) from None
    if len(camera.distortion) not in _DISTORTION_LENGTHS:
        raise CaptureError(
            f"{path.name} has {len(camera.distortion)} distortion coefficients. Give 4, 5 or 8 in OpenCV's order."
        )
    if camera.size_px == size_px:
        return camera
    return _at_size(camera, size_px, path)


def _at_size(camera: Camera, size_px: tuple[int, int], path: Path) -> Camera:
    """The same lens on photographs of another size that show the same frame, such as raw at half the size.

    With pixel centres at integer + 0.5 all lengths scale by one factor, and the distortion does not change. A last row or
    column that halving drops is no other frame.
    """
    factor = size_px[0] / camera.size_px[0]
    binned = max(1, round(1.0 / factor))
    left_over = [full - binned * own for full, own in zip(camera.size_px, size_px, strict=True)]
    if all(0 <= sensels < binned for sensels in left_over):
        factor = 1.0 / binned
    missed_px = max(abs(camera.size_px[axis] * factor - size_px[axis]) for axis in (0, 1))
    if missed_px >= 1.0:
        raise CaptureError(
            f"{path.name} was made at {camera.size_px[0]} x {camera.size_px[1]} pixels, but the photographs have "
            f"{size_px[0]} x {size_px[1]}. Calibrate at the size of the photographs."
        )
    return Camera(
        (camera.focal_px[0] * factor, camera.focal_px[1] * factor),
        (camera.principal_px[0] * factor, camera.principal_px[1] * factor),
        size_px,
        camera.distortion,
        f"{camera.source}, scaled by {factor:g}",
    )


def _check_possible(camera: Camera, name: str) -> None:
    """Refuse a camera that cannot have taken a photograph of a ball.

    Raises
    ------
    CaptureError
        If a focal length is below a fifth of the image or no number, the optical axis far outside of it, or the distortion
        folds the image over.
    """
    longer = max(camera.size_px)
    numbers = (*camera.focal_px, *camera.principal_px, *camera.distortion)
    if not np.isfinite(numbers).all() or min(camera.focal_px) <= 0.0:
        raise CaptureError(
            f"{name}: the focal length {min(camera.focal_px):g} px is not possible. Correct it."
        )
    if min(camera.focal_px) < _SHORTEST_FOCAL * longer or max(camera.focal_px) > _LONGEST_FOCAL * longer:
        raise CaptureError(
            f"{name}: a focal length of {camera.focal_px[0]:.0f} px for an image {longer} px wide is not possible (from "
            f"{camera.source}). Correct focal_px, or focal_mm and sensor_width_mm."
        )
    if max(camera.focal_px) > 1.5 * min(camera.focal_px):
        raise CaptureError(
            f"{name}: focal lengths of {camera.focal_px[0]:.0f} and {camera.focal_px[1]:.0f} px along x and y differ too much. "
            "Correct focal_px."
        )
    offset_px = float(np.hypot(*np.subtract(camera.principal_px, np.array(camera.size_px) / 2)))
    if (
        offset_px > max(camera.focal_px) + longer
    ):  # crops may lie off the optical axis, though not by 45 degrees
        raise CaptureError(
            f"{name}: the principal point {camera.principal_px[0]:.0f}, {camera.principal_px[1]:.0f} lies too far outside of "
            f"the image of {camera.size_px[0]} x {camera.size_px[1]} pixels. Correct principal_px."
        )
    if any(camera.distortion) and _folds(camera):
        raise CaptureError(
            f"{name}: its lens distortion folds the image over itself. Calibrate again, with boards out to the corners."
        )


def _folds(camera: Camera) -> bool:
    """Whether undistortion has no unique answer in the image: pixels must come back from their rays, and in order."""
    width, height = camera.size_px
    grid = np.stack(np.meshgrid(np.linspace(0, width, 25), np.linspace(0, height, 25)), axis=-1)
    rays = pixel_rays(camera, grid)
    back = project(camera, rays)
    if not np.isfinite(back).all() or float(np.abs(back - grid).max()) > 0.5:
        return True
    plane = rays[..., :2] / rays[..., 2:]
    across, down = np.diff(plane, axis=1)[:-1], np.diff(plane, axis=0)[:, :-1]
    turns = across[..., 0] * down[..., 1] - across[..., 1] * down[..., 0]
    return bool((turns <= 0.0).any())


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

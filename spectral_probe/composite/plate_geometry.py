"""The plate's camera at the size that is rendered, and the pinhole frame that Blender renders for it.

Blender knows no lens distortion. Where the lens has some, a larger frame is rendered without it, which the picture's every
pixel lies in, and is bent afterwards.
"""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import numpy.typing as npt

from ..composite_model import Backplate
from ..errors import RenderError
from ..geometry.camera import intrinsic_matrix, pixel_rays, project
from ..model import Camera, FloatArray

_MARGIN_PX = 2
"""Pixels round the bent picture that interpolation needs."""

_LARGEST_FRAME = 2.0
"""A frame more than this many times as wide or high as the picture: a fisheye's, not to be rendered through a pinhole."""


def at_size(camera: Camera, size_px: tuple[int, int]) -> Camera:
    """The camera of the same picture at another size (width, height).

    Examples
    --------
    >>> camera = at_size(Camera((900.0, 900.0), (310.0, 200.0), (600, 400)), (300, 200))
    >>> camera.focal_px, camera.principal_px, camera.size_px
    ((450.0, 450.0), (155.0, 100.0), (300, 200))
    """
    across, down = (new / old for new, old in zip(size_px, camera.size_px, strict=True))
    return replace(
        camera,
        focal_px=(camera.focal_px[0] * across, camera.focal_px[1] * down),
        principal_px=(camera.principal_px[0] * across, camera.principal_px[1] * down),
        size_px=size_px,
    )


def reduced_size(size_px: tuple[int, int], width_px: int | None) -> tuple[int, int]:
    """The size of a picture at a smaller width; its own without one.

    Raises
    ------
    RenderError
        If it is no width, or larger than the picture's own.

    Examples
    --------
    >>> reduced_size((6000, 4000), 1500), reduced_size((1500, 1000), None)
    ((1500, 1000), (1500, 1000))
    """
    width, height = size_px
    if width_px is None:
        return size_px
    if not 16 <= width_px <= width:
        raise RenderError(
            f"The plate is {width} pixels wide and can be reduced to 16 or more, not {width_px}."
        )
    return width_px, max(1, round(height * width_px / width))


def without_distortion(camera: Camera) -> Camera:
    """The pinhole camera with the same focal lengths and principal point."""
    return replace(camera, distortion=(0.0,) * 5)


def rendered_frame(camera: Camera) -> tuple[float, float, int, int]:
    """What Blender renders (left, top, width, height), in pixels of the undistorted picture.

    Raises
    ------
    RenderError
        If the lens bends the picture so far that no pinhole holds it.

    Examples
    --------
    >>> rendered_frame(Camera((900.0, 900.0), (300.0, 200.0), (600, 400)))
    (0.0, 0.0, 600, 400)
    """
    width, height = camera.size_px
    if not any(camera.distortion):
        return (0.0, 0.0, width, height)
    across, down = np.linspace(0.0, width, 65), np.linspace(0.0, height, 65)
    border = np.concatenate(
        [np.stack(np.broadcast_arrays(across, y), -1) for y in (0.0, height)]
        + [np.stack(np.broadcast_arrays(x, down), -1) for x in (0.0, width)]
    )
    straight = project(without_distortion(camera), pixel_rays(camera, border))
    low = np.floor(straight.min(0)) - _MARGIN_PX
    high = np.ceil(straight.max(0)) + _MARGIN_PX
    frame = high - low
    if not np.isfinite(frame).all() or (frame > _LARGEST_FRAME * np.array(camera.size_px)).any():
        raise RenderError(
            "The lens distortion bends the picture too far for a pinhole camera. Calibrate it, or crop the plate and photographs."
        )
    return float(low[0]), float(low[1]), int(frame[0]), int(frame[1])


def frame_camera(backplate: Backplate) -> Camera:
    """The pinhole camera of what Blender renders, its pixels counted from the frame's corner."""
    left, top, width, height = backplate.frame_px
    camera = without_distortion(backplate.camera)
    principal = (camera.principal_px[0] - left, camera.principal_px[1] - top)
    return replace(camera, principal_px=principal, size_px=(width, height))


def at_frame_size(backplate: Backplate, size_px: tuple[int, int]) -> Backplate:
    """The same backplate with its frame rendered at another size (width, height).

    A bent picture's own size is rounded to whole pixels, which stretches it by half a pixel at most.

    Examples
    --------
    >>> from pathlib import Path
    >>> camera = Camera((900.0, 900.0), (310.0, 200.0), (600, 400))
    >>> plate = Backplate(camera, np.eye(3), np.zeros(3), Path("plate.exr"), (600, 400), (0.0, 0.0, 600, 400))
    >>> small = at_frame_size(plate, (120, 80))
    >>> small.camera.focal_px, small.camera.size_px, small.frame_px, small.photo_size_px
    ((180.0, 180.0), (120, 80), (0.0, 0.0, 120, 80), (600, 400))
    """
    left, top, *frame = backplate.frame_px
    if tuple(frame) == size_px:
        return backplate
    sizes = zip(backplate.camera.size_px, size_px, frame, strict=True)
    width, height = (max(1, round(own * new / old)) for own, new, old in sizes)
    camera = at_size(backplate.camera, (width, height))
    across, down = (new / old for new, old in zip(camera.size_px, backplate.camera.size_px, strict=True))
    return replace(backplate, camera=camera, frame_px=(left * across, top * down, *size_px))


def undistorted(picture: FloatArray, backplate: Backplate) -> npt.NDArray[np.float32]:
    """A picture (H, W) or (H, W, C) of the plate's camera as the frame shows it; 0 beyond the picture."""
    camera, frame = backplate.camera, frame_camera(backplate)
    picture = np.asarray(picture, np.float32)
    if not any(camera.distortion):
        return picture
    maps = cv2.initUndistortRectifyMap(
        _opencv_matrix(camera),
        np.array(camera.distortion),
        None,
        _opencv_matrix(frame),
        frame.size_px,
        cv2.CV_32FC1,
    )
    return np.asarray(cv2.remap(picture, maps[0], maps[1], cv2.INTER_LINEAR), np.float32)


def _opencv_matrix(camera: Camera) -> FloatArray:
    """The intrinsic matrix as OpenCV counts pixels, their centres at integers."""
    matrix = intrinsic_matrix(camera)
    matrix[:2, 2] -= 0.5
    return matrix


def world_to_frame(backplate: Backplate, points_m: FloatArray) -> FloatArray:
    """Where world points (..., 3) appear in the frame, (..., 2) pixels; NaN behind the camera."""
    local = (np.asarray(points_m, float) - backplate.position_m) @ backplate.rotation
    behind = local[..., 2] <= 1e-9
    places = project(frame_camera(backplate), np.where(behind[..., None], 1.0, local))
    return np.where(behind[..., None], np.nan, places)


def world_to_plate(backplate: Backplate, points_m: FloatArray) -> FloatArray:
    """Where world points (..., 3) appear in the photograph, distortion and all, (..., 2) pixels; NaN behind the camera.

    Examples
    --------
    >>> from pathlib import Path
    >>> camera = Camera((100.0, 100.0), (50.0, 40.0), (100, 80))
    >>> level = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # looks along +Y, z up
    >>> plate = Backplate(camera, level, np.array([0.0, -2.0, 0.0]), Path(), (100, 80), (0.0, 0.0, 100, 80))
    >>> world_to_plate(plate, np.array([0.2, 0.0, 0.1])).round(6).tolist()
    [60.0, 35.0]
    """
    local = (np.asarray(points_m, float) - backplate.position_m) @ backplate.rotation
    behind = local[..., 2] <= 1e-9
    places = project(backplate.camera, np.where(behind[..., None], 1.0, local))
    return np.where(behind[..., None], np.nan, places)

"""One view's radiance image onto the panorama, every direction read where the ball mirrors it.

The panorama is filled by going backwards: from the direction of a texel to the point on the ball that mirrors
it (`find_reflection`) to the pixel that saw that point. Texels larger than pixels are sampled several times.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from ..model import BallFit, BoolArray, Camera, FloatArray, RadianceImage
from .ball import find_reflection
from .camera import project
from .frames import equirectangular_to_direction

_ROWS_AT_A_TIME = 128
_MOST_SAMPLES = 4
_RIM_COSINE = 0.02
"""Closer to the rim than this cosine of incidence a direction is not used: a pixel there spans degrees."""


@dataclass(frozen=True)
class ViewPanorama:
    """What one view saw, in the panorama's frame.

    `responses` (H, W, 3) linear camera RGB of the ball's image, `variance` (H, W, 3) of it, `cos_incidence` (H, W) on the
    ball, `facing_rad` (H, W) angle between the direction and the direction to the camera, `seen` (H, W) inside the
    view (not in its blind cone, not hidden), `valid` (H, W) seen and not clipped.
    """

    responses: FloatArray
    variance: FloatArray
    cos_incidence: FloatArray
    facing_rad: FloatArray
    seen: BoolArray
    valid: BoolArray


def view_panorama(
    image: RadianceImage, camera: Camera, ball: BallFit, rotation: FloatArray, width: int
) -> ViewPanorama:
    """Resample a view's radiance image to an equirectangular panorama.

    Parameters
    ----------
    image
        Radiance of the photograph, (H, W, 3).
    camera, ball
        Its geometry.
    rotation
        (3, 3) camera to world (`frames.camera_to_world`).
    width
        Width of the panorama in pixels; its height is half of it.

    Returns
    -------
    ViewPanorama
        Arrays of shape (width / 2, width, ...).
    """
    height = width // 2
    samples = _samples_per_texel(camera, ball, width)
    variance = np.where(
        np.isfinite(image.variance), image.variance, 0.0
    )  # infinite where clipped, which `valid` tells
    channels = np.concatenate([image.radiance, variance, image.valid[..., None]], axis=-1, dtype=np.float32)
    result = np.zeros((height, width, 7), np.float32)
    cosine = np.zeros((height, width), np.float32)
    facing = np.zeros((height, width), np.float32)
    inside = np.zeros((height, width), np.float32)
    towards_camera = -ball.centre_m / ball.distance_m @ rotation.T
    for start in range(0, height, _ROWS_AT_A_TIME):
        rows = slice(start, min(start + _ROWS_AT_A_TIME, height))
        directions = _sub_directions(rows, height, width, samples)
        points, cos_incidence = find_reflection(ball, directions @ rotation.astype(np.float32))
        pixels = project(camera, points).astype(np.float32) - np.float32(0.5)  # cv2 counts from pixel centres
        values = _remap(channels, pixels)
        in_frame = (np.abs(pixels + 0.5 - np.array(camera.size_px) / 2) < np.array(camera.size_px) / 2).all(
            -1
        )
        shape = (width, rows.stop - rows.start)
        result[rows] = np.dstack([_shrunk(values[..., :4], shape), _shrunk(values[..., 4:], shape)])
        cosine[rows] = _shrunk(cos_incidence, shape)
        inside[rows] = _shrunk((in_frame & (cos_incidence > _RIM_COSINE)).astype(np.float32), shape)
        facing[rows] = _shrunk(
            np.arccos(np.clip(directions @ towards_camera.astype(np.float32), -1.0, 1.0)), shape
        )
    seen = inside > 0.99
    return ViewPanorama(
        result[..., :3], result[..., 3:6], cosine, facing, seen, seen & (result[..., 6] > 0.99)
    )


def _samples_per_texel(camera: Camera, ball: BallFit, width: int) -> int:
    """Samples along each side of a texel so that no pixel of the ball is stepped over.

    The ball's image maps its area evenly onto the sphere (R^2 / 4 pixels a steradian), exactly so from far away.
    """
    radius_px = max(camera.focal_px) * np.tan(ball.cone_angle_rad)
    return int(np.clip(np.ceil(np.pi * radius_px / width), 1, _MOST_SAMPLES))


def _sub_directions(rows: slice, height: int, width: int, samples: int) -> FloatArray:
    """World directions of the sub-samples of some rows, (rows * samples, W * samples, 3) float32."""
    column = (np.arange(width * samples) + 0.5) / samples
    row = rows.start + (np.arange((rows.stop - rows.start) * samples) + 0.5) / samples
    points = np.stack(np.meshgrid(column, row), axis=-1)
    return equirectangular_to_direction(points, height, width).astype(np.float32)


def _remap(channels: FloatArray, pixels: FloatArray) -> FloatArray:
    """Bilinear samples of (H, W, 7) at pixel coordinates (h, w, 2); the edge is repeated outside."""
    parts = [
        cv2.remap(part, pixels, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        for part in (np.ascontiguousarray(channels[..., :4]), np.ascontiguousarray(channels[..., 4:]))
    ]
    return np.concatenate(parts, axis=-1)


def _shrunk(values: FloatArray, size: tuple[int, int]) -> FloatArray:
    """Area average down to `size` (width, height)."""
    if values.shape[1] == size[0]:
        return values
    return np.asarray(cv2.resize(np.asarray(values, np.float32), size, interpolation=cv2.INTER_AREA))

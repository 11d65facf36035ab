"""The frames, and every conversion between them, forward and inverse in pairs.

- Camera: +x right, +y down, +z forward.
- World: Blender's, +z up. At azimuth 0 the camera looks along +Y; azimuth is the compass bearing of the viewing
  direction, clockwise seen from above (at 90 degrees it looks along +X). Elevation > 0: the camera is above what it looks
  at, looking down.
- Panorama: Blender's equirectangular as Cycles reads it: u = 0.5 - atan2(y, x) / (2 pi), v = 0.5 + asin(z) / pi, row 0
  at the top (v = 1).
- Bearings: compass bearing (0 = +Y, clockwise from above) and elevation of a direction, in degrees.
"""

from __future__ import annotations

import numpy as np

from ..model import FloatArray


def camera_to_world(azimuth_deg: float, elevation_deg: float = 0.0, roll_deg: float = 0.0) -> FloatArray:
    """Rotation from camera to world coordinates, (3, 3): ``world = camera @ R.T``.

    Parameters
    ----------
    azimuth_deg
        Compass bearing of the viewing direction.
    elevation_deg
        Height of the camera above what it looks at, as an angle: the viewing direction dips by it.
    roll_deg
        Turn of the camera about its viewing direction, clockwise as seen from behind it.

    Examples
    --------
    >>> (np.array([0, 0, 1]) @ camera_to_world(90).T).round(6).tolist()  # looks along +X
    [1.0, 0.0, 0.0]
    >>> (np.array([0, -1, 0]) @ camera_to_world(30).T).round(6).tolist()  # the image's up is the world's up
    [0.0, 0.0, 1.0]
    """
    azimuth, elevation, roll = np.radians([azimuth_deg, elevation_deg, roll_deg])
    forward = np.array(
        [np.sin(azimuth) * np.cos(elevation), np.cos(azimuth) * np.cos(elevation), -np.sin(elevation)]
    )
    right = np.array([np.cos(azimuth), -np.sin(azimuth), 0.0])
    down = np.cross(forward, right)
    rolled_right = np.cos(roll) * right + np.sin(roll) * down
    rolled_down = np.cos(roll) * down - np.sin(roll) * right
    return np.stack([rolled_right, rolled_down, forward], axis=-1)


def view_angles(rotation: FloatArray) -> tuple[float, float, float]:
    """Azimuth, elevation and roll in degrees of a camera-to-world rotation; the inverse of `camera_to_world`.

    Examples
    --------
    >>> np.round(view_angles(camera_to_world(200.0, 35.0, -4.0)), 6).tolist()
    [200.0, 35.0, -4.0]
    """
    right, _, forward = np.asarray(rotation, float).T
    elevation = float(np.degrees(-np.arcsin(np.clip(forward[2], -1.0, 1.0))))
    azimuth = float(np.degrees(np.arctan2(forward[0], forward[1])) % 360.0)
    level_right, level_down, _ = camera_to_world(azimuth, elevation).T
    roll = float(np.degrees(np.arctan2(right @ level_down, right @ level_right)))
    return azimuth, elevation, roll


def direction_to_equirectangular(directions: FloatArray, height: int, width: int) -> FloatArray:
    """Panorama coordinates (column, row) in pixels of world directions, (..., 3) -> (..., 2).

    Pixel centres are at integer + 0.5; columns run over 0..width and wrap.

    Examples
    --------
    >>> direction_to_equirectangular(np.array([1.0, 0, 0]), 4, 8).tolist()  # +X is in the middle
    [4.0, 2.0]
    """
    x, y, z = np.moveaxis(np.asarray(directions), -1, 0)
    u = 0.5 - np.arctan2(y, x) / (2 * np.pi)
    v = 0.5 + np.arctan2(z, np.hypot(x, y)) / np.pi
    return np.stack([u * width, (1 - v) * height], axis=-1)


def equirectangular_to_direction(points_px: FloatArray, height: int, width: int) -> FloatArray:
    """World directions of panorama coordinates (column, row) in pixels, (..., 2) -> (..., 3) unit vectors."""
    column, row = np.moveaxis(np.asarray(points_px), -1, 0)
    longitude = (0.5 - column / width) * 2 * np.pi
    latitude = (0.5 - row / height) * np.pi
    return np.stack(
        [np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)],
        axis=-1,
    )


def panorama_directions(height: int, width: int) -> FloatArray:
    """World directions of the pixel centres of a panorama, (H, W, 3)."""
    columns, rows = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    return equirectangular_to_direction(np.stack([columns, rows], axis=-1), height, width)


def panorama_solid_angles(height: int, width: int) -> FloatArray:
    """Solid angle of a pixel in each row of a panorama, (H, 1) steradians, summing with the width to 4 pi.

    Examples
    --------
    >>> float((panorama_solid_angles(64, 128).sum() * 128 / np.pi).round(6))
    4.0
    """
    edges = np.sin(np.pi * (0.5 - np.arange(height + 1) / height))
    return ((edges[:-1] - edges[1:]) * 2 * np.pi / width)[:, None]


def bearing_to_direction(azimuth_deg: FloatArray | float, elevation_deg: FloatArray | float) -> FloatArray:
    """World direction (..., 3) of a compass bearing (0 = +Y, clockwise from above) and an elevation, in degrees.

    Examples
    --------
    >>> bearing_to_direction(90, 0).round(6).tolist()
    [1.0, 0.0, 0.0]
    """
    azimuth, elevation = np.radians(azimuth_deg), np.radians(elevation_deg)
    azimuth, elevation = np.broadcast_arrays(azimuth, elevation)
    return np.stack(
        [np.sin(azimuth) * np.cos(elevation), np.cos(azimuth) * np.cos(elevation), np.sin(elevation)], axis=-1
    )


def direction_to_bearing(directions: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Compass bearing in 0..360 and elevation, in degrees, of world directions (..., 3)."""
    x, y, z = np.moveaxis(np.asarray(directions), -1, 0)
    return np.degrees(np.arctan2(x, y)) % 360.0, np.degrees(np.arctan2(z, np.hypot(x, y)))

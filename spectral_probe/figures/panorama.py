"""A spectral panorama as a picture: colours as the eye would see them, unseen directions hatched."""

from __future__ import annotations

from math import gcd

import cv2
import numpy as np
from matplotlib.axes import Axes

from ..large import strips
from ..model import BoolArray, SpectralPanorama
from ..spectra.colorimetry import panorama_xyz
from .display import Picture, exposure_for_key, tone_map, write_png
from .style import SOFT_INK, hatching

__all__ = ["draw_panorama", "hatch_invalid", "panorama_preview", "tone_map", "write_png"]


def panorama_preview(
    panorama: SpectralPanorama, *, exposure: float | None = None, max_width_px: int = 2048
) -> Picture:
    """A panorama as an sRGB picture.

    Parameters
    ----------
    panorama
        The panorama (H, W).
    exposure
        Factor to linear display values; by default the sphere's median luminance becomes a middle grey.
    max_width_px
        Wider panoramas are made smaller by area averages (in linear light).

    Returns
    -------
    ndarray
        (H', W', 3) uint8; directions that are not valid are dimmed and hatched.
    """
    height, width = panorama.valid.shape
    size = (width, height)
    if width > max_width_px:
        size = (max_width_px, max(1, round(height * max_width_px / width)))
    luminance = np.empty((height, width), np.float32)
    parts = []
    for rows in strips(height, width, multiple=height // gcd(height, size[1])):
        xyz = panorama_xyz(panorama, rows)
        luminance[rows] = xyz[..., 1]
        small = (size[0], len(xyz) * size[1] // height)
        parts.append(cv2.resize(xyz, small, interpolation=cv2.INTER_AREA) if width > max_width_px else xyz)
    xyz = np.concatenate(parts)
    if exposure is None:
        elevation_rad = (0.5 - (np.arange(height) + 0.5) / height) * np.pi
        exposure = exposure_for_key(luminance, panorama.valid, np.cos(elevation_rad)[:, None])
    valid = panorama.valid
    if width > max_width_px:
        valid = np.asarray(cv2.resize(valid.astype(np.float32), size, interpolation=cv2.INTER_AREA)) > 0.5
    return hatch_invalid(tone_map(xyz, exposure), valid)


def hatch_invalid(picture: Picture, valid: BoolArray) -> Picture:
    """The picture (H, W, 3) with the pixels that are not valid dimmed to a grey third and hatched."""
    grey = picture.mean(-1, keepdims=True) * 0.3 + 36
    stripes = hatching(valid, max(6.0, valid.shape[1] / 110))[..., None] * 34.0
    return np.where(valid[..., None], picture, np.clip(grey + stripes, 0, 255).astype(np.uint8))


def draw_panorama(axes: Axes, picture: Picture) -> None:
    """Show a panorama with a scale of compass bearings (0 = +Y, clockwise) and elevations in degrees."""
    # Blender's equirectangular: the left edge looks along -X (bearing -90), the middle along +X (bearing 90).
    axes.imshow(picture, extent=(-90.0, 270.0, -90.0, 90.0), aspect="equal")
    axes.set_xticks([-45, 0, 45, 90, 135, 180, 225], ["315°", "0°", "45°", "90°", "135°", "180°", "225°"])
    axes.set_yticks([-45, 0, 45], ["−45°", "0°", "45°"])
    axes.tick_params(length=2.0, color=SOFT_INK, pad=2.0)
    for spine in axes.spines.values():
        spine.set_visible(False)

"""Differences of XYZ images as all rendering benchmarks state them, and pictures of them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cv2
import numpy as np

type Array = np.ndarray[Any, Any]

BLUR_PX = 3.0
"""Standard deviation of the Gaussian that both images are blurred by before colours are compared."""


def exposure(reference: Array) -> float:
    """Factor that brings the 95th percentile of an XYZ image's luminance to 1."""
    return float(1.0 / np.percentile(reference[..., 1], 95))


def colour_errors(xyz: Array, reference: Array, blur_px: float = BLUR_PX) -> Array:
    """dE2000 (H, W) of an XYZ image against a reference, both blurred, under a white D65 of the reference's exposure.

    Values are clipped at three times white.
    """
    from extension import core

    colorimetry = core("spectral_probe.spectra.colorimetry")
    scale = exposure(reference)
    images = [image.astype(np.float64) * scale for image in (xyz, reference)]
    if blur_px:
        images = [cv2.GaussianBlur(image, (0, 0), blur_px) for image in images]
    white = np.array(colorimetry.white_xyz("D65"))
    return np.asarray(colorimetry.delta_e_2000(*(np.clip(i, 0.0, 3.0) for i in images), white))


def differences(xyz: Array, reference: Array, blur_px: float = BLUR_PX) -> dict[str, Any]:
    """Mean tristimulus ratios and dE2000 of an image against a reference (`colour_errors`)."""
    error = colour_errors(xyz, reference, blur_px)
    return {
        "mean_ratio_xyz": (xyz.mean((0, 1), float) / reference.mean((0, 1), float)).round(5).tolist(),
        "de2000_mean": round(float(error.mean()), 3),
        "de2000_p99": round(float(np.percentile(error, 99)), 3),
        "de2000_max": round(float(error.max()), 3),
    }


def srgb(xyz: Array, scale: float) -> Array:
    """An XYZ image times a scale as 8-bit sRGB (H, W, 3), its white at 0.8."""
    from extension import core

    linear = np.clip(core("spectral_probe.spectra.colorimetry").xyz_to_rec709(xyz) * scale * 0.8, 0.0, 1.0)
    encoded = np.where(linear < 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.round(encoded * 255).astype(np.uint8)


def write_preview(path: Path, xyz: Array, scale: float) -> None:
    """An sRGB PNG of an XYZ image."""
    cv2.imwrite(str(path), srgb(xyz, scale)[..., ::-1])


def write_sheet(path: Path, images: Mapping[str, Array], scale: float) -> None:
    """XYZ images side by side with their names below, as PNG."""
    columns = []
    for name, xyz in images.items():
        picture = np.ascontiguousarray(srgb(xyz, scale)[..., ::-1])
        label = np.full((20, picture.shape[1], 3), 255, np.uint8)
        cv2.putText(label, name, (4, 14), cv2.FONT_HERSHEY_SIMPLEX, 0.4, (0, 0, 0), 1, cv2.LINE_AA)
        columns.append(np.concatenate([picture, label]))
    cv2.imwrite(str(path), np.concatenate(columns, axis=1))

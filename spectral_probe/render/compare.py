"""The spectral render beside Cycles' RGB render: CIEDE2000 map, statistics, and shift of chromaticity.

Both images come as tristimulus values on one scale. Monte-Carlo noise adds to every colour difference, so the
numbers are given raw and, where a blur is asked for, after the same Gaussian blur of both images.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from ..errors import FileFormatError
from ..files.atomic import written_whole
from ..model import BoolArray, FloatArray
from ..spectra.colorimetry import chromaticity, delta_e_2000, white_xyz

WHITE_PERCENTILE = 95.0
"""The luminance of white, where none is given: this percentile of the spectral image's."""

CLIP = 3.0
"""Tristimulus values, relative to white, above which a highlight is a highlight in either image."""


@dataclass(frozen=True)
class Differences:
    """Statistics of dE2000 over some pixels; `above_1` and `above_2` are fractions of the pixels in 0..1."""

    mean: float
    median: float
    p95: float
    max: float
    above_1: float
    above_2: float
    pixels: int


@dataclass(frozen=True)
class RegionComparison:
    """The comparison over the whole image or one object.

    `raw` has the noise of both renders in it; `blurred` is None without a blur. `xy_spectral` and `xy_rgb`
    are the chromaticities of the region's mean tristimulus values (its light added up: noise averages out),
    and `delta_e_of_means` is the dE2000 of those means.
    """

    name: str
    raw: Differences
    blurred: Differences | None
    xy_spectral: tuple[float, float]
    xy_rgb: tuple[float, float]
    delta_e_of_means: float

    @property
    def xy_shift(self) -> tuple[float, float]:
        """Shift of chromaticity from the spectral to the RGB render, (dx, dy)."""
        return self.xy_rgb[0] - self.xy_spectral[0], self.xy_rgb[1] - self.xy_spectral[1]

    @property
    def differences(self) -> Differences:
        """The statistics to quote: blurred where there are any, else raw."""
        return self.raw if self.blurred is None else self.blurred


@dataclass(frozen=True)
class Comparison:
    """A spectral and an RGB render of one scene compared.

    Parameters
    ----------
    delta_e
        (H, W) float32 dE2000 pixel by pixel, NaN where not `valid`.
    delta_e_blurred
        (H, W) float32 the same after the blur; None without one.
    valid
        (H, W) False where a pixel is not finite in one of the images, or black in both.
    white_xyz
        (3,) tristimulus values of white, D65, on the images' own scale.
    blur_px
        Standard deviation of the blur in pixels, 0 for none.
    clipped_fraction
        Share of the valid pixels with a tristimulus value below 0 or above 3 times white's Y in either image.
    image
        The whole image's numbers.
    objects
        The objects' numbers, in the order of their masks.
    unseen_objects
        Names of objects without a valid pixel.
    not_finite
        How many pixels of the spectral and of the RGB image are not finite.
    """

    delta_e: FloatArray
    delta_e_blurred: FloatArray | None
    valid: BoolArray
    white_xyz: FloatArray
    blur_px: float
    clipped_fraction: float
    image: RegionComparison
    objects: tuple[RegionComparison, ...]
    unseen_objects: tuple[str, ...]
    not_finite: tuple[int, int] = (0, 0)

    @property
    def delta_e_map(self) -> FloatArray:
        """The map to show: blurred where there is one, else raw."""
        return self.delta_e if self.delta_e_blurred is None else self.delta_e_blurred


def compare_images(
    xyz_spectral: FloatArray,
    xyz_rgb: FloatArray,
    *,
    white_luminance: float | None = None,
    object_masks: Mapping[str, BoolArray] | None = None,
    blur_px: float = 0.0,
) -> Comparison:
    """Colour differences between a spectral and an RGB render of the same scene.

    Both are scaled by one number, so that `white_luminance` becomes Y = 1 of a D65 white, and clipped to
    0..3: highlights far above white would only measure their brightness, and noise can be negative.

    Parameters
    ----------
    xyz_spectral, xyz_rgb
        (H, W, 3) tristimulus values on the same scale.
    white_luminance
        Y of white; by default the 95th percentile of the spectral image's Y over its valid pixels.
    object_masks
        (H, W) mask of each object by name.
    blur_px
        Standard deviation of a Gaussian blur applied to both images in linear light, to take the noise out.

    Returns
    -------
    Comparison

    Raises
    ------
    FileFormatError
        If the images differ in size, one of them is black or has more pixels that are not finite than others, or a mask does
        not fit them.

    Notes
    -----
    A pixel that is black in both images (an empty background) would count as a perfect match; it is left out.
    The blur weighs valid pixels only, but it does mix an object's rim with what lies behind it.

    Examples
    --------
    >>> grey = np.full((4, 4, 3), 0.5) * white_xyz()
    >>> compare_images(grey, grey).image.raw.max
    0.0
    >>> round(compare_images(grey, grey * 0.9, white_luminance=1.0).image.raw.mean, 2)
    2.33
    """
    spectral, rgb, valid = _prepared(xyz_spectral, xyz_rgb)
    if white_luminance is None:
        white_luminance = float(np.percentile(spectral[valid, 1], WHITE_PERCENTILE))
    if not white_luminance > 0:
        raise FileFormatError("The spectral image is black nearly everywhere. Give the luminance of white.")
    white = white_xyz("D65") * white_luminance
    raw = _delta_e_map(spectral, rgb, valid, white)
    blurred = None
    if blur_px > 0:
        blurred = _delta_e_map(_blur(spectral, valid, blur_px), _blur(rgb, valid, blur_px), valid, white)
    pair = _Pair(spectral, rgb, white, raw, blurred)
    objects, unseen = [], []
    for name, mask in (object_masks or {}).items():
        if mask.shape != valid.shape:
            raise FileFormatError(
                f'The mask of "{name}" is {_size(mask)} pixels, the images are {_size(valid)}.'
            )
        seen = np.asarray(mask, bool) & valid
        if seen.any():
            objects.append(pair.region(name, seen))
        else:
            unseen.append(name)
    both = np.stack([spectral[valid], rgb[valid]], axis=1)
    outside = ((both < 0) | (both > CLIP * white_luminance)).any(axis=(1, 2))
    return Comparison(
        delta_e=raw,
        delta_e_blurred=blurred,
        valid=valid,
        white_xyz=white,
        blur_px=blur_px,
        clipped_fraction=float(outside.mean()),
        image=pair.region("image", valid),
        objects=tuple(objects),
        unseen_objects=tuple(unseen),
        not_finite=(_not_finite(xyz_spectral), _not_finite(xyz_rgb)),
    )


def comparison_report(comparison: Comparison) -> dict[str, Any]:
    """The numbers of a comparison as plain data for JSON."""

    def row(region: RegionComparison) -> dict[str, Any]:
        return asdict(region) | {"xy_shift": region.xy_shift}

    height, width = comparison.valid.shape
    return {
        "size_px": [width, height],
        "white_xyz": [float(value) for value in comparison.white_xyz],
        "clip_relative_to_white": CLIP,
        "clipped_fraction": comparison.clipped_fraction,
        "valid_fraction": float(comparison.valid.mean()),
        "pixels_not_finite": list(comparison.not_finite),
        "blur_px": comparison.blur_px,
        "image": row(comparison.image),
        "objects": [row(region) for region in comparison.objects],
        "unseen_objects": list(comparison.unseen_objects),
    }


def write_comparison(path: Path, comparison: Comparison, further: Mapping[str, Any] | None = None) -> None:
    """Write the numbers of a comparison, and further ones by name, as JSON (`compare.json`)."""
    told = {**comparison_report(comparison), **(further or {})}
    with written_whole(path) as temporary:
        temporary.write_text(json.dumps(told, indent=2, allow_nan=False) + "\n", encoding="utf-8")


def _prepared(xyz_spectral: FloatArray, xyz_rgb: FloatArray) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Both images in float64 with invalid pixels at 0, and the mask of the valid ones."""
    for image in (xyz_spectral, xyz_rgb):
        if image.ndim != 3 or image.shape[2] != 3:
            raise FileFormatError(
                f"An image to compare has the shape {image.shape}; three channels are needed."
            )
    if xyz_spectral.shape != xyz_rgb.shape:
        raise FileFormatError(
            f"The spectral image is {_size(xyz_spectral)} pixels, the RGB image {_size(xyz_rgb)}. "
            "Render both at one size."
        )
    for name, image in (("spectral", xyz_spectral), ("RGB", xyz_rgb)):
        _check_seen(name, image)
    finite = np.isfinite(xyz_spectral).all(-1) & np.isfinite(xyz_rgb).all(-1)
    spectral, rgb = (np.where(finite[..., None], image, 0).astype(float) for image in (xyz_spectral, xyz_rgb))
    valid = finite & ((spectral > 0).any(-1) | (rgb > 0).any(-1))
    if not valid.any():
        raise FileFormatError(
            "There is nothing to compare: every pixel is black or not a number in these images."
        )
    return spectral, rgb, valid


def _check_seen(name: str, image: FloatArray) -> None:
    """Refuse an image that shows nothing."""
    bad = _not_finite(image)
    if 2 * bad > image.shape[0] * image.shape[1]:
        raise FileFormatError(
            f"{bad} of the {image.shape[0] * image.shape[1]} pixels of the {name} image are not numbers. Render it again."
        )
    if not (image > 0).any():  # what is not a number is not above 0 either
        raise FileFormatError(
            f"The {name} image is black in every pixel. Check the scene's light and camera, and render it again."
        )


def _not_finite(image: FloatArray) -> int:
    """How many pixels of an image (H, W, C) are not finite."""
    return int(np.count_nonzero(~np.isfinite(image).all(-1)))


def _size(image: FloatArray | BoolArray) -> str:
    return f"{image.shape[1]} x {image.shape[0]}"


def _blur(image: FloatArray, valid: BoolArray, sigma_px: float) -> FloatArray:
    """Gaussian blur of the valid pixels of (H, W, 3), its weights renormalised beside invalid ones."""
    weights = valid.astype(float)
    summed = cv2.GaussianBlur(image * weights[..., None], (0, 0), sigma_px)
    total = cv2.GaussianBlur(weights, (0, 0), sigma_px)
    return np.asarray(summed / np.where(valid, total, 1.0)[..., None])


def _delta_e_map(spectral: FloatArray, rgb: FloatArray, valid: BoolArray, white: FloatArray) -> FloatArray:
    delta_e = np.full(valid.shape, np.nan, np.float32)
    ceiling = CLIP * white[1]
    delta_e[valid] = delta_e_2000(
        np.clip(spectral[valid], 0, ceiling), np.clip(rgb[valid], 0, ceiling), white
    )
    return delta_e


@dataclass(frozen=True)
class _Pair:
    """Two prepared images, their white, and their dE2000 maps without and with the blur."""

    spectral: FloatArray
    rgb: FloatArray
    white: FloatArray
    raw: FloatArray
    blurred: FloatArray | None

    def region(self, name: str, mask: BoolArray) -> RegionComparison:
        """The numbers of the pixels in a mask (H, W), all of them valid."""
        means = np.stack([self.spectral[mask].mean(0), self.rgb[mask].mean(0)])
        xy = chromaticity(means)
        clipped = np.clip(means, 0, CLIP * self.white[1])
        return RegionComparison(
            name=name,
            raw=_differences(self.raw[mask]),
            blurred=None if self.blurred is None else _differences(self.blurred[mask]),
            xy_spectral=(float(xy[0, 0]), float(xy[0, 1])),
            xy_rgb=(float(xy[1, 0]), float(xy[1, 1])),
            delta_e_of_means=float(delta_e_2000(clipped[0], clipped[1], self.white)),
        )


def _differences(delta_e: FloatArray) -> Differences:
    return Differences(
        mean=float(delta_e.mean(dtype=float)),
        median=float(np.median(delta_e)),
        p95=float(np.percentile(delta_e, 95)),
        max=float(delta_e.max()),
        above_1=float((delta_e > 1).mean()),
        above_2=float((delta_e > 2).mean()),
        pixels=int(delta_e.size),
    )

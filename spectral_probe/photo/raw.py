"""Camera raw through LibRaw, as linear camera RGB with the sensor's own saturation."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from ..errors import PhotographError
from ..files.silence import libraries_silenced
from ..model import BoolArray, Exposure, FloatArray, Photograph
from .exif import (
    EXIF_FOCAL_35MM,
    EXIF_ISO,
    POSSIBLE_F_NUMBER,
    POSSIBLE_FOCAL_MM,
    POSSIBLE_ISO,
    POSSIBLE_TIME_S,
    LensAndExposure,
    positive_tag,
    possible,
    sensor_width_mm,
)
from .file_kind import check_size, cut_short, mapped, misnamed, number
from .read import brightest, neighbourhood
from .tiff import check_tiff, exif_of_tiff

PEDESTAL = 256
"""Raw levels kept below black. LibRaw cuts everything under its black level to 0, which would make the mean
of a dark, noisy area too bright; with its black set this much lower the noise survives on both sides."""

DEMOSAIC_REACH_PX = 2
"""Sensels this far away enter a demosaiced pixel (AHD interpolates along 5-sensel rows and columns)."""

CLIP_SHARE = 0.98
"""Share of the saturation level from which a sensel counts as clipped: full wells differ by about a
hundredth."""

_DARK = 1e-4
"""Share of the white level that each channel's mean must reach for its ratios to be known."""

_LEAST_BALANCE = 0.1
"""Least factor a channel is given while it is demosaiced."""


def read_raw(path: Path, *, half_size: bool = False) -> Photograph:
    """Read a camera raw file of any kind that LibRaw knows.

    Parameters
    ----------
    path
        DNG, NEF, CR2, CR3, ARW, RAF, ...
    half_size
        One pixel for each 2 x 2 sensels: red, the mean of both greens, and blue as the sensor measured them, without
        interpolation.

    Returns
    -------
    Photograph
        Pixels (H, W, 3) float32 of linear camera RGB without white balance: black is 0 and the saturation
        level 1. Noise below black stays negative. A pixel is clipped when any sensel that demosaicing drew
        on was saturated.
    """
    import rawpy

    plain_tiff = _check_whole(path)
    try:
        with libraries_silenced(), rawpy.imread(str(path)) as raw:
            check_size(path, raw.sizes.width, raw.sizes.height)
            if raw.num_colors != 3:
                raise PhotographError(
                    f"{path.name} has no red, green and blue. Use a camera with a colour sensor."
                )
            pixels, clipped = _half_size(raw, path) if half_size else _full_size(raw, path)
            return Photograph(path=path, pixels=pixels, clipped=clipped, camera_raw=True, **_tags(raw, path))
    except (rawpy.LibRawFileUnsupportedError, rawpy.LibRawIOError) as error:
        if plain_tiff:
            raise PhotographError(misnamed(path, "TIFF")) from error
        raise PhotographError(
            f"{path.name} is no photograph this program knows, or it is broken. Use camera raw, TIFF, PNG, JPEG, EXR or HDR."
        ) from error
    except (rawpy.LibRawError, OSError, MemoryError) as error:
        raise PhotographError(f"{path.name} is a broken raw file. Copy it from the camera again.") from error


def _check_whole(path: Path) -> bool:
    """Refuse a file that is cut short, before LibRaw writes its own line about it; whether it is a TIFF without raw data.

    DNG, NEF, ARW, CR2, PEF and others are built as TIFF, CR3 of boxes that state their lengths.
    """
    data = mapped(path)
    head = data[:12].tobytes()
    if head[:4] in (b"II*\0", b"MM\0*"):
        return not any(directory.raw for directory in check_tiff(path))
    if head[4:8] == b"ftyp":
        at = 0
        while at + 8 <= len(data):
            length = number(data, at, 4)
            if length == 1 and at + 16 <= len(data):
                length = number(data, at + 8, 8)
            at = len(data) if length == 0 else at + max(length, 8)
        if at > len(data):
            raise PhotographError(cut_short(path))
    if head.startswith(b"FUJIFILM") and len(data) > 108:
        start, length = number(data, 100, 4), number(data, 104, 4)
        if start + length > len(data):
            raise PhotographError(cut_short(path))
    return False


def _tags(raw: Any, path: Path) -> LensAndExposure:
    tags = exif_of_tiff(path)
    return {
        "exposure": _exposure(raw, tags),
        "focal_mm": possible(float(raw.other.focal_length), POSSIBLE_FOCAL_MM),
        "focal_35mm": possible(positive_tag(tags, EXIF_FOCAL_35MM), POSSIBLE_FOCAL_MM),
        "sensor_width_mm": sensor_width_mm(tags),
    }


def _exposure(raw: Any, tags: Any) -> Exposure | None:
    """Exposure as LibRaw read it; 0 and what cannot be mean that the file does not say."""
    other = raw.other
    time_s = possible(float(other.shutter_speed), POSSIBLE_TIME_S)
    if time_s is None:
        return None
    iso = possible(float(other.iso_speed) or positive_tag(tags, EXIF_ISO), POSSIBLE_ISO)
    return Exposure(time_s, iso or 100.0, possible(float(other.aperture), POSSIBLE_F_NUMBER) or 1.0)


def _full_size(raw: Any, path: Path) -> tuple[FloatArray, BoolArray]:
    clipped_sensels = _clipped_sensels(raw)
    pixels = _develop(raw, path)
    return pixels, _clipped_pixels(raw, clipped_sensels, pixels)


def _half_size(raw: Any, path: Path) -> tuple[FloatArray, BoolArray]:
    """Pixels of 2 x 2 sensels of a Bayer mosaic; other sensors are developed and then averaged."""
    clipped = _clipped_sensels(raw)
    if clipped is None or raw.raw_pattern is None or raw.raw_pattern.shape != (2, 2):
        pixels, clipped = _full_size(raw, path)
        height, width = pixels.shape[0] // 2, pixels.shape[1] // 2
        pixels, clipped = pixels[: 2 * height, : 2 * width], clipped[: 2 * height, : 2 * width]
        averaged = cv2.resize(pixels, (width, height), interpolation=cv2.INTER_AREA)
        return np.asarray(averaged), clipped.reshape(height, 2, width, 2).any(axis=(1, 3))
    sensels = raw.raw_image_visible
    height, width = sensels.shape[0] // 2, sensels.shape[1] // 2
    colours = raw.raw_colors_visible[:2, :2]
    black = np.asarray(raw.black_level_per_channel, np.float32)
    scale = np.float32(1.0 / (raw.white_level - black.min()))
    pixels = np.zeros((height, width, 3), np.float32)
    reached = np.zeros((height, width), bool)
    counts = np.zeros(3)
    for row, column in np.ndindex(2, 2):
        colour = int(colours[row, column])
        channel = 1 if colour == 3 else colour  # the second green has a number of its own
        own = (slice(row, 2 * height, 2), slice(column, 2 * width, 2))
        pixels[..., channel] += (sensels[own] - black[colour]) * scale
        reached |= clipped[own]
        counts[channel] += 1
    pixels[..., counts == 2] *= np.float32(0.5)
    flip = raw.sizes.flip
    return np.ascontiguousarray(turned(pixels, flip)), np.ascontiguousarray(turned(reached, flip))


def _develop(raw: Any, path: Path) -> FloatArray:
    """Demosaic with the pedestal under black; without it where the levels do not come out as they should."""
    import rawpy

    black = np.asarray(raw.black_level_per_channel, float)
    for balance in (_balance(raw, black), np.ones(3)):
        with_pedestal = _developed_over_pedestal(raw, rawpy, black, balance)
        if with_pedestal is not None:
            return with_pedestal
    # Opened afresh: LibRaw keeps the changed black levels of an earlier run.
    with rawpy.imread(str(path)) as fresh:
        plain = fresh.postprocess(**_parameters(rawpy))
    return np.asarray(plain, np.float32) / np.float32(65535.0)


def _balance(raw: Any, black: FloatArray) -> FloatArray:
    """Factors (3,), 1 at most, that make the picture grey on average while it is demosaiced.

    Demosaicing finds edges by what all channels have in common: without balance, dark fringes of colour run along lamps and
    windows. The factors are divided out again.
    """
    sensels, colours = raw.raw_image_visible, raw.raw_colors_visible
    unclipped = sensels < CLIP_SHARE * raw.white_level
    means = np.zeros(3)
    for channel in range(3):
        own = unclipped & ((colours == channel) | ((colours == 3) & (channel == 1)))
        means[channel] = (sensels[own] - black[channel]).mean() if own.any() else 0.0
    if not (means > _DARK * raw.white_level).all():
        return np.ones(3)
    return np.asarray(np.maximum(means.min() / means, _LEAST_BALANCE))


def _parameters(rawpy: Any) -> dict[str, Any]:
    return {
        "user_wb": [1.0, 1.0, 1.0, 1.0],
        "no_auto_bright": True,
        "gamma": (1.0, 1.0),
        "output_color": rawpy.ColorSpace.raw,
        "output_bps": 16,
        "adjust_maximum_thr": 0.0,  # else LibRaw sets the white level from each picture's own maximum
    }


def _developed_over_pedestal(
    raw: Any, rawpy: Any, black: FloatArray, balance: FloatArray
) -> FloatArray | None:
    """Pixels with the noise below black kept, or None where LibRaw's levels are not the simple ones."""
    if raw.raw_type != rawpy.RawType.Flat or black.min() < PEDESTAL:
        return None
    lowered = [int(level) - PEDESTAL for level in black]
    balanced = {
        "user_wb": [*balance, balance[1]],
        "highlight_mode": rawpy.HighlightMode.Ignore,  # else the smallest factor becomes 1, and the others clip
    }
    developed = raw.postprocess(**_parameters(rawpy) | balanced, user_black=0, user_cblack=lowered)
    scale = balance * 65535.0 / (raw.white_level - black.min() + PEDESTAL)
    if not _levels_agree(raw, np.asarray(developed), black, scale):
        return None
    # LibRaw rounds down: half a level belongs to what it gives.
    gain = (1.0 / (scale * (raw.white_level - black.min()))).astype(np.float32)
    pixels: FloatArray = np.multiply(developed, gain, dtype=np.float32)
    pixels += np.float32(0.5) * gain - np.float32(PEDESTAL / (raw.white_level - black.min()))
    return pixels


def _levels_agree(raw: Any, developed: npt.NDArray[Any], black: FloatArray, scale: FloatArray) -> bool:
    """Whether developed values are the sensels' own: demosaicing keeps the colour that a sensel measured."""
    sensels = turned(raw.raw_image_visible, raw.sizes.flip)
    colours = turned(raw.raw_colors_visible, raw.sizes.flip)
    if sensels.shape != developed.shape[:2]:
        return False
    step = max(1, min(sensels.shape) // 400) | 1  # odd, so that every colour of the mosaic is met
    sensels, colours, developed = (a[::step, ::step] for a in (sensels, colours, developed))
    for colour in range(3):
        chosen = (colours == colour) & (sensels < raw.white_level)
        if not chosen.any():
            return False
        expected = (sensels[chosen] - black[colour] + PEDESTAL) * scale[colour]
        if abs(float(np.median(developed[..., colour][chosen] - expected))) > scale.max():
            return False
    return True


def turned(image: npt.NDArray[Any], flip: int) -> npt.NDArray[Any]:
    """Turn the sensor's image as LibRaw turns its result: of `flip`, bit 1 mirrors rows, bit 0 columns, bit 2 swaps both.

    Flip 3 is 180 degrees, 5 a quarter turn to the left, 6 to the right.
    """
    if flip & 2:
        image = image[::-1]
    if flip & 1:
        image = image[:, ::-1]
    return image.swapaxes(0, 1) if flip & 4 else image


def _clipped_sensels(raw: Any) -> BoolArray | None:
    """Saturated sensels in the sensor's own orientation; None where the file holds no mosaic."""
    import rawpy

    if raw.raw_type != rawpy.RawType.Flat or raw.raw_image_visible is None:
        return None
    sensels = raw.raw_image_visible
    black = float(np.min(raw.black_level_per_channel))
    return np.asarray(sensels >= black + CLIP_SHARE * (saturation_level(sensels, raw.white_level) - black))


def saturation_level(sensels: npt.NDArray[Any], white_level: int) -> int:
    """The level at which sensels really saturate: where the brightest pile up, at most `white_level`.

    Cameras often saturate a little below the white level that their file states. A pile-up is many more
    values at the very top than just under it.

    Examples
    --------
    >>> saturation_level(np.array([100, 2000] * 50 + [15000] * 100), 16383)
    15000
    >>> saturation_level(np.arange(2000), 16383)
    16383
    """
    top = int(sensels.max())
    if top < 0.9 * white_level or top >= white_level:
        return white_level
    band = max(1, top // 500)
    at_top = np.count_nonzero(sensels > top - band)
    below = np.count_nonzero((sensels <= top - band) & (sensels > top - 2 * band))
    return top if at_top > 32 and at_top > 5 * below else white_level


def _clipped_pixels(raw: Any, sensels: BoolArray | None, pixels: FloatArray) -> BoolArray:
    if sensels is not None:
        reached = neighbourhood(sensels, DEMOSAIC_REACH_PX)
        upright = turned(reached, raw.sizes.flip)
        if upright.shape == pixels.shape[:2]:
            return np.ascontiguousarray(upright)
    # No mosaic, or LibRaw resized it (Fuji's diagonal sensors): judge the developed values.
    return np.asarray(brightest(pixels) >= CLIP_SHARE)

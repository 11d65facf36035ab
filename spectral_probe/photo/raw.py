"""Camera raw through LibRaw, as linear camera RGB with the sensor's own saturation."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import PhotographError
from ..model import BoolArray, Exposure, FloatArray, Photograph
from .read import EXIF_FOCAL_35MM, EXIF_ISO, exif_of_tiff, neighbourhood, positive_tag

PEDESTAL = 256
"""Raw levels kept below black. LibRaw cuts everything under its black level to 0, which would make the mean
of a dark, noisy area too bright; with its black set this much lower the noise survives on both sides."""

DEMOSAIC_REACH_PX = 2
"""Sensels this far away enter a demosaiced pixel (AHD interpolates along 5-sensel rows and columns)."""

CLIP_SHARE = 0.98
"""Share of the saturation level from which a sensel counts as clipped: full wells differ by about a
hundredth."""


def read_raw(path: Path) -> Photograph:
    """Read a camera raw file of any kind that LibRaw knows.

    Parameters
    ----------
    path
        DNG, NEF, CR2, CR3, ARW, RAF, ...

    Returns
    -------
    Photograph
        Pixels (H, W, 3) float32 of linear camera RGB without white balance: black is 0 and the saturation
        level 1. Noise below black stays negative. A pixel is clipped when any sensel that demosaicing drew
        on was saturated.
    """
    import rawpy

    try:
        with rawpy.imread(str(path)) as raw:
            if raw.num_colors != 3:
                raise PhotographError(
                    f"{path.name} has no red, green and blue. Use a camera with a colour sensor."
                )
            tags = exif_of_tiff(path)
            clipped_sensels = _clipped_sensels(raw)
            pixels = _develop(raw, path)
            return Photograph(
                path=path,
                pixels=pixels,
                clipped=_clipped_pixels(raw, clipped_sensels, pixels),
                exposure=_exposure(raw, tags),
                focal_mm=float(raw.other.focal_length) or None,
                focal_35mm=positive_tag(tags, EXIF_FOCAL_35MM),
                camera_raw=True,
            )
    except (rawpy.LibRawFileUnsupportedError, rawpy.LibRawIOError) as error:
        raise PhotographError(
            f"{path.name} is no photograph this program knows. Use camera raw, TIFF, PNG, JPEG, EXR or HDR."
        ) from error
    except (rawpy.LibRawError, OSError) as error:
        raise PhotographError(f"{path.name} is a broken raw file. Copy it from the camera again.") from error


def _exposure(raw: Any, tags: Any) -> Exposure | None:
    """Exposure as LibRaw read it; 0 means that the file does not say."""
    other = raw.other
    if not other.shutter_speed > 0.0:
        return None
    iso = float(other.iso_speed) or positive_tag(tags, EXIF_ISO) or 100.0
    return Exposure(float(other.shutter_speed), iso, float(other.aperture) or 1.0)


def _develop(raw: Any, path: Path) -> FloatArray:
    """Demosaic with the pedestal under black; without it where the levels do not come out as they should."""
    import rawpy

    with_pedestal = _developed_over_pedestal(raw, rawpy)
    if with_pedestal is not None:
        return with_pedestal
    # Opened afresh: LibRaw keeps the changed black levels of an earlier run.
    with rawpy.imread(str(path)) as fresh:
        plain = fresh.postprocess(**_parameters(rawpy))
    return np.asarray(plain, np.float32) / np.float32(65535.0)


def _parameters(rawpy: Any) -> dict[str, Any]:
    return {
        "user_wb": [1.0, 1.0, 1.0, 1.0],
        "no_auto_bright": True,
        "gamma": (1.0, 1.0),
        "output_color": rawpy.ColorSpace.raw,
        "output_bps": 16,
        "adjust_maximum_thr": 0.0,  # else LibRaw sets the white level from each picture's own maximum
    }


def _developed_over_pedestal(raw: Any, rawpy: Any) -> FloatArray | None:
    """Pixels with the noise below black kept, or None where LibRaw's levels are not the simple ones."""
    black = np.asarray(raw.black_level_per_channel, float)
    if raw.raw_type != rawpy.RawType.Flat or black.min() < PEDESTAL:
        return None
    lowered = [int(level) - PEDESTAL for level in black]
    developed = raw.postprocess(**_parameters(rawpy), user_black=0, user_cblack=lowered)
    scale = 65535.0 / (raw.white_level - black.min() + PEDESTAL)
    if not _levels_agree(raw, np.asarray(developed), black, scale):
        return None
    pixels = np.asarray(developed, np.float32) + np.float32(0.5)  # LibRaw rounds down
    pixels *= np.float32(1.0 / scale)
    pixels -= np.float32(PEDESTAL)
    pixels /= np.float32(raw.white_level - black.min())
    return pixels


def _levels_agree(raw: Any, developed: npt.NDArray[Any], black: FloatArray, scale: float) -> bool:
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
        expected = (sensels[chosen] - black[colour] + PEDESTAL) * scale
        if abs(float(np.median(developed[..., colour][chosen] - expected))) > scale:
            return False
    return True


def turned(image: npt.NDArray[Any], flip: int) -> npt.NDArray[Any]:
    """Turn the sensor's image as LibRaw turns its result: flip 3 is 180 degrees, 5 left, 6 right."""
    quarter_turns = {3: 2, 5: 1, 6: -1}.get(flip, 0)
    return np.rot90(image, quarter_turns) if quarter_turns else image


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
    return np.asarray(pixels.max(axis=-1) >= CLIP_SHARE)

"""What EXIF tags say of exposure and lens, without what cannot be true."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, TypedDict

from ..model import Exposure

EXIF_IFD = 0x8769
EXIF_TIME, EXIF_F_NUMBER, EXIF_ISO, EXIF_FOCAL, EXIF_FOCAL_35MM, EXIF_ORIENTATION = (
    0x829A, 0x829D, 0x8827, 0x920A, 0xA405, 0x0112,
)  # fmt: skip
_WIDTH_PX, _HEIGHT_PX, _PX_PER_UNIT_X, _PX_PER_UNIT_Y, _UNIT = 0xA002, 0xA003, 0xA20E, 0xA20F, 0xA210
_LONG_ISO = (
    0x8833,
    0x8832,
    0x8831,
)  # ISO speed, exposure index, output sensitivity: where 16 bits are too few
_UNIT_MM = {2: 25.4, 3: 10.0, 4: 1.0, 5: 0.001}
_FULL_FRAME_DIAGONAL_MM = 43.2666

POSSIBLE_TIME_S = (1e-7, 1e5)
POSSIBLE_ISO = (0.1, 1e7)
POSSIBLE_F_NUMBER = (0.3, 1000.0)
"""Ranges of what a photograph can be taken with; other values are as good as none (writers leave 0, 65535, 2^32 - 1)."""

POSSIBLE_FOCAL_MM = (0.5, 10000.0)
_POSSIBLE_SENSOR_MM = (2.0, 80.0)


class LensAndExposure(TypedDict):
    """The fields of `Photograph` that EXIF fills."""

    exposure: Exposure | None
    focal_mm: float | None
    focal_35mm: float | None
    sensor_width_mm: float | None


def lens_and_exposure(exif: Mapping[int, Any]) -> LensAndExposure:
    """All that tags say of a photograph."""
    return {
        "exposure": exposure_from_exif(exif),
        "focal_mm": possible(positive_tag(exif, EXIF_FOCAL), POSSIBLE_FOCAL_MM),
        "focal_35mm": possible(positive_tag(exif, EXIF_FOCAL_35MM), POSSIBLE_FOCAL_MM),
        "sensor_width_mm": sensor_width_mm(exif),
    }


def exposure_from_exif(exif: Mapping[int, Any]) -> Exposure | None:
    """Exposure from EXIF tags; None without a possible time. A missing ISO is 100, a missing f-number 1.

    Examples
    --------
    >>> exposure_from_exif({0x829A: 0.01, 0x8827: 200, 0x829D: 2.0})
    Exposure(time_s=0.01, iso=200.0, f_number=2.0)
    >>> exposure_from_exif({0x8827: 200}) is None
    True
    """
    time_s = possible(positive_tag(exif, EXIF_TIME), POSSIBLE_TIME_S)
    if time_s is None:
        return None
    iso = positive_tag(exif, EXIF_ISO)
    if iso is None or iso >= 65535:
        iso = next((value for tag in _LONG_ISO if (value := positive_tag(exif, tag)) is not None), None)
    f_number = possible(positive_tag(exif, EXIF_F_NUMBER), POSSIBLE_F_NUMBER)
    return Exposure(time_s, possible(iso, POSSIBLE_ISO) or 100.0, f_number or 1.0)


def sensor_width_mm(exif: Mapping[int, Any]) -> float | None:
    """Length of the sensor's longer side from the pixels per millimetre that EXIF gives; None without, or where impossible.

    Some programs resize a picture and leave these tags: a length that contradicts the 35 mm equivalent counts as none.

    Examples
    --------
    >>> round(sensor_width_mm({0xA002: 6000, 0xA003: 4000, 0xA20E: 2564.1, 0xA20F: 2564.1, 0xA210: 3}), 1)
    23.4
    """
    unit_mm = _UNIT_MM.get(int(positive_tag(exif, _UNIT) or 2), 25.4)
    sides = [
        pixels / density * unit_mm
        for pixel_tag, density_tag in ((_WIDTH_PX, _PX_PER_UNIT_X), (_HEIGHT_PX, _PX_PER_UNIT_Y))
        if (pixels := positive_tag(exif, pixel_tag)) and (density := positive_tag(exif, density_tag))
    ]
    if len(sides) != 2:
        return None
    length = possible(max(sides), _POSSIBLE_SENSOR_MM)
    focal, equivalent = positive_tag(exif, EXIF_FOCAL), positive_tag(exif, EXIF_FOCAL_35MM)
    if length and focal and equivalent:
        diagonal_ratio = math.hypot(*sides) / (_FULL_FRAME_DIAGONAL_MM * focal / equivalent)
        return length if 0.8 < diagonal_ratio < 1.25 else None
    return length


def possible(value: float | None, limits: tuple[float, float]) -> float | None:
    """The value where it lies within the limits, else None."""
    return value if value is not None and limits[0] <= value <= limits[1] else None


def positive_tag(exif: Mapping[int, Any], tag: int) -> float | None:
    """The value of a tag as a positive number (the first one where it holds several), or None."""
    value = exif.get(tag)
    if isinstance(value, tuple):
        value = value[0] if value else None
    if value is None:
        return None
    try:
        number = float(value)
    except (TypeError, ValueError, ZeroDivisionError, OverflowError):
        return None  # EXIF rationals may be 0/0, and some writers store text
    return number if math.isfinite(number) and number > 0.0 else None

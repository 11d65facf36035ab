"""What a photograph's file says of how it was taken, from its header alone: enough to tell which belong together."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ..errors import PhotographError
from ..files.silence import libraries_silenced
from ..model import Exposure
from .exif import EXIF_F_NUMBER, EXIF_IFD, EXIF_ORIENTATION, lens_and_exposure, positive_tag
from .file_kind import Kind, check_size, file_kind, jpeg_size, mapped
from .suffixes import PHOTOGRAPHS
from .tiff import TAGS_UNREADABLE, check_tiff, exif_of_tiff

type Encoding = Literal["raw", "converted", "radiance"]
"""How light is stored: the sensor's own values, a picture made of them, or radiance already."""

_MAKE, _MODEL, _LENS, _DATE, _DATE_TAKEN, _SUB_SECONDS = 0x10F, 0x110, 0xA434, 0x132, 0x9003, 0x9291
_SIDEWAYS = (5, 6, 7, 8)  # values of EXIF's orientation that swap width and height
_ENCODINGS: dict[Kind, Encoding] = {"raw": "raw", "OpenEXR": "radiance", "Radiance HDR": "radiance"}


@dataclass(frozen=True)
class PhotoRecord:
    """One photograph as its file describes it; what the file does not say is None or empty.

    `size_px` is (width, height) upright. `taken_s` counts seconds of the camera's own clock, from any start.
    `brightness` is the mean of the stored values in 0..1, looked at only where the file says no exposure.
    """

    path: Path
    encoding: Encoding = "converted"
    size_px: tuple[int, int] | None = None
    camera: str = ""
    lens: str = ""
    focal_mm: float | None = None
    exposure: Exposure | None = None
    f_number: float | None = None
    taken_s: float | None = None
    brightness: float | None = None
    has_sensor_width: bool = False
    """Whether the file says enough of the sensor for the focal length to be known in pixels."""

    @property
    def name(self) -> str:
        """Name of the file."""
        return self.path.name


def read_record(path: Path) -> PhotoRecord:
    """What a photograph's file says of it. Its pixels are read only where it does not say its exposure.

    Raises
    ------
    PhotographError
        If it is missing, no photograph by its name or content, or broken where it was looked at.
    """
    path = Path(path)
    if path.suffix.lower() not in PHOTOGRAPHS:
        file_kind(path)  # has better words where it is missing, a folder or a known kind of picture
        raise PhotographError(
            f"{path.name} is not a photograph that is read here. Give camera raw, TIFF, PNG, JPEG, EXR or HDR."
        )
    kind = file_kind(path)
    encoding = _ENCODINGS.get(kind, "converted")
    if encoding == "radiance":
        return PhotoRecord(path, encoding)
    size_px, tags = _raw_header(path) if kind == "raw" else _header(path, kind)
    if size_px is not None and int(positive_tag(tags, EXIF_ORIENTATION) or 1) in _SIDEWAYS:
        size_px = (size_px[1], size_px[0])
    known = lens_and_exposure(tags)
    make, model = (_text(tags.get(tag)) for tag in (_MAKE, _MODEL))
    return PhotoRecord(
        path,
        encoding,
        size_px,
        camera=model if model.casefold().startswith(make.casefold()) else f"{make} {model}".strip(),
        lens=_text(tags.get(_LENS)),
        focal_mm=known["focal_mm"],
        exposure=known["exposure"],
        f_number=positive_tag(tags, EXIF_F_NUMBER),
        taken_s=taken_s(tags),
        brightness=_brightness(path) if known["exposure"] is None and encoding == "converted" else None,
        has_sensor_width=bool(known["sensor_width_mm"] or known["focal_35mm"]),
    )


def size_px(path: Path) -> tuple[int, int] | None:
    """Width and height of a photograph as stored, from its header; None where the header is not looked into (EXR, HDR).

    Raises
    ------
    PhotographError
        If it is missing, no photograph by its content, or broken there.
    """
    kind = file_kind(path)
    if kind in _ENCODINGS and kind != "raw":
        return None
    return (_raw_header(path) if kind == "raw" else _header(path, kind))[0]


def taken_s(tags: Mapping[int, Any]) -> float | None:
    """When the shutter opened, in seconds of the camera's clock, from EXIF's date and its fraction of a second.

    The date a file was changed stands in only where the date it was taken is missing.

    Examples
    --------
    >>> one = {0x9003: "2023:04:06 16:51:33", 0x9291: "50"}
    >>> taken_s({0x9003: "2023:04:06 16:51:42"}) - taken_s(one)
    8.5
    >>> taken_s({0x9003: "0000:00:00 00:00:00"}) is None
    True
    """
    written = _text(tags.get(_DATE_TAKEN)) or _text(tags.get(_DATE))
    try:
        date = datetime.strptime(written[:19], "%Y:%m:%d %H:%M:%S")
    except ValueError:
        return None
    fraction = _text(tags.get(_SUB_SECONDS))
    seconds = (date - datetime(2000, 1, 1)).total_seconds()
    return seconds + (float(f"0.{fraction}") if fraction.isascii() and fraction.isdigit() else 0.0)


def _header(path: Path, kind: Kind) -> tuple[tuple[int, int] | None, Mapping[int, Any]]:
    """Size as stored, and EXIF tags, of a JPEG, PNG or TIFF."""
    if kind == "TIFF":
        found = check_tiff(path)
        largest = max(found, key=lambda directory: directory.size_px[0] * directory.size_px[1])
        return largest.size_px, exif_of_tiff(path)
    if kind == "PNG":
        head = mapped(path)[16:24].tobytes()
        width, height = int.from_bytes(head[:4]), int.from_bytes(head[4:])
        check_size(path, width, height)
    else:
        width, height = jpeg_size(path)
    return (width, height), _exif_of_picture(path, kind)


def _exif_of_picture(path: Path, kind: Kind) -> Mapping[int, Any]:
    """EXIF tags of a JPEG or PNG; empty where there are none, or where reading them would mean to decode the picture."""
    from PIL import JpegImagePlugin, PngImagePlugin

    reader = PngImagePlugin.PngImageFile if kind == "PNG" else JpegImagePlugin.JpegImageFile
    with warnings.catch_warnings(), path.open("rb") as file:
        warnings.simplefilter("ignore")  # of odd tags, which are as good as absent
        try:
            with reader(file) as image:
                if "exif" not in image.info and "Raw profile type exif" not in image.info:
                    return {}
                exif = image.getexif()
                return {**exif, **exif.get_ifd(EXIF_IFD)}
        except TAGS_UNREADABLE:
            return {}


def _raw_header(path: Path) -> tuple[tuple[int, int] | None, Mapping[int, Any]]:
    """Size and tags of camera raw: from its directories where it is built as TIFF and they tell the time, else by LibRaw."""
    tags: dict[int, Any] = dict(exif_of_tiff(path))
    if tags.get(_MODEL) and lens_and_exposure(tags)["exposure"] is not None:
        largest = max(check_tiff(path), key=lambda directory: directory.size_px[0] * directory.size_px[1])
        return largest.size_px, tags
    import rawpy

    try:
        with libraries_silenced(), rawpy.imread(str(path)) as raw:
            other, size_px = raw.other, (int(raw.sizes.width), int(raw.sizes.height))
            flip = int(raw.sizes.flip)
    except (rawpy.LibRawError, OSError, MemoryError) as error:
        raise PhotographError(
            f"{path.name} is no camera raw file that this program knows, or it is broken. Copy it from the camera again."
        ) from error
    told = {
        0x829A: float(other.shutter_speed),
        EXIF_F_NUMBER: float(other.aperture),
        0x8827: float(other.iso_speed),
        0x920A: float(other.focal_length),
        EXIF_ORIENTATION: 6 if flip & 4 else 1,
    }
    if other.timestamp.year > 1970:
        told[_DATE_TAKEN] = other.timestamp.strftime("%Y:%m:%d %H:%M:%S")
    return size_px, {**told, **tags}


def _brightness(path: Path) -> float | None:
    """Mean of the stored values, 0..1, from a picture an eighth of the size; None where it cannot be read."""
    import cv2

    from .read import opencv_silent

    try:
        with opencv_silent():
            small = cv2.imdecode(mapped(path), cv2.IMREAD_REDUCED_COLOR_8)
    except cv2.error:
        return None
    return None if small is None else float(np.mean(small)) / 255.0


def _text(value: Any) -> str:
    """A tag's text without the padding that some cameras write."""
    if isinstance(value, bytes):
        value = value.decode("ascii", "replace")
    return value.replace("\0", " ").strip() if isinstance(value, str) else ""

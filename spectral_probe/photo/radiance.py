"""Pictures that hold radiance as floating-point numbers: OpenEXR, Radiance HDR and floating-point TIFF.

They never clip. Pixels that are not finite, or negative beyond what noise, black subtraction and the ringing of resampling
leave around black, hold no radiance: they are 0 and marked, and the photograph's remarks count them. Small negative values
are kept, as in raw, where cutting them would make dark areas too bright.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import PhotographError
from ..files.silence import libraries_silenced
from ..model import BoolArray, FloatArray, Photograph
from .file_kind import broken, check_exr

DEEPEST_NEGATIVE = 0.05
"""Share of the picture's median brightness below zero that may still be noise about black or ringing."""

_RGB_NAMES = (("R", "G", "B"), ("r", "g", "b"), ("red", "green", "blue"), ("Red", "Green", "Blue"))


def radiance_photograph(
    path: Path, rgb: npt.NDArray[Any], unseen: BoolArray | None = None, **tags: Any
) -> Photograph:
    """A photograph of radiance (H, W, 3), which it may change; `unseen` (H, W) marks pixels that the file says nothing of."""
    with np.errstate(
        over="ignore"
    ):  # a double beyond the range of a float becomes infinite, and is marked below
        pixels: FloatArray = np.array(rgb, np.float32, order="C", copy=None)
    lowest = np.minimum(np.minimum(pixels[..., 0], pixels[..., 1]), pixels[..., 2])
    finite: BoolArray = (
        np.isfinite(pixels[..., 0]) & np.isfinite(pixels[..., 1]) & np.isfinite(pixels[..., 2])
    )
    if not finite.any():
        raise PhotographError(f"{path.name} holds no numbers, only NaN or infinities. Write it again.")
    step = max(1, min(pixels.shape[:2]) // 1000)
    green = pixels[::step, ::step, 1]
    lit = green[finite[::step, ::step] & (green > 0.0)]
    depth = DEEPEST_NEGATIVE * float(np.median(lit)) if len(lit) else 0.0
    negative = finite & (lowest < -depth)
    bad = ~finite | negative
    pixels[bad] = 0.0
    remarks = []
    for mask, what in ((~finite, "not finite numbers"), (negative, "negative")):
        if count := int(np.count_nonzero(mask)):
            remarks.append(
                f"{path.name}: {count} pixel{'s are' if count > 1 else ' is'} {what} and left out."
            )
    return Photograph(
        path=path,
        pixels=pixels,
        clipped=bad if unseen is None else bad | unseen,
        scene_referred_float=True,
        remarks=tuple(remarks),
        **tags,
    )


def read_exr(path: Path, *, grey: bool = False) -> Photograph:
    """Read R, G, B of an OpenEXR file: half or float, scan lines or tiles, of the one layer or part that has them.

    Raises
    ------
    PhotographError
        If the file is broken, or has no colour, or several layers with colour.
    """
    import OpenEXR

    claimed = check_exr(path)
    try:
        with libraries_silenced():
            file = OpenEXR.File(str(path), separate_channels=True)
        parts = [(file.header(index), file.channels(index)) for index in range(len(file.parts))]
    except (RuntimeError, ValueError, OSError, MemoryError) as error:
        raise PhotographError(broken(path)) from error
    if any(len(found) < len(part.channels) for (_, found), part in zip(parts, claimed, strict=False)):
        raise PhotographError(broken(path))  # the library leaves out a part that it cannot unpack
    header, channels = _part_with_colour(path, parts, grey=grey)
    planes = [np.asarray(channel.pixels) for channel in channels]
    if any(plane.dtype == object or plane.ndim != 2 for plane in planes):
        raise PhotographError(f"{path.name} is a deep picture. Flatten it to R, G and B.")
    if len({plane.shape for plane in planes}) != 1:
        raise PhotographError(f"{path.name} has channels of different sizes. Save R, G and B at full size.")
    rgb = np.empty((*planes[0].shape, 3), np.float32)
    with np.errstate(over="ignore"):
        for index, plane in enumerate(planes):
            rgb[..., index] = plane
    del file, parts, channels, planes
    return _in_display_window(path, header, rgb)


def _part_with_colour(
    path: Path, parts: list[tuple[Mapping[str, Any], Mapping[str, Any]]], *, grey: bool
) -> tuple[Mapping[str, Any], list[Any]]:
    """The part, and its red, green and blue channels: unnamed layers go before named ones."""
    found: dict[str, tuple[Mapping[str, Any], list[Any]]] = {}
    for header, channels in parts:
        part_name = str(header.get("name", "")) if len(parts) > 1 else ""
        for name in channels:
            layer, _, last = name.rpartition(".")
            trio = next((names for names in _RGB_NAMES if names[0] == last), None)
            stem = f"{layer}." if layer else ""
            if trio is not None and all(stem + other in channels for other in trio):
                label = ".".join(word for word in (part_name, layer) if word)
                found.setdefault(label, (header, [channels[stem + other] for other in trio]))
    plain = [label for label in found if "." not in label and label in ("", *_part_names(parts))]
    if len(found) > 1 and len(plain) != 1:
        raise PhotographError(
            f"{path.name} holds several pictures ({', '.join(sorted(found))}). Save the one with the ball alone."
        )
    if found:
        return found[plain[0] if plain else next(iter(found))]
    header, channels = parts[0] if parts else ({}, {})
    if grey and "Y" in channels:
        return header, [channels["Y"]] * 3
    names = ", ".join(sorted(channels)[:8]) or "nothing"
    raise PhotographError(
        f"{path.name} has no colour: its channels are {names}. Save the photograph with red, green and blue channels R, G, B."
    )


def _part_names(parts: list[tuple[Mapping[str, Any], Mapping[str, Any]]]) -> list[str]:
    return [str(header.get("name", "")) for header, _ in parts]


def _in_display_window(path: Path, header: Mapping[str, Any], rgb: npt.NDArray[Any]) -> Photograph:
    """The picture in the frame that the camera saw: some writers store only the part that holds something."""
    (left, top), _ = (np.asarray(corner, int) for corner in header["dataWindow"])
    (origin_x, origin_y), (end_x, end_y) = (np.asarray(corner, int) for corner in header["displayWindow"])
    width, height = end_x - origin_x + 1, end_y - origin_y + 1
    row, column = top - origin_y, left - origin_x
    rows, columns = rgb.shape[:2]
    if (row, column, rows, columns) == (0, 0, height, width):
        return radiance_photograph(path, rgb)
    if not (0 <= row <= row + rows <= height and 0 <= column <= column + columns <= width):
        return radiance_photograph(path, rgb)  # more than the frame: overscan, which shows what it shows
    if width * height > 4 * rows * columns:
        raise PhotographError(
            f"{path.name} stores {columns} x {rows} pixels of a frame of {width} x {height}. Save the whole frame."
        )
    whole = np.zeros((height, width, 3), np.float32)
    whole[row : row + rows, column : column + columns] = rgb
    unseen = np.ones((height, width), bool)
    unseen[row : row + rows, column : column + columns] = False
    return radiance_photograph(path, whole, unseen)

"""The files of a composite.

- `composite.exr`: R, G, B linear in the camera's own colours, in the unit of the photograph; where nothing was done, the plate's
  pixels bit for bit. `plate.exr`: the photograph likewise.
- `composite.png`: the picture. Of a converted photograph in its own encoding, with its own codes where nothing was done.
- `composite_xyz.exr`: X, Y, Z in the unit of the render; `composite_rgb.exr` and `.png`: the same with the ordinary RGB render.
- `difference.exr`, `difference.png`: what the objects changed on the ground; in the picture relative to it, grey for nothing.
- `composite.json`: numbers and remarks.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..figures.display import Picture, exposure_for_white, srgb_encoded, tone_map, write_png
from ..files.atomic import written_whole
from ..files.image_exr import write_rgb
from ..model import FloatArray
from ..render.compare import WHITE_PERCENTILE
from ..spectra.camera import REC709
from ..spectra.colorimetry import adapted_to_d65
from ..spectra.working_space import working_space
from .differential import Composite
from .plate_photo import Plate

_MIDDLE_GREY = 0.18


def write_linear(path: Path, pixels: FloatArray, camera: str, what: str) -> None:
    """Write linear camera RGB; with chromaticities where the camera is Rec.709, since only then R, G, B are colours."""
    header: dict[str, Any] = {"comments": f"{what}; linear, colours of {camera}"}
    if camera == REC709:
        header["chromaticities"] = tuple(float(value) for value in working_space().chromaticities)
    write_rgb(path, pixels, header=header)


def write_difference(directory: Path, plate: Plate, composite: Composite) -> None:
    """Write what was changed on the ground: linear, and as a picture relative to the plate."""
    write_linear(
        directory / "difference.exr",
        composite.difference,
        plate.camera,
        "what the objects changed on the ground",
    )
    relative = np.divide(
        composite.difference, plate.pixels, out=np.zeros_like(plate.pixels), where=plate.pixels > 0
    )
    write_png(
        directory / "difference.png",
        np.asarray(np.rint(255 * _encoded(_MIDDLE_GREY * (1 + relative))), np.uint8),
    )


def display_exposure(plate_xyz: FloatArray) -> float:
    """The exposure that shows a linear plate: its brightest parts, lamps aside, as the screen's white."""
    white = float(np.percentile(plate_xyz[..., 1], WHITE_PERCENTILE))
    return exposure_for_white(white) if white > 0 else 1.0


def picture_of(
    plate: Plate, composite: Composite, xyz: FloatArray, white: FloatArray | None, exposure: float
) -> Picture:
    """The picture (H, W, 3) uint8: a converted photograph's own codes, else a display rendering of XYZ (H, W, 3).

    The latter goes from the white (3,) in XYZ that the camera was balanced for, where it says one, to D65 (CAT16), and from there
    to sRGB with highlights rolled off (`figures.display.tone_map`).
    """
    if plate.converted:
        codes = plate.codes(composite.pixels)
        return np.where(composite.changed[..., None], codes, plate.codes(plate.pixels))
    return tone_map(xyz if white is None else adapted_to_d65(xyz, white), exposure)


def write_numbers(path: Path, numbers: Mapping[str, Any]) -> None:
    """Write composite.json."""
    with written_whole(path) as temporary:
        temporary.write_text(json.dumps(numbers, indent=2) + "\n", encoding="utf-8")


def _encoded(linear: FloatArray) -> FloatArray:
    return srgb_encoded(np.clip(linear, 0, 1))

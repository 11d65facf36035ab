"""The probe's panorama as the background of a render: what its camera would have photographed without the objects."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from ..composite_model import Backplate
from ..errors import FileFormatError, RenderError
from ..files.image_exr import read_channels
from ..files.probe_exr import read_probe
from ..geometry.camera import pixel_rays
from ..geometry.frames import direction_to_equirectangular
from ..geometry.sphere import padded
from ..model import FloatArray, SpectralPanorama
from ..spectra.camera import REC709, camera_sensitivities
from ..spectra.colorimetry import panorama_xyz, xyz_to_rec709
from .plate_photo import Plate

_ROWS_AT_ONCE = 256


def is_probe(path: Path) -> bool:
    """Whether a file is a panorama that the verb `probe` wrote."""
    if not path.is_file() or path.suffix.lower() != ".exr":
        return False
    try:
        _, header = read_channels(path)
    except FileFormatError:
        return False  # whoever reads it as a photograph says what is wrong
    return "spectralProbe" in header


def panorama_plate(path: Path, backplate: Backplate | None) -> Plate:
    """A panorama as a plate, linear Rec.709 in the probe's unit.

    Raises
    ------
    RenderError
        If the render says nothing of its camera.
    """
    if backplate is None:
        raise RenderError(
            f"{path.name} is a panorama, and the render does not say where its camera looks (backplate.json). Render the scene "
            "again, with a perspective camera."
        )
    pixels = seen_by(read_probe(path), backplate)
    return Plate(
        pixels,
        np.zeros(pixels.shape[:2], bool),
        REC709,
        camera_sensitivities(REC709),
        remarks=_softness(path),
    )


def _softness(path: Path) -> tuple[str, ...]:
    return (f"{path.name} is the background: as sharp as a panorama from a mirrored ball is.",)


def seen_by(panorama: SpectralPanorama, backplate: Backplate) -> FloatArray:
    """What a camera sees of a panorama, (H, W, 3) float32 linear Rec.709; negative where out of its gamut."""
    rgb = xyz_to_rec709(panorama_xyz(panorama))
    around = np.ascontiguousarray(padded(rgb, 1, 1))
    width, height = backplate.camera.size_px
    seen = np.empty((height, width, 3), np.float32)
    for start in range(0, height, _ROWS_AT_ONCE):
        rows = np.arange(start, min(start + _ROWS_AT_ONCE, height)) + 0.5
        points = np.stack(np.meshgrid(np.arange(width) + 0.5, rows), -1)
        directions = pixel_rays(backplate.camera, points) @ np.asarray(backplate.rotation).T
        places = direction_to_equirectangular(directions, *rgb.shape[:2])
        columns, lines = np.moveaxis(places.astype(np.float32) + np.float32(0.5), -1, 0)
        seen[start : start + len(rows)] = cv2.remap(
            around, np.ascontiguousarray(columns), np.ascontiguousarray(lines), cv2.INTER_LINEAR
        )
    return seen

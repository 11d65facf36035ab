"""What the verbs of the command line do that need no Blender: calibrate, probe; and images as tristimulus values.

The spectrum of a direction or region and the comparison have modules of their own, `spectrum_command` and `compare_command`.
Each verb is a job: it yields progress, writes its files, and returns the numbers worth telling.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .errors import FileFormatError
from .files.atomic import check_folder
from .files.capture import load_capture
from .files.image_exr import read_channels
from .files.lock import folder_lock
from .files.spectral_channels import is_spectral
from .files.spectral_exr import spectral_image
from .geometry.boards import Board
from .geometry.calibration import calibrate as calibrate_camera
from .geometry.calibration import write_calibration
from .model import FloatArray, Job, part
from .probe import build_probe, write_outputs
from .render.outputs import WHITE_ATTRIBUTE
from .spectra.colorimetry import illuminant, spectra_to_xyz
from .spectra.grid import resampling_matrix
from .spectra.white import parse_white
from .spectra.working_space import space_of_header

type Numbers = dict[str, Any]


def probe(capture_path: Path, directory: Path, width: int | None) -> Job[Numbers]:
    """Photographs to probe.exr, spectral.exr, layers.exr, world.exr, report.json and pictures in a folder."""
    capture = load_capture(capture_path)
    with folder_lock(directory):
        building = build_probe(capture, width)
        result = yield from part(building, 0.0, 0.7)
        yield from part(write_outputs(result, directory), 0.7, 1.0)
    return {**result.report, "written": str(directory)}


def calibrate(photos: Sequence[Path], output: Path, board: Board) -> Job[Numbers]:
    """Photographs of a board to camera.json: focal length, principal point and distortion, with their errors."""
    if output.is_dir():
        raise FileFormatError(f"{output} is a folder. Give the name of a file to write, such as camera.json.")
    if any(output.resolve() == photo.resolve() for photo in photos):
        raise FileFormatError(f"{output.name} is one of the photographs. Give another file to write.")
    check_folder(output.parent)
    calibration = yield from part(calibrate_camera(photos, board), 0.0, 0.99)
    return {**write_calibration(output, calibration), "written": str(output)}


@dataclass(frozen=True)
class TristimulusImage:
    """Tristimulus values (H, W, 3) of an image file, and sentences on what of the file was not used."""

    xyz: FloatArray
    remarks: tuple[str, ...] = ()


def read_xyz(path: Path) -> FloatArray:
    """Tristimulus values (H, W, 3) of an image; see `read_tristimulus`."""
    return read_tristimulus(path).xyz


def read_tristimulus(path: Path) -> TristimulusImage:
    """Tristimulus values of an image: of X, Y, Z, of a spectral image, or of scene-linear R, G, B.

    R, G, B are in the space of the header's chromaticities, Rec.709 without them. Where the header says that a picture was
    adapted from a white, that is undone.

    A spectral image may have any wavelengths that cover 400-700 nm; what lies outside is cut. R, G, B beside a spectrum
    are its preview. Reflectances are taken under D65, a perfect diffuser having Y = 1.

    Raises
    ------
    FileFormatError
        If the file holds none of these.
    SpectralDataError
        If the spectrum does not cover 400-700 nm.
    """
    channels, header = read_channels(path)
    if all(name in channels for name in "XYZ"):
        return TristimulusImage(_three(channels, "XYZ"))
    if any(is_spectral(name) for name in channels):
        image = spectral_image(channels, header, path.name)
        light = (
            illuminant("D65") / spectra_to_xyz(illuminant("D65"))[1]
            if image.quantity == "reflective"
            else 1.0
        )
        onto_grid = resampling_matrix(image.wavelengths_nm, name=path.name)
        to_xyz = spectra_to_xyz(onto_grid * light).astype(np.float32)
        told = (
            (f"{path.name} holds reflectances: they are shown under D65.",)
            if image.quantity == "reflective"
            else ()
        )
        return TristimulusImage(image.spectra @ to_xyz, image.remarks + told)
    if all(name in channels for name in "RGB"):
        xyz = space_of_header(header, path.name).to_xyz(_three(channels, "RGB"))
        white = parse_white(str(header.get(WHITE_ATTRIBUTE, "")))
        if white is not None:  # xyz.exr never is: pictures adapted and not would differ by their whites
            xyz = xyz @ np.linalg.inv(white.adapted(np.eye(3))).astype(np.float32)
        return TristimulusImage(xyz)
    raise FileFormatError(
        f"{path.name} holds neither X, Y, Z nor R, G, B nor a spectrum. Give xyz.exr, image.exr or rgb.exr of a render."
    )


def _three(channels: Mapping[str, Any], names: str) -> FloatArray:
    return np.stack([np.asarray(channels[name], np.float32) for name in names], axis=-1)

"""Everything of a plate that a scene is set up with: the matched camera, the picture to show, the ground's reflectance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from ..composite_model import Backplate
from ..files.probe_exr import read_probe
from ..model import FloatArray, Job, Progress, SpectralPanorama, part
from ..photo.read import read_photograph
from ..spectra.camera import camera_sensitivities
from .ground import GroundReflectance, ground_reflectance, irradiance, response_of_reflectance
from .matching import MatchSettings, PlateMatch, match_plate
from .plate_light import plate_radiance
from .probe_views import read_probe_views

_GROUND_RADII = 10.0
"""Radius of the ground over the ball's where none is given: what a small thing shades and mirrors."""

_IMPOSSIBLE = 1.0
_BRIGHTEST = 0.98


@dataclass(frozen=True)
class PreparedPlate:
    """A plate ready for a scene.

    `match` is the matched photograph, `picture` (H, W, 3) float32 what to show of it, linear, 1 = white, at the size
    rendered; `ground` the reflectance from the plate, or one colour (3,) of linear Rec.709; `ground_radius_m` of the disc.
    `remarks` are all sentences for the user.
    """

    match: PlateMatch
    picture: npt.NDArray[np.float32]
    ground: GroundReflectance | FloatArray
    ground_radius_m: float
    remarks: tuple[str, ...]

    @property
    def ground_mean(self) -> FloatArray:
        """Mean reflectance of the ground (3,), linear Rec.709."""
        return self.ground.mean if isinstance(self.ground, GroundReflectance) else self.ground


def prepare_plate(
    probe: Path,
    plate: Path,
    settings: MatchSettings,
    reflectance: FloatArray | None = None,
    ground_radius_m: float | None = None,
) -> Job[PreparedPlate]:
    """Match a plate to a probe, and measure the ground in it.

    Parameters
    ----------
    probe
        The probe's folder, or its probe.exr.
    plate, settings
        As for `match_plate`.
    reflectance
        (3,) of the ground in linear Rec.709, where it is known; None: estimated from the plate.
    ground_radius_m
        Of the ground; None: ten times the ball's.

    Raises
    ------
    SpectralProbeError
        As `match_plate`; if the probe cannot be read.
    """
    probe = Path(probe)
    panorama = read_probe(probe if probe.suffix.lower() == ".exr" else probe / "probe.exr")
    match = yield from part(match_plate(probe, plate, settings), 0.05, 0.8)
    yield Progress(0.8, "Measuring the ground")
    backplate = match.backplate
    radius_m = ground_radius(ground_radius_m, backplate.ball_radius_m)
    sensitivities = camera_sensitivities(backplate.camera_model or None, backplate.sensitivities)
    remarks = match.remarks
    ground: GroundReflectance | FloatArray
    if reflectance is not None:
        ground = np.asarray(reflectance, float)
    else:
        radiance, valid = plate_radiance(match.photograph, backplate)
        ground = ground_reflectance(radiance, backplate, panorama, sensitivities, radius_m, valid)
        remarks += _ground_remarks(ground)
    picture = _shown(match, panorama, sensitivities)
    return PreparedPlate(match, picture, ground, radius_m, remarks)


def ground_radius(given_m: float | None, ball_radius_m: float) -> float:
    """Radius of the ground in metres: as given, or ten times the ball's."""
    return given_m or _GROUND_RADII * ball_radius_m


def measured_ground(
    probe: Path, backplate: Backplate | None, reflectance: FloatArray | None, radius_m: float
) -> Job[tuple[GroundReflectance | FloatArray, float]]:
    """The ground of a plate that is matched already: its reflectance, as given or from the plate, and its radius.

    Parameters
    ----------
    probe
        The probe's folder.
    backplate
        The matched plate; needed where no reflectance is given.
    reflectance
        (3,) linear Rec.709, or None.
    radius_m
        Of the ground.
    """
    if reflectance is not None or backplate is None:
        return np.full(3, 0.3) if reflectance is None else reflectance, radius_m
    yield Progress(0.0, "Reading the probe")
    panorama = read_probe(Path(probe) / "probe.exr")
    yield Progress(0.3, f"Reading {backplate.photo.name}")
    half_size = read_probe_views(probe)[0].half_size
    radiance, valid = plate_radiance(read_photograph(backplate.photo, half_size=half_size), backplate)
    yield Progress(0.8, "Measuring the ground")
    sensitivities = camera_sensitivities(backplate.camera_model or None, backplate.sensitivities)
    return ground_reflectance(radiance, backplate, panorama, sensitivities, radius_m, valid), radius_m


def _ground_remarks(ground: GroundReflectance) -> tuple[str, ...]:
    most = float(ground.unlimited_mean.max())
    if most <= _IMPOSSIBLE:
        return ()
    told = (
        f"The ground in the plate is so bright that it would reflect {most:.0%} of the light from above: it shines, or the ball "
        "was lit otherwise, or the elevation is not right. Less was taken; a reflectance can be given."
    )
    return (told,)


def _shown(
    match: PlateMatch, panorama: SpectralPanorama, sensitivities: FloatArray
) -> npt.NDArray[np.float32]:
    """The plate as a picture: as it is where it was converted; else white-balanced to the light from above."""
    photograph, size = match.photograph, match.backplate.camera.size_px
    pixels = np.asarray(photograph.pixels, np.float32)
    if size != pixels.shape[1::-1]:
        pixels = np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA), np.float32)
    if photograph.display_referred:
        return pixels
    white = np.ones(3) @ response_of_reflectance(irradiance(panorama), sensitivities)
    balanced = pixels / np.asarray(white / white[1], np.float32)
    level = float(np.quantile(balanced[::4, ::4], _BRIGHTEST))
    return np.asarray(balanced / max(level, 1e-9), np.float32)


def plate_numbers(prepared: PreparedPlate) -> Mapping[str, Any]:
    """What a user is told of a prepared plate."""
    match, backplate = prepared.match, prepared.match.backplate
    alignment = match.alignment
    return {
        "plate": backplate.photo.name,
        "size_px": list(backplate.camera.size_px),
        "focal_px": list(backplate.camera.focal_px),
        "camera_height_m": float(backplate.position_m[2]),
        "camera_distance_m": float(
            np.linalg.norm(backplate.position_m - np.asarray(backplate.ball_centre_m, float))
        ),
        "shift_px": None if alignment is None else list(alignment.shift_px),
        "shift_error_px": None if alignment is None else alignment.error_px,
        "details": None if alignment is None else alignment.used,
        "details_rms_px": None if alignment is None or not alignment.used else alignment.rms_px,
        "exposure": backplate.exposure,
        "gain": None if match.gain is None else [float(value) for value in match.gain],
        "ground_reflectance": [float(value) for value in prepared.ground_mean],
        "ground_radius_m": prepared.ground_radius_m,
        "remarks": list(prepared.remarks),
    }

"""The data of augmented reality: a photograph as the background of a render, and which pixels show which object.

Axis letters as in `model`: H, W image; K knots of a response curve.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .model import Camera, FloatArray

BACKPLATE_NAME = "backplate.json"
"""In a render's folder: the backplate of the scene (`Backplate`), where it has one."""

OBJECTS_NAME = "objects.exr"
"""In a render's folder: which pixels show what (`ObjectCoverage`)."""

WITHOUT_NAME = "without"
"""In a render's folder: the folder of the same render without the objects, where the scene has shadow catchers."""


@dataclass(frozen=True)
class Backplate:
    """A photograph as the background: the camera that took it, where it stood, and what its pixels stand for.

    World coordinates are Blender's, in metres. Lengths in pixels are those of the size the plate is rendered at.

    Parameters
    ----------
    camera
        The whole picture's pinhole camera with its distortion, at the size rendered.
    rotation
        (3, 3) from camera to world coordinates, ``world = camera @ rotation.T``.
    position_m
        (3,) the centre of projection in the world.
    photo, photo_size_px
        The photograph and its own size (width, height): `camera.size_px` or a multiple of it.
    frame_px
        (left, top, width, height) of what Blender renders, in pixels of the undistorted picture: the picture itself
        where there is no distortion, else with the margin that the distortion reaches into.
    ball_centre_m, ball_radius_m
        The mirrored ball in the world; None and 0 where there was none.
    camera_model, sensitivities
        Name and file of the camera's spectral sensitivities, as in a capture file.
    response_log_gain
        (3, K) response of a converted picture (`photo.response.ResponseCurve.log_gain`); None for linear pictures.
    exposure
        Relative exposure of the photograph (`model.Exposure.relative`): linear pixels over it are radiance in the unit of
        the probe. 1 for EXR and HDR.
    gain
        (3,) what the photograph's channels are brighter by than those of the photographs of the ball, apart from exposure.
    """

    camera: Camera
    rotation: FloatArray
    position_m: FloatArray
    photo: Path
    photo_size_px: tuple[int, int]
    frame_px: tuple[float, float, int, int]
    ball_centre_m: FloatArray | None = None
    ball_radius_m: float = 0.0
    camera_model: str = "Rec.709"
    sensitivities: Path | None = None
    response_log_gain: FloatArray | None = None
    exposure: float = 1.0
    gain: FloatArray = field(default_factory=lambda: np.ones(3))


@dataclass(frozen=True)
class ObjectCoverage:
    """How much of each pixel shows what; as premultiplied renders have it, filtered by the render's own pixel filter.

    Parameters
    ----------
    objects
        (H, W) float32 in 0..1 for each object by name, virtual ones only.
    coverage
        (H, W) all virtual objects together.
    ground
        (H, W) the shadow catchers, which stand for real surfaces.
    """

    objects: Mapping[str, FloatArray]
    coverage: FloatArray
    ground: FloatArray

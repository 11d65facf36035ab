"""The sample's plate, a photograph of the gym without the ball: its camera, its tone curve and its brightness."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from .composite.ground import ground_distance
from .composite.plate_light import plate_radiance
from .composite_model import Backplate
from .errors import CaptureError
from .geometry.camera import pixel_rays
from .geometry.frames import camera_to_world, direction_to_equirectangular
from .model import Camera, FloatArray, SpectralPanorama
from .photo.read import read_photograph, srgb_to_linear
from .photo.response import KNOTS
from .sample import GYM, gym_truth
from .spectra.colorimetry import panorama_xyz, xyz_to_rec709

_SIZE_PX = (720, 480)
_FOCAL_PX = 22.0 / 36.0 * 720.0
_SHIFT_PX = 0.06 * 720.0
_AT_M = (-5.6, -4.3, 1.7)
_BEARING_DEG = 52.0
"""The camera of the plate, as `sample_scenes/gym/builder/rendering.py` sets it; the origin is the floor below the ball."""

_FLOOR_M = (1.0, 3.5)
"""Distances from below the ball between which floor is seen both by the ball's photographs and by the plate."""


def gym_plate(panorama: SpectralPanorama) -> Backplate:
    """The plate as a backplate; its channels' gains are found by the floor, which both the plate and the probe show.

    Parameters
    ----------
    panorama
        What `probe` made of the sample's photographs.

    Raises
    ------
    CaptureError
        If the plate is missing.
    """
    path = GYM / "plate.jpg"
    if not path.is_file():
        raise CaptureError(f"The plate is not in {GYM}. Get a whole copy of the project.")
    width, height = _SIZE_PX
    truth = gym_truth()
    ungained = Backplate(
        camera=Camera((_FOCAL_PX,) * 2, (width / 2, height / 2 + _SHIFT_PX), _SIZE_PX, source="the sample"),
        rotation=camera_to_world(_BEARING_DEG),
        position_m=np.array(_AT_M),
        photo=path,
        photo_size_px=_SIZE_PX,
        frame_px=(0.0, 0.0, width, height),
        ball_centre_m=np.array(truth["ball_at_m"]),
        ball_radius_m=0.05,
        response_log_gain=np.tile(tone_log_gain(), (3, 1)),
    )
    return replace(ungained, gain=_floor_gain(ungained, panorama))


def tone_log_gain() -> FloatArray:
    """(K,) natural logarithm of light over sRGB-decoded code at `KNOTS`: the builder's tone curve undone.

    The builder shows light l as l (1 + l / 16) / (1 + 0.35 l), sRGB-encoded.

    Examples
    --------
    >>> light = srgb_to_linear(KNOTS) * np.exp(tone_log_gain())
    >>> np.allclose(light * (1 + light / 16) / (1 + 0.35 * light), srgb_to_linear(KNOTS))
    True
    """
    shown = np.asarray(srgb_to_linear(KNOTS), float)
    half = 1.0 - 0.35 * shown
    # The positive root of l^2 / 16 + half l - shown = 0, in the form that is exact near black.
    over = 2.0 / (half + np.sqrt(half**2 + shown / 4.0))
    return np.log(over)


def _floor_gain(plate: Backplate, panorama: SpectralPanorama) -> FloatArray:
    """(3,) plate over probe in linear Rec.709: medians over the floor round the ball, which is matt enough for that."""
    pixels, unclipped = plate_radiance(read_photograph(plate.photo), plate)
    away_m = ground_distance(plate)
    floor = unclipped & (away_m > _FLOOR_M[0]) & (away_m < _FLOOR_M[1])
    width, height = plate.camera.size_px
    places = np.stack(np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5), axis=-1)[floor]
    rays = pixel_rays(plate.camera, places) @ plate.rotation.T
    points_m = plate.position_m - rays * (plate.position_m[2] / rays[:, 2:])
    columns, rows = _texels(points_m - np.array(gym_truth()["ball_at_m"]), panorama)
    seen = xyz_to_rec709(panorama_xyz(panorama))[rows, columns]
    shown = pixels[floor]
    known = panorama.valid[rows, columns] & (np.minimum(seen, shown).min(-1) > 0)
    return np.asarray(np.exp(np.median(np.log(shown[known] / seen[known]), axis=0)))


def _texels(directions: FloatArray, panorama: SpectralPanorama) -> npt.NDArray[np.int64]:
    """(2, N) columns and rows of the panorama's texels in directions (N, 3) of any length."""
    height, width = panorama.valid.shape
    unit = directions / np.linalg.norm(directions, axis=-1, keepdims=True)
    places = np.floor(direction_to_equirectangular(unit, height, width)).astype(np.int64)
    return np.minimum(places, (width - 1, height - 1)).T

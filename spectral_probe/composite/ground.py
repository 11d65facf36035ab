"""The ground that an object stands on: how much light reaches it, and what it reflects, from the plate."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from ..composite_model import Backplate
from ..geometry.camera import pixel_rays
from ..geometry.frames import panorama_directions, panorama_solid_angles
from ..model import BoolArray, FloatArray, SpectralPanorama
from ..spectra.grid import STEP_NM, resample
from ..spectra.uplift import reflectance_basis
from .plate_geometry import frame_camera, undistorted

UPWARD: FloatArray = np.array([0.0, 0.0, 1.0])
UPWARD.flags.writeable = False

MOST_REFLECTED = 0.9
"""No matt surface reflects more: what seems to shines, or mirrors a window."""

_HIGHLIGHT = 4.0
"""Places this many times as bright as the ground's median are lamps, windows or mirrored ones, and no part of the mean."""


@dataclass(frozen=True)
class GroundReflectance:
    """What the ground reflects, as linear Rec.709 (`spectra.uplift` makes spectra of it).

    Parameters
    ----------
    pixels
        (h, w, 3) float32 for every pixel of the frame that is rendered (`Backplate.frame_px`), as if each were ground.
    seen
        (h, w) where the plate says so; elsewhere `pixels` holds the mean.
    mean
        (3,) of the ground within the radius asked for.
    unlimited_mean
        (3,) what the mean would be without the limit of `MOST_REFLECTED`: over one, the light or the ground is not where it was
        said to be.
    """

    pixels: npt.NDArray[np.float32]
    seen: BoolArray
    mean: FloatArray
    unlimited_mean: FloatArray


def irradiance(panorama: SpectralPanorama, normal: FloatArray = UPWARD) -> FloatArray:
    """Spectral irradiance of a surface in a panorama's light: the integral of radiance times the cosine over its half space.

    Parameters
    ----------
    panorama
        The light from every direction.
    normal
        (3,) direction that the surface faces, of any length.

    Returns
    -------
    ndarray
        (61,) on `grid.WAVELENGTHS_NM`, the panorama's unit times sr.

    Examples
    --------
    Light of one all around gives pi:

    >>> flat = SpectralPanorama(
    ...     np.ones((64, 128, 1), np.float32), np.ones((1, 1, 61)), np.zeros((64, 128), np.uint8), np.arange(400.0, 701, 5),
    ...     np.ones((64, 128), bool), np.ones((64, 128)),
    ... )
    >>> [round(float(irradiance(flat, np.array(n))[0]), 2) for n in ((0.0, 0.0, 1.0), (3.0, 1.0, -2.0))]
    [3.14, 3.14]
    """
    height, width = panorama.valid.shape
    facing = np.asarray(normal, float) / np.linalg.norm(normal)
    cosine = np.maximum(panorama_directions(height, width) @ facing, 0.0)
    share = (cosine * panorama_solid_angles(height, width)).astype(np.float32)
    received = np.zeros(len(panorama.wavelengths_nm))
    for index, basis in enumerate(panorama.bases):
        uses = panorama.basis_index == index
        received += (share[uses] @ panorama.weights[uses]).astype(float) @ basis
    return resample(panorama.wavelengths_nm, received, name="the panorama")


def response_of_reflectance(light: FloatArray, sensitivities: FloatArray) -> FloatArray:
    """(3, 3) camera RGB of a matt surface of Rec.709 reflectance rgb under an irradiance: ``camera = rgb @ matrix``.

    Exact for the spectra that renders give such a reflectance, which are sums of three primaries.

    Parameters
    ----------
    light
        (61,) spectral irradiance.
    sensitivities
        (61, 3) of the camera.

    Examples
    --------
    >>> from ..spectra.camera import camera_sensitivities
    >>> from ..spectra.colorimetry import illuminant
    >>> matrix = response_of_reflectance(illuminant("D65"), camera_sensitivities("Rec.709"))
    >>> (np.array([0.2, 0.5, 0.3]) @ matrix / (np.ones(3) @ matrix)).round(2).tolist()  # white under D65 is white
    [0.2, 0.5, 0.3]
    """
    return reflectance_basis().T @ (sensitivities * light[:, None] * (STEP_NM / np.pi))


def ground_reflectance(
    plate: FloatArray,
    backplate: Backplate,
    panorama: SpectralPanorama,
    sensitivities: FloatArray,
    radius_m: float,
    valid: BoolArray | None = None,
) -> GroundReflectance:
    """Reflectance of the ground from the plate: rho = pi P / E, with the irradiance from above that the probe measured.

    The probe's light is taken to be the ground's too; with the plate's own light on it the ground then looks as in the plate.

    Parameters
    ----------
    plate
        (H, W, 3) what the plate shows, in the probe's unit (`plate_light.plate_radiance`).
    backplate
        The plate's camera; the ground is z = 0.
    panorama
        The probe.
    sensitivities
        (61, 3) of the plate's camera.
    radius_m
        Of the ground round the world's origin that the mean is taken over.
    valid
        (H, W) where the plate is not clipped.
    """
    matrix = np.linalg.inv(response_of_reflectance(irradiance(panorama), sensitivities))
    own = np.ones(plate.shape[:2], bool) if valid is None else valid
    framed = undistorted(plate, backplate)
    inside = undistorted(np.ones(plate.shape[:2], np.float32), backplate) > 0.999
    unclipped = undistorted(own.astype(np.float32), backplate) > 0.999
    unlimited = np.maximum(framed @ matrix.astype(np.float32), 0.0)
    close = inside & unclipped & (ground_distance(backplate) < radius_m)
    unlimited_mean = _mean(unlimited[close]) if close.any() else _mean(unlimited[inside])
    limited = limited_reflectance(unlimited)
    mean = limited_reflectance(unlimited_mean)
    limited[~inside] = mean
    return GroundReflectance(np.asarray(limited, np.float32), inside, mean, unlimited_mean)


def limited_reflectance(rgb: FloatArray) -> FloatArray:
    """Reflectances (..., 3) brought below `MOST_REFLECTED` with their colours kept.

    Examples
    --------
    >>> limited_reflectance(np.array([[0.9, 1.8, 0.0], [0.1, 0.2, 0.3]])).tolist()
    [[0.45, 0.9, 0.0], [0.1, 0.2, 0.3]]
    """
    largest = np.max(rgb, axis=-1, keepdims=True)
    return np.asarray(rgb * np.minimum(1.0, MOST_REFLECTED / np.maximum(largest, 1e-9)))


def ground_distance(backplate: Backplate) -> FloatArray:
    """Distance in metres from the world's origin of the ground that each pixel of the frame shows (h, w); infinite elsewhere."""
    frame = frame_camera(backplate)
    width, height = frame.size_px
    points = np.stack(np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5), axis=-1)
    rays = pixel_rays(frame, points) @ backplate.rotation.T
    falling = rays[..., 2] < -1e-9
    reach = -backplate.position_m[2] / np.where(falling, rays[..., 2], -1.0)
    place = backplate.position_m[:2] + reach[..., None] * rays[..., :2]
    return np.where(falling & (reach > 0), np.hypot(place[..., 0], place[..., 1]), np.inf)


def faded(ground: GroundReflectance, border_px: int) -> npt.NDArray[np.float32]:
    """The pixels with an alpha channel (h, w, 4) that fades to 0 at the picture's border, where the mean takes over."""
    inside = cv2.copyMakeBorder(ground.seen.astype(np.uint8), 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0)
    away = np.asarray(cv2.distanceTransform(inside, cv2.DIST_L2, 5), np.float32)[1:-1, 1:-1]
    alpha = np.clip((away - 1.0) / max(border_px, 1), 0.0, 1.0)
    return np.dstack([ground.pixels, alpha]).astype(np.float32)


def _mean(reflectances: FloatArray) -> FloatArray:
    """The mean (3,) without highlights and what is as good as black (objects' shadows)."""
    if not len(reflectances):
        return np.full(3, 0.2)
    level = reflectances.mean(-1)
    middle = float(np.median(level))
    kept = (level < _HIGHLIGHT * middle) & (level > middle / _HIGHLIGHT)
    return np.asarray(reflectances[kept].mean(0) if kept.any() else reflectances.mean(0), float)

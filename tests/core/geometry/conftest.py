"""A mirrored ball in a known surrounding, photographed by exact reflection: what registration and stitching are tested on."""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
import pytest

from spectral_probe.geometry.ball import reflect
from spectral_probe.geometry.camera import pixel_rays
from spectral_probe.geometry.frames import camera_to_world, direction_to_equirectangular
from spectral_probe.geometry.registration import PlacedView
from spectral_probe.geometry.sphere import blurred, padded, resized
from spectral_probe.geometry.stitch import Blend, doubts, view_score
from spectral_probe.model import BallFit, Camera, RadianceImage

SIZE_PX = 320
CAMERA = Camera((1600.0, 1600.0), (162.0, 158.0), (SIZE_PX, SIZE_PX))
CENTRE = np.array([0.002, -0.001, 0.6])
BALL = BallFit(CENTRE, 0.05, float(np.arcsin(0.05 / np.linalg.norm(CENTRE))), 0.0)


def detailed_surroundings(seed: int) -> np.ndarray:
    """Radiance from every direction, (256, 512, 3): shading, detail down to two degrees, a few lamps 40 times as bright."""
    rng = np.random.default_rng(seed)
    noise = rng.standard_normal((256, 512, 3)).astype(np.float32)
    detail = sum(blurred(noise, width) * width * 40 for width in np.radians([2.0, 5.0, 20.0]))
    lamps = blurred((rng.random((256, 512)) > 0.9998).astype(np.float32), np.radians(2.0))[..., None]
    return np.asarray(np.exp(0.35 * detail) + 40 * lamps / max(float(lamps.max()), 1e-6), np.float32)


def look_up(panorama: np.ndarray, directions: np.ndarray) -> np.ndarray:
    points = direction_to_equirectangular(directions, *panorama.shape[:2]).astype(np.float32) + 0.5
    return cv2.remap(padded(panorama, 1, 1), points, None, cv2.INTER_LINEAR)


@dataclass(frozen=True)
class Surroundings:
    """Radiance by direction, seen from the ball's centre at infinity or on the walls of a sphere `distance_m` away."""

    panorama: np.ndarray
    distance_m: float = np.inf

    def photograph(
        self, rotation: np.ndarray, change: Callable[[np.ndarray, np.ndarray], np.ndarray] | None = None
    ) -> RadianceImage:
        """The ball's image under a camera-to-world rotation; `change(directions, radiance)` alters what this view sees."""
        columns, rows = np.meshgrid(np.arange(SIZE_PX) + 0.5, np.arange(SIZE_PX) + 0.5)
        mirrored = reflect(BALL, pixel_rays(CAMERA, np.stack([columns, rows], axis=-1)))
        directions = mirrored.directions @ rotation.T
        if np.isfinite(self.distance_m):
            points = (mirrored.points_m - CENTRE) @ rotation.T
            along = (points * directions).sum(-1, keepdims=True)
            reach = np.sqrt(along**2 - (points**2).sum(-1, keepdims=True) + self.distance_m**2) - along
            directions = (points + reach * directions) / self.distance_m
        radiance = look_up(self.panorama, directions)
        if change is not None:
            radiance = change(directions, radiance)
        radiance = np.where(mirrored.hit[..., None], radiance, 0.0).astype(np.float32)
        return RadianceImage(radiance, np.full_like(radiance, 1e-4), np.ones((SIZE_PX, SIZE_PX), bool))

    def view(self, angles, error=(0.0, 0.0, 0.0), refine=True, change=None) -> PlacedView:
        """A view from (azimuth, elevation, roll) in degrees, whose stated angles are wrong by `error`."""
        stated = camera_to_world(*np.add(angles, error))
        return PlacedView(self.photograph(camera_to_world(*angles), change), CAMERA, BALL, stated, refine)


@pytest.fixture(scope="session")
def view_shares():
    """A function of views and a composition: the share (V, H, W) that `Blend` gives each view in every direction."""

    def shares(views, composition="blend"):
        height, width = views[0].seen.shape
        blend = Blend(height, width, len(views))
        for number, (view, doubt) in enumerate(zip(views, doubts(views), strict=True)):
            alone = np.zeros((height, width, len(views)), np.float32)
            alone[..., number] = 1.0
            blend.add(slice(0, height), alone, view_score(view, resized(doubt, width), 1.0, composition))
        return np.moveaxis(blend.mean(), -1, 0)

    return shares


@pytest.fixture(scope="session")
def surroundings():
    """Surroundings by seed and distance, made once."""
    made = {}

    def get(seed: int = 3, distance_m: float = np.inf) -> Surroundings:
        if seed not in made:
            made[seed] = detailed_surroundings(seed)
        return Surroundings(made[seed], distance_m)

    return get

"""A simulated room with lamps of known spectra, photographed in a mirrored ball by exact reflection, with or without a filter."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck
from hypothesis import settings as hypothesis_settings

from spectral_probe.files.image_exr import write_rgb
from spectral_probe.geometry.ball import reflect
from spectral_probe.geometry.camera import pixel_rays
from spectral_probe.geometry.frames import bearing_to_direction, camera_to_world
from spectral_probe.model import BallFit, Camera, CameraSettings
from spectral_probe.spectra.camera import camera_sensitivities
from spectral_probe.spectra.colorimetry import illuminant
from spectral_probe.spectra.grid import STEP_NM, WAVELENGTHS_NM
from spectral_probe.spectra.library import surface_reflectances
from spectral_probe.spectra.metals import ball_reflectance

hypothesis_settings.register_profile(
    "the same each time",
    max_examples=int(os.environ.get("SPECTRAL_PROBE_EXAMPLES", "15")),
    derandomize=True,
    deadline=None,
    database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
hypothesis_settings.load_profile("the same each time")

SIZE_PX = 200
RADIUS_M, DISTANCE_M, FOCAL_PX = 0.05, 0.8, 1350.0
BALL = BallFit(np.array([0.0, 0.0, DISTANCE_M]), RADIUS_M, float(np.arcsin(RADIUS_M / DISTANCE_M)), 0.0)
COSINES = np.linspace(0.0, 1.0, 65)


def unit_power(spectrum):
    return spectrum / spectrum.mean()


@dataclass(frozen=True)
class SimulatedRoom:
    """Lamps as discs (bearing, elevation, radius in degrees, level, spectrum) in a room whose six walls they light.

    `card` is a spectrum and a rectangle in pixels beside the ball, `card_in_ball` a direction in which the ball mirrors it.
    """

    camera: np.ndarray = field(default_factory=lambda: camera_sensitivities("Nikon 5100 (NPL)"))
    lamps: Mapping[str, tuple] = field(default_factory=dict)
    reflectance: object = lambda cos: ball_reflectance("SUS304", cos)
    card: np.ndarray | None = None
    card_px: tuple[int, int, int, int] = (4, 4, 24, 24)
    card_at: tuple[float, float] = (150.0, 0.0)
    card_radius_deg: float = 9.0

    def spectra(self) -> np.ndarray:
        """Of everything, (M, 61): the lamps, six walls, the card."""
        lamps = np.stack([level * unit_power(spectrum) for *_, level, spectrum in self.lamps.values()])
        room = sum(level * unit_power(spectrum) for *_, level, spectrum in self.lamps.values())
        walls = 0.02 * room * surface_reflectances()[[0, 1, 2, 7, 13, 22]]
        card = np.zeros(61) if self.card is None else self.card
        return np.concatenate([lamps, walls, card[None]])

    def seen(self, directions: np.ndarray) -> np.ndarray:
        """Which of `spectra` is seen in directions (..., 3)."""
        axis = np.abs(directions).argmax(-1)
        positive = np.take_along_axis(directions, axis[..., None], -1)[..., 0] > 0
        which = len(self.lamps) + 2 * axis + positive
        if self.card is not None:
            near = directions @ bearing_to_direction(*self.card_at) > np.cos(np.radians(self.card_radius_deg))
            which = np.where(near, len(self.lamps) + 6, which)
        for number, (bearing, elevation, radius_deg, *_) in enumerate(self.lamps.values()):
            near = directions @ bearing_to_direction(bearing, elevation) > np.cos(np.radians(radius_deg))
            which = np.where(near, number, which)
        return which

    def photograph(self, azimuth_deg=0.0, transmittance=None, noise=0.002, seed=0, gains=(1.0, 1.0, 1.0)):
        """Linear camera RGB (H, W, 3): the ball before the room, four samples a pixel."""
        camera = Camera((FOCAL_PX,) * 2, (SIZE_PX / 2,) * 2, (SIZE_PX,) * 2)
        curves = self.camera * STEP_NM * gains
        if transmittance is not None:
            curves = curves * transmittance[:, None]
        spectra, rotation = self.spectra(), camera_to_world(azimuth_deg)
        direct = spectra @ curves
        mirrored = np.einsum("ml,nl,lc->mnc", spectra, self.reflectance(COSINES), curves)
        total = np.zeros((SIZE_PX, SIZE_PX, 3))
        for sub in np.ndindex(2, 2):
            y, x = np.mgrid[:SIZE_PX, :SIZE_PX] + (np.array(sub) * 0.5 + 0.25)[:, None, None]
            rays = pixel_rays(camera, np.stack([x, y], axis=-1))
            reflection = reflect(BALL, rays)
            place = reflection.cos_incidence * (len(COSINES) - 1)
            below = np.minimum(place.astype(int), len(COSINES) - 2)
            share = (place - below)[..., None]
            which = self.seen(reflection.directions @ rotation.T)
            in_ball = (1 - share) * mirrored[which, below] + share * mirrored[which, below + 1]
            total += np.where(reflection.hit[..., None], in_ball, direct[self.seen(rays @ rotation.T)])
        total /= 4
        if self.card is not None:
            left, top, right, bottom = self.card_px
            total[top:bottom, left:right] = direct[-1]
        grain = np.random.default_rng(seed).normal(0.0, noise, total.shape)
        return (total * (1 + grain)).astype(np.float32)

    def write(self, path: Path, **how) -> Path:
        write_rgb(path, self.photograph(**how))
        return path

    @property
    def settings(self) -> CameraSettings:
        return CameraSettings(model="Nikon 5100 (NPL)", focal_px=(FOCAL_PX,) * 2)

    @property
    def outline(self) -> tuple[float, float, float]:
        return (SIZE_PX / 2, SIZE_PX / 2, FOCAL_PX * float(np.tan(BALL.cone_angle_rad)))


@pytest.fixture(scope="session")
def simulated_room():
    """A function that makes a room from lamps."""
    return SimulatedRoom


@pytest.fixture(scope="session")
def three_lamps(simulated_room):
    """A filament lamp, a triband tube and a window."""
    return simulated_room(
        lamps={
            "A": (-70.0, 25.0, 8.0, 30.0, illuminant("A")),
            "FL11": (60.0, 35.0, 10.0, 40.0, illuminant("FL11")),
            "D65": (110.0, 0.0, 12.0, 25.0, illuminant("D65")),
        }
    )


@pytest.fixture(scope="session")
def green_filter():
    """Like a Wratten 58: a band of 55 nm round 530 nm, 0.55 at most, with a weak leak beyond 680 nm."""
    band = 0.55 * np.exp(-0.5 * np.abs((WAVELENGTHS_NM - 530.0) / 27.0) ** 2.6)
    leak = 0.05 / (1.0 + np.exp(-(WAVELENGTHS_NM - 692.0) / 4.0))
    return band + leak


@pytest.fixture
def frame_record():
    """What a frame of eight samples was begun with, with some of it changed."""
    from spectral_probe.render.frame_record import FrameRecord
    from spectral_probe.render.outputs import OutputSettings

    def make(**changes):
        return FrameRecord(
            **{
                "scene": "Scene", "frame": 1, "blend": "../scene.blend", "blender": "5.2.0", "samples": 8,
                "to_rec709": np.eye(3), "denoise": False, "catchers": (), "virtual": ("Ball",), "without": False,
                "rgb_twin": True, "twin_level": 0.5, "light_residual": 0.0, "mean_light": np.ones(61),
                "backplates": (None, None), "frame_px": (4, 4), "outputs": OutputSettings(), "warnings": (),
                **changes,
            }
        )  # fmt: skip

    return make

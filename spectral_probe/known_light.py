"""Calibration of a capture by its known light: what camera and ball are, from how they show it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .errors import CaptureError
from .files.spectrum_csv import read_spectrum_csv
from .geometry.frames import bearing_to_direction
from .geometry.registration import PlacedView, RegisteredView
from .light_settings import CalibrationSettings, Rectangle
from .model import Capture, FloatArray
from .patch import Patch, lamp_patch, mirrored_patch
from .spectra.calibration import BallCorrection, ball_correction, channel_gains
from .spectra.curves import LIGHT, REFLECTANCE
from .spectra.library import lamp_spectrum
from .spectra.metals import ball_reflectance
from .view import MeasuredView

_STRANGE_GAIN = 4.0
"""Published curves of one camera differ by less than this from what a known light says, even normalised by channel."""

_LEAST_REFLECTANCE = 1e-3
"""Black velvet returns more than this."""

_OWN_REFLECTION = np.cos(np.radians(16.0))
"""A view does not see the directions round its own camera: it sees the camera."""


@dataclass(frozen=True)
class Calibration:
    """What a known light says of camera and ball.

    `gains` (3,) is what responses are to be multiplied by, or sensitivities divided; with `absolute` recovered spectra are then
    in W m^-2 sr^-1 nm^-1. `ball` corrects the modelled reflectance of the ball, None where nothing was measured of it. `patch` is
    where the light was seen, in view `view` (from 0). `warnings` are sentences for the user.
    """

    gains: FloatArray
    absolute: bool
    patch: Patch
    view: int
    ball: BallCorrection | None = None
    warnings: tuple[str, ...] = ()

    def described(self) -> dict[str, Any]:
        """For the report."""
        return {
            "gains": [float(gain) for gain in self.gains],
            "absolute": self.absolute,
            "view": self.view + 1,
            "pixels": self.patch.pixels,
            "relative_error": [float(error) for error in self.patch.error / self.patch.responses],
            "spread": self.patch.spread,
            "ball_factors": None if self.ball is None else list(self.ball.channel_factors),
        }


def check_calibration(capture: Capture) -> None:
    """Refuse a calibration that contradicts itself or its capture, or whose files cannot be used.

    Raises
    ------
    SpectralProbeError
    """
    settings = capture.calibration
    if settings is None:
        return
    settings.check()
    if settings.patch_px is not None:
        if not 1 <= settings.view <= len(capture.views):
            raise CaptureError(
                f"[calibration] names view {settings.view}, but there are {len(capture.views)}. Correct view."
            )
        if capture.views[settings.view - 1].filter is not None:
            raise CaptureError(
                f"[calibration]: view {settings.view} was taken through a filter. Name a view without one."
            )
    known_spectrum(settings)


def known_spectrum(settings: CalibrationSettings) -> FloatArray:
    """Spectral radiance (61,) of the light a calibration knows, as the lamp or card sends it to the camera.

    Raises
    ------
    SpectralDataError, CaptureError
        If a file cannot be used, the illuminant is unknown, or values are negative or reflect more than all.
    """
    if settings.spectrum is not None:
        light = read_spectrum_csv(settings.spectrum, quantity=LIGHT)[0]
    else:
        light = np.array(lamp_spectrum(str(settings.illuminant)))
    if isinstance(settings.reflectance, Path):
        reflectance = read_spectrum_csv(settings.reflectance, quantity=REFLECTANCE)[0]
        if reflectance.max() < _LEAST_REFLECTANCE:
            raise CaptureError(
                f"[calibration]: the card of {settings.reflectance.name} is black: it shows no light. Use a grey one."
            )
        return np.asarray(light * reflectance)
    return np.asarray(light * settings.reflectance)


def patch_of(settings: CalibrationSettings | None, view: int) -> Rectangle | None:
    """The patch to measure in a view (counted from 0) for a calibration, None where there is none."""
    return settings.patch_px if settings is not None and settings.view == view + 1 else None


def calibrated(
    capture: Capture,
    measured: Sequence[MeasuredView],
    placed: Sequence[PlacedView],
    registered: Sequence[RegisteredView],
    sensitivities: FloatArray,
) -> Calibration | None:
    """What the known light of a capture says; None where it knows none.

    Parameters
    ----------
    capture
        With its `calibration`.
    measured, placed, registered
        Its views. Responses are taken as registration matches them to the first view's.
    sensitivities
        (61, 3) of the camera, as published.

    Raises
    ------
    SpectralProbeError
        If the light is not seen where it should be, clipped or dark.
    """
    settings = capture.calibration
    if settings is None:
        return None
    light = known_spectrum(settings)
    if settings.patch_px is None:
        number, patch = _lamp(settings, measured, placed, registered)
        reflectance = ball_reflectance(capture.ball.material, np.array(patch.cos_incidence))
        return _calibration(settings, number, patch, registered, light * reflectance, sensitivities, None)
    number = settings.view - 1
    view = measured[number]
    if view.patch is None:
        raise ValueError("the view was measured without its patch")
    ball = None
    if settings.ball_patch_px is not None:
        mirrored = mirrored_patch(view.image, view.camera, view.ball, view.corner_px, settings.ball_patch_px)
        modelled = ball_reflectance(capture.ball.material, np.array(mirrored.cos_incidence))
        ball = ball_correction(mirrored.responses, view.patch.responses, light, sensitivities, modelled)
    return _calibration(settings, number, view.patch, registered, light, sensitivities, ball)


def _lamp(
    settings: CalibrationSettings,
    measured: Sequence[MeasuredView],
    placed: Sequence[PlacedView],
    registered: Sequence[RegisteredView],
) -> tuple[int, Patch]:
    """The view without a filter that sees the lamp most squarely, away from itself, and the lamp in it."""
    direction = bearing_to_direction(*(settings.light_at or (0.0, 0.0)))
    facing = {
        number: float(direction @ (one.rotation @ (-view.ball.centre_m / view.ball.distance_m)))
        for number, (view, one) in enumerate(zip(placed, registered, strict=True))
        if measured[number].settings.filter is None
    }
    best = max(facing, key=lambda number: facing[number] - 3.0 * (facing[number] > _OWN_REFLECTION))
    view = placed[best]
    return best, lamp_patch(view.image, view.camera, view.ball, registered[best].rotation.T @ direction)


def _calibration(
    settings: CalibrationSettings,
    view: int,
    patch: Patch,
    registered: Sequence[RegisteredView],
    light: FloatArray,
    sensitivities: FloatArray,
    ball: BallCorrection | None,
) -> Calibration:
    """Gains and warnings; `light` is as it reaches the camera."""
    seen = patch.responses * np.asarray(registered[view].gain)
    gains = channel_gains(seen, light, sensitivities, absolute=settings.absolute)
    return Calibration(gains, settings.absolute, patch, view, ball, tuple(_warnings(patch, gains, ball)))


def _warnings(patch: Patch, gains: FloatArray, ball: BallCorrection | None) -> list[str]:
    warnings = []
    if patch.uneven:
        warnings.append(
            f"[calibration]: the patch is uneven ({patch.spread:.0%}): part of it may not be the known light. Check its place."
        )
    between = gains / gains[1]
    if max(between.max(), 1 / between.min()) > _STRANGE_GAIN:
        warnings.append(
            f"[calibration] gives gains of {between[0]:.2f}, 1 and {between[2]:.2f} for red, green and blue: check the place and "
            "the spectrum of the known light."
        )
    if ball is not None and ball.exceeds:
        warnings.append(
            "[calibration]: the ball would reflect more than all of the light; it was taken to reflect all. Check the patches."
        )
    return warnings


def calibration_note(calibration: Calibration | None) -> Mapping[str, str]:
    """For the header of the probe's files."""
    if calibration is None:
        return {}
    gains = ", ".join(f"{gain:.6g}" for gain in calibration.gains)
    return {"channel_gains": gains, **({"unit": "W.m^-2.sr^-1.nm^-1"} if calibration.absolute else {})}

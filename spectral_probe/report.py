"""report.json: how a probe was made, and how far it can be trusted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .composition import ResponsePanorama
from .geometry.frames import panorama_solid_angles, view_angles
from .geometry.registration import RegisteredView, ViewRegistration
from .geometry.sampling import sampling
from .known_light import Calibration
from .light import kinds_of_light
from .model import Capture, SpectralPanorama
from .recoveries import Recoveries
from .spectra.advice import light_advice, recovery_advice
from .spectra.camera import REC709, camera_file, camera_sensitivities, gains_remark
from .spectra.panorama import negative_fraction
from .spectra.posterior import metamer_risk
from .spectra.recorded import light_posterior
from .view import MeasuredView


def probe_report(
    capture: Capture,
    views: Sequence[MeasuredView],
    registration: ViewRegistration,
    composition: ResponsePanorama,
    panorama: SpectralPanorama,
    recoveries: Recoveries,
    seconds: Mapping[str, float],
    calibration: Calibration | None = None,
) -> dict[str, Any]:
    """The report's numbers, ready for JSON."""
    kinds = kinds_of_light(composition, recoveries.everywhere[0])
    whole = light_posterior(panorama, panorama.valid) if panorama.valid.any() else None
    channels = composition.responses.shape[-1]
    height, width = panorama.valid.shape
    solid_angles = np.broadcast_to(panorama_solid_angles(height, width), (height, width))
    return {
        "views": [
            {
                **_geometry(view),
                **_placing(view, registered),
                "clipped_fraction": view.clipped_fraction,
                "clipped_sr": clipped_sr,
                **_bracket(view),
            }
            for view, registered, clipped_sr in zip(
                views, registration.views, composition.clipped_sr, strict=True
            )
        ],
        "blind_fraction": float(solid_angles[~panorama.valid].sum() / (4 * np.pi)),
        "clipped_everywhere_sr": composition.clipped_everywhere_sr,
        "camera_curves": _curves_used(capture, views),
        "calibration": None if calibration is None else calibration.described(),
        "warnings": [
            *_warnings(views),
            *registration.warnings,
            *(_curves_remarks(capture, views) if calibration is None else calibration.warnings),
            *recovery_advice(capture.method, capture.families, channels),
            *light_advice(kinds),
        ],
        "channels": channels,
        "kinds_of_light": kinds,
        "metamer_risk_de2000": None if whole is None else metamer_risk(whole.mean, whole.covariance),
        "negative_fraction": negative_fraction(panorama),
        "median_confidence": _median(panorama, panorama.confidence),
        "median_direction_error_deg": None
        if panorama.direction_error_rad is None
        else float(np.degrees(_median(panorama, panorama.direction_error_rad))),
        "width": width,
        "families": list(capture.families),
        "method": capture.method,
        "composition": capture.composition,
        "seconds": {stage: round(value, 3) for stage, value in seconds.items()},
    }


def _median(panorama: SpectralPanorama, values: Any) -> float:
    return float(np.median(values[panorama.valid])) if panorama.valid.any() else 0.0


def _geometry(view: MeasuredView) -> dict[str, Any]:
    """The outline and the camera; the errors are standard errors."""
    errors = sampling(view.camera, view.ball, np.eye(3)).direction_error_rad
    return {
        "photos": [photo.name for photo in view.settings.photos],
        "filter": None if view.settings.filter is None else Path(view.settings.filter).name,
        "centre_px": list(view.outline.centre_px),
        "radius_px": list(view.outline.semi_axes_px),
        "outline_rms_px": view.outline.rms_px,
        "outline_error_px": list(view.outline.error_px),
        "outline_given": view.settings.outline is not None and not view.settings.snap_outline,
        "other_balls_px": [list(circle) for circle in view.others],
        "cone_angle_deg": float(np.degrees(view.ball.cone_angle_rad)),
        "distance_m": view.ball.distance_m,
        "direction_error_deg": float(np.degrees(np.median(errors))),
        "focal_px": list(view.camera.focal_px),
        "focal_source": view.camera.source,
    }


def _placing(view: MeasuredView, registered: RegisteredView) -> dict[str, Any]:
    """A view's angles as refined and as given, and what registration says of them."""
    azimuth, elevation, roll = view_angles(registered.rotation)
    return {
        "azimuth_deg": azimuth,
        "elevation_deg": elevation,
        "roll_deg": roll,
        "nominal_azimuth_deg": view.settings.azimuth_deg,
        "nominal_elevation_deg": view.settings.elevation_deg,
        "nominal_roll_deg": view.settings.roll_deg,
        "gain": [float(gain) for gain in registered.gain],
        "registered": registered.registered,
        "registration_residual_deg": registered.residual_deg,
        "registration_error_deg": registered.error_deg,
        "registration_correlation": registered.correlation,
    }


def _bracket(view: MeasuredView) -> dict[str, Any]:
    """How a view's bracket was merged; numbers that the pixels do not tell are None."""
    response = view.bracket.response
    return {
        "exposures_s": [exposure.time_s for exposure in view.bracket.exposures],
        "exposure_offsets_ev": [
            None if np.isnan(offset) else round(offset, 3) for offset in view.bracket.offsets_ev
        ],
        "response_residual_ev": list(response.residual_ev) if response else None,
        "moved_fraction": view.moved_fraction,
    }


def _curves_used(capture: Capture, views: Sequence[MeasuredView]) -> str:
    if all(view.converted for view in views):
        return REC709
    file = capture.camera.sensitivities
    return camera_file(file, capture.camera.model).name if file else capture.camera.model or REC709


def _curves_remarks(capture: Capture, views: Sequence[MeasuredView]) -> list[str]:
    """What to say of curves that were used without calibration."""
    name = _curves_used(capture, views)
    if name == REC709:
        return []
    curves = camera_sensitivities(capture.camera.model, capture.camera.sensitivities)
    remark = gains_remark(name, curves)
    return [] if remark is None else [remark]


def _warnings(views: Sequence[MeasuredView]) -> list[str]:
    """What the user should know of the photographs; what holds for all views alike is said once."""
    told = []
    if all(view.converted for view in views):
        told.append("The photographs are converted pictures (JPEG): Rec.709's colours were assumed. Use raw.")
    views_of: dict[str, list[int]] = {}
    for number, view in enumerate(views, start=1):
        for remark in view.remarks:
            views_of.setdefault(remark, []).append(number)
    return told + [
        remark
        if len(numbers) == len(views)
        else f"View{'s' if len(numbers) > 1 else ''} {', '.join(map(str, numbers))}: {remark}"
        for remark, numbers in views_of.items()
    ]

"""What is to be seen of an outline over its photograph, as a short text that a file can keep."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..errors import SpectralProbeError
from ..files.json_object import UNREADABLE
from ..model import Camera, FloatArray, Outline
from .ball import fit_ball
from .ball_zones import Ring, ball_zones
from .ellipse import Ellipse

_VERSION = 1
_SLOTS = 360
_STEP_PX = 1e-3


@dataclass(frozen=True)
class OutlineSummary:
    """An outline's residuals and zones.

    `angles_rad` (N,) are directions from the outline's centre in the image, `residuals_px` (N,) how far outside of it the edge
    lies there. `zones` are rings on the ball, `cone_angle_rad` the half angle of the blind cone; both are empty and 0 where the
    camera's focal length is not known.
    """

    angles_rad: FloatArray = field(default_factory=lambda: np.zeros(0))
    residuals_px: FloatArray = field(default_factory=lambda: np.zeros(0))
    zones: tuple[Ring, ...] = ()
    cone_angle_rad: float = 0.0


def summary_of(outline: Outline, camera: Camera | None, radius_m: float) -> OutlineSummary:
    """The summary of an outline found or given; without a camera it has no zones."""
    away = np.asarray(outline.points_px, float).reshape(-1, 2) - outline.centre_px
    angles = np.arctan2(away[:, 1], away[:, 0])
    residuals = np.hypot(away[:, 0], away[:, 1]) - Ellipse.of(outline).radius_at(angles)
    if outline.rms_px == 0.0:  # a circle given rests on no edges
        angles = residuals = np.zeros(0)
    if camera is None:
        return OutlineSummary(angles, residuals)
    try:
        ball = fit_ball(camera, outline, radius_m)
    except SpectralProbeError:  # not the outline of a ball: the probe will say so
        return OutlineSummary(angles, residuals)
    return OutlineSummary(angles, residuals, ball_zones(camera, ball), float(ball.cone_angle_rad))


def to_text(summary: OutlineSummary) -> str:
    """A summary as text: residuals to a thousandth of a pixel, one a degree, rings to a hundredth."""
    slots: list[int | None] = [None] * _SLOTS
    for angle, residual in zip(summary.angles_rad, summary.residuals_px, strict=True):
        slots[int(np.floor(angle / (2.0 * np.pi) * _SLOTS)) % _SLOTS] = round(float(residual) / _STEP_PX)
    zones = [
        {
            "incidence_rad": round(ring.incidence_rad, 5),
            "light_rad": round(ring.light_rad, 5),
            "error_rad": round(ring.error_rad, 7),
            "points_px": np.round(ring.points_px, 2).tolist(),
        }
        for ring in summary.zones
    ]
    document = {
        "version": _VERSION,
        "residuals": slots,
        "zones": zones,
        "cone_angle_rad": round(summary.cone_angle_rad, 6),
    }
    return json.dumps(document, separators=(",", ":"))


def from_text(text: str) -> OutlineSummary:
    """The inverse of `to_text`; an empty summary where the text is not one (another version's, or nobody's).

    Examples
    --------
    >>> summary = OutlineSummary(np.radians([10.5, 200.5]), np.array([0.25, -0.125]))
    >>> again = from_text(to_text(summary))
    >>> np.degrees(again.angles_rad).round(1).tolist(), again.residuals_px.tolist()
    ([10.5, 200.5], [0.25, -0.125])
    >>> len(from_text("{").angles_rad)
    0
    """
    try:
        document: dict[str, Any] = json.loads(text)
        if document["version"] != _VERSION:
            return OutlineSummary()
        slots = document["residuals"]
        known = [index for index, value in enumerate(slots) if value is not None]
        zones = tuple(
            Ring(
                float(ring["incidence_rad"]),
                float(ring["light_rad"]),
                float(ring["error_rad"]),
                np.array(ring["points_px"], float).reshape(-1, 2),
            )
            for ring in document["zones"]
        )
        return OutlineSummary(
            (np.array(known, float) + 0.5) * (2.0 * np.pi / _SLOTS),
            np.array([slots[index] for index in known], float) * _STEP_PX,
            zones,
            float(document["cone_angle_rad"]),
        )
    except UNREADABLE:
        return OutlineSummary()

"""The rim of a mirrored ball to a small part of a pixel, from an outline known to a hundredth of its radius.

The profiles across it are fitted with what `rim_profile` knows of mirrors. Pictures with sharpening and a tone curve
(JPEG) are always fitted with a step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..model import BoolArray, FloatArray, Photograph
from .ellipse import Ellipse, full_turn
from .rim_profile import CUSP, DIMMED_CUSP, ENOUGH_ANGLES, STEP, best_model, profiles_of, robust_fit
from .rim_step import step_outside
from .unrolled import ANGLES, Circle, PolarEvidence, best_circle, harmonics, polar_evidence, shares_along

FINE_RADII_PX = (150.0, 300.0, 600.0)
"""Radii to which the ball is scaled down, for one fit after the other; a twentieth of a pixel of the last is
1e-4 of the radius."""

BLURRED_PX = 1.0
"""From this blur on, a larger picture only adds noise and false edges: the ball was out of focus."""

REPEATS, SETTLED_PX = 4, 0.3
"""A fit is repeated round its own result, at most so often, until it moves less than this."""

ELLIPTICITY_GAIN = 0.1
"""An ellipse must find edges along this much more of the rim than a circle; with one more parameter noise alone
finds a little more."""

SHORTEST_FOCAL = 0.5
"""Focal length over the frame's long side: a lens of 18 mm on film. Limits how elliptical an outline can be."""

BLURRED_SHARE = 0.8
BELIEVED_PX = 1.8
"""A fit that moves the outline further than this, in pixels of its picture, has followed something else."""

RIM_ANGLES, ENOUGH_DEVELOPED_ANGLES = 360, 144
"""So many of the angles must speak for a fit where sharpening and JPEG leave false edges, or the outline stays as it was."""


@dataclass(frozen=True)
class Rim:
    """An outline and the points (N, 2) it rests on; `coverage` is the share of the visible rim with an edge."""

    ellipse: Ellipse
    points_px: FloatArray
    rms_px: float
    coverage: float


def approach(
    photographs: Sequence[Photograph], shifts_px: Sequence[FloatArray], circle: Circle
) -> tuple[Ellipse, float, BoolArray]:
    """Follow a circle to the rim at two sizes: the ellipse, its coverage, and where (A,) an edge shows."""
    ellipse = Ellipse(circle.x, circle.y, circle.radius, circle.radius)
    coverage = 0.0
    shown = np.ones(ANGLES, bool)
    for level, span, reach in ((120.0, 0.12, 0.025), (400.0, 0.04, 0.012)):
        base = Circle(ellipse.x, ellipse.y, ellipse.radius)
        bulge = ellipse.radius_at(full_turn(ANGLES)) - ellipse.radius
        evidence = polar_evidence(photographs, shifts_px, base, level, span, bulge)
        best = best_circle(evidence, base, reach)
        change = np.array([best.x - base.x, best.y - base.y, best.radius - base.radius, 0.0, 0.0])
        limit = _ellipticity_limit(ellipse, photographs[0], shifts_px[0]) if level == 120.0 else 0j
        change, found = _with_ellipticity(evidence, change, best.coverage, limit)
        if found < BLURRED_SHARE * coverage:
            break  # the larger picture shows less: the rim is out of focus
        coverage = found
        ellipse = ellipse.changed(change)
        shown = _edge_shown(evidence, change)
    return ellipse, coverage, shown


def _with_ellipticity(
    evidence: PolarEvidence, change: FloatArray, coverage: float, limit: complex
) -> tuple[FloatArray, float]:
    """Add ellipticity (up to `limit`, in pixels) where it clearly finds more edges than a circle does."""
    if abs(limit) * evidence.scale < 1.0:
        return change, coverage
    best, best_share = change, 0.0
    for start in (change, np.zeros(5)):  # the best circle along an ellipse may lie well off its centre
        tried, share, low, high = start, 0.0, 0.0, 1.0
        for _ in range(2):
            amounts = np.linspace(low, high, 9)
            step = 1.5 * max((amounts[1] - amounts[0]) * abs(limit), 0.5 / evidence.scale)
            near = np.linspace(-step, step, 5)
            grid = np.stack(np.meshgrid(near, near, near, amounts, indexing="ij"), axis=-1).reshape(-1, 4)
            bulge = grid[:, 3:] * np.array([limit.real, limit.imag])
            options = np.concatenate([grid[:, :3] + tried[:3], bulge], axis=1)
            shares, visible, _ = shares_along(evidence, options)
            shares = shares * np.minimum(1.0, visible / 0.5)
            top = int(shares.argmax())
            tried, share = options[top], float(shares[top])
            low, high = np.clip(grid[top, 3] + np.array([-0.15, 0.15]), 0.0, 1.0)
        if share > best_share:
            best, best_share = tried, share
    if best_share < coverage + ELLIPTICITY_GAIN:
        return change, coverage
    return best, best_share


def _ellipticity_limit(ellipse: Ellipse, photograph: Photograph, shift_px: FloatArray) -> complex:
    """The largest ellipticity that perspective can give a ball there: half the axes' difference, and their direction.

    A ball seen at the angle phi from the optical axis has an outline stretched by 1 / cos phi along the line from
    the frame's centre to the ball. The focal length is unknown here and taken as short as a phone's wide angle.
    """
    height, width = photograph.clipped.shape
    offset = complex(ellipse.x + shift_px[0] - width / 2, ellipse.y + shift_px[1] - height / 2)
    stretch = np.hypot(1.0, abs(offset) / (SHORTEST_FOCAL * max(width, height))) - 1.0
    direction = offset / abs(offset) if offset else 1.0
    return complex(0.5 * stretch * ellipse.radius * direction**2)


def _edge_shown(evidence: PolarEvidence, change: FloatArray) -> BoolArray:
    """Angles (A,) at which, or beside which, an edge lies along the outline."""
    offset = harmonics(evidence.angles_rad, len(change)) @ change
    column = np.abs(evidence.offsets_px[None] - offset[:, None]).argmin(axis=1)
    edge = evidence.strength[np.arange(ANGLES), column] > 0.3
    return np.asarray(edge | np.roll(edge, 1) | np.roll(edge, -1))


# ---------------------------------------------------------------- the last fit


def fit_rim(photographs: Sequence[Photograph], shifts_px: Sequence[FloatArray], circle: Circle) -> Rim:
    """Fit the rim in one or more photographs of a bracket together.

    Parameters
    ----------
    photographs
        The bracket.
    shifts_px
        Where the ball of each lies from where it is in the first one's frame (x, y), zeros for a camera that
        stood still.
    circle
        The outline in the first one's frame to within some 5 % of its radius.

    Returns
    -------
    Rim
        Its points are the measured ones, each drawn towards the curve by as much as its weight is less than
        the best: an unweighted fit to the points then gives what the weighted fit to the measurements gave.
    """
    ellipse, coverage, shown = approach(photographs, shifts_px, circle)
    angles = full_turn(RIM_ANGLES)
    usable = np.interp(angles, full_turn(ANGLES), shown.astype(float), period=2.0 * np.pi) > 0.5
    fitting = _Fitting(photographs, shifts_px, usable, (CUSP, STEP))
    rim = _unrefined(ellipse, coverage, angles[usable])
    for level in FINE_RADII_PX:
        scale = min(1.0, level / rim.ellipse.radius)
        refined, blur = fitting.settled(rim, scale)
        if refined is None:
            break
        rim = refined
        if blur >= BLURRED_PX or scale == 1.0:
            break  # a larger picture would not be sharper
    beyond = step_outside(photographs, shifts_px, rim.ellipse)
    if beyond is None:
        return rim
    found = _unrefined(beyond, coverage, angles)
    scale = min(1.0, FINE_RADII_PX[-1] / beyond.radius)
    dimmed = _Fitting(photographs, shifts_px, np.ones(RIM_ANGLES, bool), (DIMMED_CUSP, STEP))
    return dimmed.settled(found, scale)[0] or found


@dataclass(frozen=True)
class _Fitting:
    """What a rim is fitted to: a bracket, the angles (A,) at which an edge shows, and the models tried for the profiles."""

    photographs: Sequence[Photograph]
    shifts_px: Sequence[FloatArray]
    usable: BoolArray
    models: Sequence[Sequence[str]]

    def settled(self, rim: Rim, scale: float) -> tuple[Rim | None, float]:
        """The rim fitted again and again at one scale until it moves no more, and its blur; None where nothing fits."""
        blur = 0.0
        for _ in range(REPEATS):
            refined = self._refined(rim, scale)
            if refined is None:
                return None, blur
            moved_px = _distance(refined[0].ellipse, rim.ellipse) * scale
            rim, blur = refined
            if moved_px < SETTLED_PX:
                break
        return rim, blur

    def _refined(self, rim: Rim, scale: float) -> tuple[Rim, float] | None:
        """The rim fitted in pictures scaled by `scale`, and their blur in their own pixels; None where nothing fits."""
        ellipse = rim.ellipse
        angles = full_turn(RIM_ANGLES)
        profiles = [
            profiles_of(one, ellipse.moved(shift), scale, angles)
            for one, shift in zip(self.photographs, self.shifts_px, strict=True)
        ]
        # Sharpening and tone curves make halos at the rim that pass for the outer side of a cusp.
        developed = any(one.display_referred for one in self.photographs)
        model = best_model(profiles, self.usable, (STEP,) if developed else self.models)
        if model is None:
            return None
        misfit, blur = model
        change, found, weight = robust_fit(misfit, angles)
        good = weight > 0.02 * weight.max()
        enough = ENOUGH_DEVELOPED_ANGLES if developed else ENOUGH_ANGLES
        if good.sum() < enough or np.abs(change).max() > BELIEVED_PX:
            return None
        curve = harmonics(angles, 3) @ change
        residual = np.where(good, (found - curve) * weight / weight.max(), 0.0)
        radius = ellipse.radius_at(angles) + (curve + residual) / scale
        direction = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        points = np.array([ellipse.x, ellipse.y]) + radius[:, None] * direction
        rms = float(np.sqrt(np.average((found - curve)[good] ** 2, weights=weight[good]))) / scale
        return Rim(ellipse.changed(change / scale), points[good], rms, rim.coverage), blur


def _distance(one: Ellipse, other: Ellipse) -> float:
    return max(abs(one.x - other.x), abs(one.y - other.y), abs(one.radius - other.radius))


def _unrefined(ellipse: Ellipse, coverage: float, angles: FloatArray) -> Rim:
    """The outline as `approach` left it, good to about half a pixel of its picture."""
    if len(angles) < 24:
        angles = full_turn(RIM_ANGLES)
    direction = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    points = np.array([ellipse.x, ellipse.y]) + ellipse.radius_at(angles)[:, None] * direction
    return Rim(ellipse, points, max(0.5, 0.5 * ellipse.radius / 400.0), coverage)

"""Views registered against each other on the sphere: nominal azimuths, elevations and rolls refined, gains matched.

Each view is unwrapped once at its nominal angles to a small panorama. Its detail (`view_features`) is found in what the
views placed before it see, by trying rotations from a wide range (`rotation_search`); then all rotations are
adjusted together from coarse to fine (`bundle`), with the distance of the surroundings as a nuisance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..model import BallFit, Camera, FloatArray, RadianceImage
from .bundle import (
    Bundle,
    Level,
    angle_between,
    correlation,
    merged_others,
    remaining_turn,
    sample_views,
    solve_level,
    start,
)
from .gains import match_gains
from .panorama import ViewPanorama, view_panorama
from .rotation_search import search_rotation
from .view_features import FeatureMap, even_directions, feature_map

WORKING_WIDTH = 512
"""Width of the small panoramas, in pixels: texels of 0.7 degrees, of which registration resolves a tenth."""

_SEARCH_DIRECTIONS = 1000
_JUDGED_DIRECTIONS = 8000
_LEVELS = (
    Level(128, np.radians(3.0), np.radians(12.0), 6000, 0.5, 20),
    Level(256, np.radians(1.2), np.radians(6.0), 12000, 0.25, 20),
    Level(512, np.radians(0.8), np.radians(6.0), 20000, 0.12, 20),
)
_JUDGED = 1
"""The level at which views are compared, to judge whether they fit."""

_LEAST_CORRELATION = 0.25
"""Views that correlate less with the others than this, once registered, show too little in common."""

_LEAST_IMPROVEMENT = 0.002
"""A turn that does not raise the correlation by this much is not worth leaving the angles given."""

_PARALLAX_RAD = np.radians(0.15)
"""What the ball's own size leaves uncertain in a room; a smaller turn than this, and two standard errors, is not taken."""


@dataclass(frozen=True)
class PlacedView:
    """One view to register: its radiance image, geometry, nominal camera-to-world rotation (3, 3), and whether it may turn."""

    image: RadianceImage
    camera: Camera
    ball: BallFit
    rotation: FloatArray
    refine: bool = True

    @property
    def pixel_rad(self) -> float:
        """Angle that a pixel of the photograph spans in the panorama where the ball faces the camera: 2 / R."""
        return float(2.0 / (max(self.camera.focal_px) * np.tan(self.ball.cone_angle_rad)))

    @property
    def towards_camera(self) -> FloatArray:
        """Direction (3,) from the ball to the camera, in the world at the nominal rotation."""
        return np.asarray(-self.rotation @ self.ball.centre_m / self.ball.distance_m)


@dataclass(frozen=True)
class RegisteredView:
    """What registration says of one view.

    `rotation` (3, 3) camera to world, `turn` (3, 3) from the nominal rotation to it. `gain` (3,) is what its responses are to
    be multiplied by to match the anchor's. `residual_deg` is the rotation that would still fit it best to the merge of the
    others, `error_deg` the standard error of its rotation (0 for an anchor). `correlation` with the others is as registered,
    `nominal_correlation` before. `registered` is False where it has too little in common with the others and stays at its
    nominal angles.
    """

    rotation: FloatArray
    turn: FloatArray
    gain: FloatArray
    residual_deg: float
    error_deg: float
    correlation: float
    nominal_correlation: float
    registered: bool


@dataclass(frozen=True)
class ViewRegistration:
    """The views as registered, and a sentence on each that could not be."""

    views: tuple[RegisteredView, ...]
    warnings: tuple[str, ...] = ()


def register_with_partners(
    views: Sequence[PlacedView], partner: Sequence[int], panoramas: Sequence[ViewPanorama] | None = None
) -> ViewRegistration:
    """Register the views that are their own partners; the others take what is said of theirs.

    Photographs through a filter show other colours and levels than the rest, and were taken from the same place as their
    partner's: its rotation and its gain are theirs.

    Parameters
    ----------
    views
        All views.
    partner
        (V,) number of each view's partner, its own for those that are registered.
    panoramas
        As for `register_views`, of the views that are registered.
    """
    leaders = [number for number, own in enumerate(partner) if own == number]
    found = register_views([views[number] for number in leaders], panoramas, leaders)
    return ViewRegistration(tuple(found.views[leaders.index(own)] for own in partner), found.warnings)


def register_views(
    views: Sequence[PlacedView],
    panoramas: Sequence[ViewPanorama] | None = None,
    numbers: Sequence[int] | None = None,
) -> ViewRegistration:
    """Refine the rotations of views against each other and match their gains.

    Parameters
    ----------
    views
        The views. Those with `refine` False keep their angles; if none has, the first does.
    panoramas
        Small panoramas of the views at their nominal rotations (`small_panorama`), if they exist already.
    numbers
        What the views are called in warnings, counted from 0; their order here by default.

    Returns
    -------
    ViewRegistration
    """
    if len(views) < 2:
        alone = [
            RegisteredView(view.rotation, np.eye(3), np.ones(3), 0.0, 0.0, 1.0, 1.0, registered=True)
            for view in views
        ]
        return ViewRegistration(tuple(alone))
    panoramas = panoramas or [small_panorama(view) for view in views]
    cameras = np.stack([view.towards_camera for view in views])
    fixed = [not view.refine for view in views]
    fixed[0] = fixed[0] or not any(fixed)
    levels = [
        [
            feature_map(panorama, view.pixel_rad, level.width, level.fine_rad, level.coarse_rad)
            for panorama, view in zip(panoramas, views, strict=True)
        ]
        for level in _LEVELS
    ]
    bundle = _adjusted(levels, cameras, _placed(levels[0], cameras, fixed), fixed)
    before = _correlations(levels[_JUDGED], cameras, start(len(views)))
    lost = [
        not hold and value < _LEAST_CORRELATION
        for hold, value in zip(fixed, _correlations(levels[_JUDGED], cameras, bundle), strict=True)
    ]
    if any(lost):  # what has nothing in common with the others must not pull at them
        bundle = _adjusted(levels, cameras, _nominal_where(bundle, lost), fixed, lost)
    bundle, after = _accepted(bundle, before, levels[_JUDGED], cameras)
    residuals = _residuals(levels[_JUDGED], cameras, bundle)
    gains = match_gains(panoramas, bundle.corrections, fixed.index(True))
    errors = np.degrees(np.sqrt(np.trace(bundle.covariance, axis1=1, axis2=2)))
    registered = tuple(
        RegisteredView(
            bundle.corrections[v] @ view.rotation,
            bundle.corrections[v],
            gains[v],
            float(np.degrees(residuals[v])),
            float(errors[v]),
            after[v],
            before[v],
            not lost[v],
        )
        for v, view in enumerate(views)
    )
    names = range(len(views)) if numbers is None else numbers
    return ViewRegistration(
        registered, tuple(_warning(name) for name, away in zip(names, lost, strict=True) if away)
    )


def _placed(maps: Sequence[FeatureMap], cameras: FloatArray, fixed: Sequence[bool]) -> Bundle:
    """Views placed one after the other, the one next to those placed already first, each where it fits them best."""
    bundle = start(len(maps))
    directions = even_directions(_SEARCH_DIRECTIONS)
    placed = [view for view, hold in enumerate(fixed) if hold]
    waiting = [view for view, hold in enumerate(fixed) if not hold]
    while waiting:
        view = max(waiting, key=lambda candidate: float((cameras[placed] @ cameras[candidate]).max()))
        waiting.remove(view)
        several = [*placed, view]
        here = replace(bundle, corrections=bundle.corrections[several])
        samples = sample_views([maps[v] for v in several], cameras[several], here, directions)
        reference, _ = merged_others(samples, len(placed))
        found = search_rotation(
            maps[view], bundle.corrections[view], reference, samples.weight[:-1].sum(0), directions
        )
        corrections = bundle.corrections.copy()
        corrections[view] = found
        bundle = replace(bundle, corrections=corrections)
        placed.append(view)
    return bundle


def _adjusted(
    levels: Sequence[Sequence[FeatureMap]],
    cameras: FloatArray,
    bundle: Bundle,
    fixed: Sequence[bool],
    left_out: Sequence[bool] | None = None,
) -> Bundle:
    """All views that may turn, turned together, from coarse to fine; those left out neither turn nor count."""
    taking_part = [view for view in range(len(fixed)) if left_out is None or not left_out[view]]
    moving = [number for number, view in enumerate(taking_part) if not fixed[view]]
    if not moving:
        return bundle
    part = replace(
        bundle, corrections=bundle.corrections[taking_part], covariance=bundle.covariance[taking_part]
    )
    for level, maps in zip(_LEVELS, levels, strict=True):
        part = solve_level([maps[view] for view in taking_part], cameras[taking_part], part, level, moving)
    corrections, covariance = bundle.corrections.copy(), np.zeros_like(bundle.covariance)
    corrections[taking_part], covariance[taking_part] = part.corrections, part.covariance
    return Bundle(corrections, part.depths, covariance)


def _nominal_where(bundle: Bundle, chosen: Sequence[bool]) -> Bundle:
    corrections = np.where(np.asarray(chosen)[:, None, None], np.eye(3), bundle.corrections)
    return replace(bundle, corrections=corrections)


def _accepted(
    bundle: Bundle, before: Sequence[float], maps: Sequence[FeatureMap], cameras: FloatArray
) -> tuple[Bundle, list[float]]:
    """The bundle with every turn undone that is too small to be known or does not make its view fit better."""
    errors = np.sqrt(np.trace(bundle.covariance, axis1=1, axis2=2))
    after = _correlations(maps, cameras, bundle)
    undone = [
        angle_between(np.eye(3), turn) < max(_PARALLAX_RAD, 2.0 * error)
        or better < worse + _LEAST_IMPROVEMENT
        for turn, error, better, worse in zip(bundle.corrections, errors, after, before, strict=True)
    ]
    bundle = _nominal_where(bundle, undone)
    return bundle, _correlations(maps, cameras, bundle)


def _correlations(maps: Sequence[FeatureMap], cameras: FloatArray, bundle: Bundle) -> list[float]:
    """Correlation of each view's detail with the merge of the others."""
    samples = sample_views(maps, cameras, bundle, even_directions(_JUDGED_DIRECTIONS))
    return [
        correlation(samples.detail[view], *merged_others(samples, view))
        for view in range(len(samples.detail))
    ]


def _residuals(maps: Sequence[FeatureMap], cameras: FloatArray, bundle: Bundle) -> list[float]:
    """Rotation in radians by which each view, as placed, still differs from the merge of the others."""
    directions = even_directions(_JUDGED_DIRECTIONS)
    samples = sample_views(maps, cameras, replace(bundle, depths=np.zeros_like(bundle.depths)), directions)
    return [
        remaining_turn(
            features,
            bundle.corrections[view],
            *merged_others(samples, view),
            directions,
            0.25 * _LEVELS[1].fine_rad,
        )
        for view, features in enumerate(maps)
    ]


def small_panorama(view: PlacedView) -> ViewPanorama:
    """A view's panorama at the working width and its nominal rotation."""
    return view_panorama(view.image, view.camera, view.ball, view.rotation, WORKING_WIDTH)


def _warning(view: int) -> str:
    return (
        f"View {view + 1} shows too little in common with the others to be registered; it stays at the angles given. "
        "Check them, or take more views."
    )

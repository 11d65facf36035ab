"""The rim of a mirrored ball to a small part of a pixel, from an outline known to a few hundredths of its radius.

Three steps, each on larger pictures: the circle or ellipse that most edges lie along; a robust curve through the
single edges near it; and, where the picture is good enough, profiles across the rim fitted with what a mirror's rim
looks like (`rim_profile`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..model import BoolArray, Camera, FloatArray, Photograph
from .ball import correlated
from .edges import EdgeField
from .ellipse import Ellipse, full_turn
from .rim_profile import (
    CUSP,
    ENOUGH_ANGLES,
    ENOUGH_DEVELOPED_ANGLES,
    SEARCH_STEP_PX,
    RimModel,
    misfits,
    places,
    profiles,
    rim_models,
    rim_picture,
)
from .rim_shape import RimShape
from .unrolled import (
    ANGLES,
    SEARCH_WEIGHTS,
    Circle,
    PolarEvidence,
    best_circle,
    edges_along,
    polar_evidence,
    ring_field,
    worth,
)

FIRST, SECOND = (120.0, 0.12, 0.025), (400.0, 0.04, 0.015)
"""Radius of the pictures, half width of the ring and reach of the search in radii, of the two steps along edges."""

FINE_RADII_PX = (150.0, 300.0, 600.0)
"""Radii to which the ball is scaled down, for one fit after the other; a twentieth of a pixel of the last is
1e-4 of the radius."""

BLURRED_PX, BLURRED_SHARE = 1.0, 0.8
"""From this blur on, or where a larger picture shows less of the rim than this share of what a smaller one did, larger
pictures only add noise and false edges: the ball was out of focus."""

REPEATS, SETTLED_PX = 4, 0.3
"""A fit is repeated round its own result, at most so often, until it moves less than this."""

MOST_ELLIPTICITY = 0.045
"""Half the difference of the semi-axes over the radius. A ball 20 degrees off the axis reaches 0.03."""

ELLIPTICITY_GAIN = 0.1
"""An ellipse must find edges along this much more of the rim than a circle; with two more parameters noise alone
finds a little more."""

CLEARLY = 0.12
"""What the worth of outlines must differ by to count."""

USUAL_FOCAL = 0.75
"""Focal length over the frame's long side where nobody says: 27 mm on film, as of phones and the short end of zooms."""

BELIEVED_PX = 1.8
"""A fit that moves the outline further than this, in pixels of its picture, has followed something else."""

RIM_ANGLES = 360
SCATTER = 2.5
"""Edges so many standard deviations of their scatter from the curve still count."""

CUSP_ERROR_PX, STEP_ERROR_PX, EDGE_ERROR_PX = 0.2, 0.35, 0.8
"""What every point of a rim may be out by together, in pixels of the picture fitted: where the model of the rim is not
quite the rim."""


@dataclass(frozen=True)
class Rim:
    """An outline and the points (N, 2) it rests on; `coverage` is the share of the visible rim with an edge.

    `error_px` are the standard errors of the centre and of the radius, `worth` is what the first step's rivals are judged by.
    """

    ellipse: Ellipse
    points_px: FloatArray
    rms_px: float
    coverage: float
    error_px: tuple[float, float]
    worth: float = 0.0


def fit_rim(
    photographs: Sequence[Photograph],
    shifts_px: Sequence[FloatArray],
    circles: Sequence[Circle],
    camera: Camera | None = None,
) -> Rim:
    """Fit the rim in one or more photographs of a bracket together.

    Parameters
    ----------
    photographs
        The bracket.
    shifts_px
        Where the ball of each lies from where it is in the first one's frame (x, y), zeros for a camera that
        stood still.
    circles
        The outline in the first one's frame to within some 5 % of its radius; of several, the one that leads to the best
        outline counts.
    camera
        What the outline may look like follows from it; without it, a circle, or an ellipse where that is clearly better.
    """
    rims = [_first_rim(photographs, shifts_px, circle, RimShape(camera)) for circle in circles]
    chosen = _chosen([(one[0].ellipse, one[0].worth, one[0].coverage) for one in rims])
    rim, shape, shown = rims[chosen]
    rim, shown = _followed(photographs, shifts_px, rim, shape, shown)
    return _refined(photographs, shifts_px, rim, shape, shown)


# ---------------------------------------------------------------- along the edges


def _first_rim(
    photographs: Sequence[Photograph], shifts_px: Sequence[FloatArray], circle: Circle, shape: RimShape
) -> tuple[Rim, RimShape, BoolArray]:
    """Follow a circle to the rim: the outline, what shapes it may take, and where (A,) an edge shows."""
    ellipse = shape.nearest(Ellipse(circle.x, circle.y, circle.radius, circle.radius))
    level, span, reach = FIRST
    base = Circle(ellipse.x, ellipse.y, ellipse.radius)
    bulge = ellipse.radius_at(full_turn(ANGLES)) - ellipse.radius
    field = ring_field(photographs, shifts_px, (base.x, base.y, ellipse.major), level, span)
    evidence = polar_evidence(field, base, span, bulge)
    starts = [ellipse]
    for weights in (SEARCH_WEIGHTS, SEARCH_WEIGHTS[:1], (0.0,)):
        best = best_circle(evidence, base, reach, weights)
        change = np.array([best.x - base.x, best.y - base.y, best.radius - base.radius])
        starts.append(ellipse.changed(change))
    tendency = _perspective(ellipse, photographs[0], shifts_px[0])
    found, shape = _first_outline(field, evidence, starts, shape, tendency)
    if found is None:
        found = starts[1], starts[1].points(full_turn(RIM_ANGLES))
    share = _coverage(evidence, ellipse, found[0])
    rim = _rim_of(found[0], found[1], shape, share, EDGE_ERROR_PX / evidence.scale)
    rim = replace(rim, worth=worth(evidence, _difference(ellipse, rim.ellipse)))
    return rim, shape, _shown(evidence, base, rim.ellipse, bulge)


def _followed(
    photographs: Sequence[Photograph],
    shifts_px: Sequence[FloatArray],
    rim: Rim,
    shape: RimShape,
    shown: BoolArray,
) -> tuple[Rim, BoolArray]:
    """The rim followed in a larger picture, unless that shows less of it: then it is out of focus."""
    level, span, reach = SECOND
    ellipse = rim.ellipse
    if ellipse.radius <= FIRST[0]:
        return rim, shown
    base = Circle(ellipse.x, ellipse.y, ellipse.radius)
    bulge = ellipse.radius_at(full_turn(ANGLES)) - ellipse.radius
    field = ring_field(photographs, shifts_px, (base.x, base.y, ellipse.major), level, span)
    found = _along_edges(field, ellipse, shape, reach * ellipse.radius)
    if found is None or len(found[1]) < BLURRED_SHARE * len(rim.points_px):
        return rim, shown
    evidence = polar_evidence(field, base, span, bulge)
    share = _coverage(evidence, ellipse, found[0])
    better = _rim_of(found[0], found[1], shape, share, EDGE_ERROR_PX / evidence.scale)
    return better, _shown(evidence, base, better.ellipse, bulge)


def _first_outline(
    field: EdgeField,
    evidence: PolarEvidence,
    starts: Sequence[Ellipse],
    shape: RimShape,
    tendency: complex,
) -> tuple[tuple[Ellipse, FloatArray] | None, RimShape]:
    """The outline through the edges round some starting points that most edges lie along, and its shape.

    `evidence` is unrolled round the first start. With an unknown camera an ellipse is tried too, and taken where it finds
    clearly more edges than a circle and is no stranger than perspective makes it.
    """
    base = starts[0]
    tried = [_along_edges(field, shape.nearest(start), shape, 0.03 * base.radius) for start in starts]
    plain, share = _best_of(tried, evidence, base)
    if shape.camera is not None:
        return plain, shape
    free = RimShape(None, 5)
    tried = [
        _along_edges(field, start.changed(np.array([0.0, 0.0, 0.0, *bent])), free, 0.05 * base.radius)
        for start in starts
        for bent in ((0.0, 0.0), (tendency.real, tendency.imag))
    ]
    limit = MOST_ELLIPTICITY * base.radius
    bent, more = _best_of([one for one in tried if one and abs(one[0].ellipticity) < limit], evidence, base)
    # In an uncropped picture perspective tells how elliptical the ball can be; more than that must show twice as clearly.
    needed = ELLIPTICITY_GAIN
    if bent is not None and abs(bent[0].ellipticity - tendency) > max(abs(tendency), 0.004 * base.radius):
        needed *= 2.0
    if bent is not None and more > share + needed:
        return bent, free
    return plain, shape


def _best_of(
    outlines: Sequence[tuple[Ellipse, FloatArray] | None], evidence: PolarEvidence, base: Ellipse
) -> tuple[tuple[Ellipse, FloatArray] | None, float]:
    """Of outlines through edges, the one that most speaks for, and how much that is."""
    found = [one for one in outlines if one]
    if not found:
        return None, 0.0
    chosen = _chosen(
        [
            (one[0], worth(evidence, _difference(base, one[0])), _coverage(evidence, base, one[0]))
            for one in found
        ]
    )
    return found[chosen], _coverage(evidence, base, found[chosen][0])


def _chosen(rated: Sequence[tuple[Ellipse, float, float]]) -> int:
    """Which of ellipses with their worth and their coverage is the rim.

    Most edges lie along it, but for a ring within the ball: that is told by a rival's clearly higher worth. A little higher
    means nothing, since a blurred rim draws the worthiest outwards.
    """
    best = max(range(len(rated)), key=lambda index: rated[index][2])
    worthiest = max(range(len(rated)), key=lambda index: rated[index][1])
    return worthiest if rated[worthiest][1] > rated[best][1] + CLEARLY else best


def _perspective(ellipse: Ellipse, photograph: Photograph, shift_px: FloatArray) -> complex:
    """The ellipticity that perspective gives a ball there through a usual lens, in an uncropped picture.

    A ball seen at the angle phi from the optical axis has an outline stretched by 1 / cos phi along the line from
    the frame's centre to the ball.
    """
    height, width = photograph.clipped.shape
    offset = complex(ellipse.x + shift_px[0] - width / 2, ellipse.y + shift_px[1] - height / 2)
    stretch = np.hypot(1.0, abs(offset) / (USUAL_FOCAL * max(width, height))) - 1.0
    direction = offset / abs(offset) if offset else 1.0
    return complex(0.5 * stretch * ellipse.radius * direction**2)


def _difference(base: Ellipse, ellipse: Ellipse) -> FloatArray:
    """The change (5,) in harmonics that makes `ellipse` of `base`."""
    second = ellipse.ellipticity - base.ellipticity
    x, y, radius = ellipse.x - base.x, ellipse.y - base.y, ellipse.radius - base.radius
    return np.array([x, y, radius, second.real, second.imag])


def _coverage(evidence: PolarEvidence, base: Ellipse, ellipse: Ellipse) -> float:
    """Share of the visible rim with an edge along an ellipse, in evidence unrolled round `base`."""
    edge, shown = edges_along(evidence, _difference(base, ellipse))
    return float(edge.sum()) / max(int(np.count_nonzero(shown)), 1)


def _shown(evidence: PolarEvidence, base: Circle, ellipse: Ellipse, bulge: FloatArray) -> BoolArray:
    """Angles (A,) at which, or beside which, an edge lies along the outline."""
    radii = np.hypot(*(ellipse.points(evidence.angles_rad) - np.array([base.x, base.y])).T)
    column = np.abs(evidence.offsets_px[None] - (radii - base.radius - bulge)[:, None]).argmin(axis=1)
    edge = evidence.strength[np.arange(ANGLES), column] > 0.3
    return np.asarray(edge | np.roll(edge, 1) | np.roll(edge, -1))


def _along_edges(
    field: EdgeField, ellipse: Ellipse, shape: RimShape, window_px: float
) -> tuple[Ellipse, FloatArray] | None:
    """A robust curve through the edges within a window of an ellipse, and the edge points (N, 2) it rests on.

    The window closes in round the curve; at every angle the strongest edge in it counts. None where there are too few.
    """
    angles = full_turn(RIM_ANGLES)
    scale = float(field.scale.mean())
    window = window_px
    points = np.zeros((0, 2))
    for _ in range(8):
        offset, weight = _nearest_edges(field, ellipse, angles, window)
        there = weight > 0.0
        if there.sum() < ENOUGH_ANGLES / 2:
            return None
        basis = shape.basis(ellipse, angles)
        change: FloatArray = np.zeros(basis.shape[1])
        for _ in range(10):
            residual = offset - basis @ change
            trust = np.sqrt(np.where(there, weight, 0.0) / (1.0 + (residual / (0.4 * window)) ** 2) ** 2)
            change = np.linalg.lstsq(basis * trust[:, None], offset * trust, rcond=None)[0]
        residual = offset - basis @ change
        near = there & (np.abs(residual) < window)
        radius = ellipse.radius_at(angles) + offset
        direction = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        points = (np.array([ellipse.x, ellipse.y]) + radius[:, None] * direction)[near]
        ellipse = shape.changed(ellipse, change)
        # A ball is not quite round, and its rim not always sharp: the window stays as wide as the edges scatter.
        scatter = 1.4826 * float(np.median(np.abs(residual[near]))) if near.any() else 0.0
        closed = max(1.5 / scale, SCATTER * scatter)
        if window <= closed:
            break
        window = max(closed, 0.6 * window)
    return ellipse, points


def _nearest_edges(
    field: EdgeField, ellipse: Ellipse, angles: FloatArray, window_px: float
) -> tuple[FloatArray, FloatArray]:
    """Offset (A,) from the ellipse of the strongest edge along it, the nearer the better, and its weight, 0 without."""
    import cv2

    scale = float(field.scale.mean())
    steps = int(np.ceil(3.0 * window_px * scale)) + 2
    offsets = np.arange(-steps, steps + 1) / (2.0 * scale)
    radius = ellipse.radius_at(angles)[:, None] + offsets
    cosine, sine = np.cos(angles)[:, None], np.sin(angles)[:, None]
    map_x = ((ellipse.x + cosine * radius - field.corner_px[0]) * field.scale[0] - 0.5).astype(np.float32)
    map_y = ((ellipse.y + sine * radius - field.corner_px[1]) * field.scale[1] - 0.5).astype(np.float32)
    x, y = (cv2.remap(one, map_x, map_y, cv2.INTER_LINEAR) for one in (field.x, field.y))
    radial = np.abs(x * cosine + y * sine)
    across = np.abs(y * cosine - x * sine)
    radial = np.where(across < 0.5 * radial, radial, 0.0)
    middle = radial[:, 1:-1]
    peak = (middle >= radial[:, :-2]) & (middle > radial[:, 2:]) & (middle > 0.004)
    around = radial.mean(axis=1, keepdims=True)
    relative = np.minimum(middle / (1.5 * around + 0.012), 1.0)
    value = np.where(peak, relative * np.exp(-0.5 * (offsets[1:-1] / (0.6 * window_px)) ** 2), 0.0)
    best = value.argmax(axis=1)
    row = np.arange(len(angles))
    before, here, after = (radial[row, best + shift] for shift in (0, 1, 2))
    curvature = np.maximum(2.0 * here - before - after, 1e-9)
    part = np.clip(0.5 * (after - before) / curvature, -0.5, 0.5)
    weight = np.where(value[row, best] > 0.0, relative[row, best], 0.0)
    return offsets[best + 1] + part / (2.0 * scale), weight


def _rim_of(ellipse: Ellipse, points: FloatArray, shape: RimShape, coverage: float, common_px: float) -> Rim:
    """The least-squares outline through points, with its errors; `common_px` is what all may be out by together."""
    ellipse, used = shape.fitted(ellipse, points)
    points = points[used]
    angle, offset = ellipse.offsets(points)
    order = np.argsort(angle)
    points, angle, offset = points[order], angle[order], offset[order]
    basis = shape.basis(ellipse, angle)
    freedom = max(len(points) - basis.shape[1], 1)
    spread = float((offset**2).sum()) / freedom * correlated(offset)
    covariance = spread * np.linalg.pinv(basis.T @ basis)
    centre = float(np.sqrt(max(covariance[0, 0], covariance[1, 1]) + 0.25 * common_px**2))
    radius = float(np.sqrt(covariance[2, 2] + common_px**2))
    rms = float(np.sqrt(np.mean(offset**2)))
    return Rim(ellipse, points, rms, coverage, (centre, radius))


# ---------------------------------------------------------------- profiles across the rim


def _refined(
    photographs: Sequence[Photograph],
    shifts_px: Sequence[FloatArray],
    rim: Rim,
    shape: RimShape,
    shown: BoolArray,
) -> Rim:
    """The rim fitted by its profiles at growing sizes, as far as they tell more than the edges did."""
    angles = full_turn(RIM_ANGLES)
    usable = np.interp(angles, full_turn(ANGLES), shown.astype(float), period=2.0 * np.pi) > 0.5
    developed = any(one.display_referred for one in photographs)
    enough = ENOUGH_DEVELOPED_ANGLES if developed else ENOUGH_ANGLES
    choice: Sequence[RimModel] = rim_models(developed)
    for level in FINE_RADII_PX:
        scale = min(1.0, level / rim.ellipse.radius)
        pictures = [
            rim_picture(one, shift, rim.ellipse, scale, 16.0 / scale)
            for one, shift in zip(photographs, shifts_px, strict=True)
        ]
        models = choice
        for _ in range(REPEATS):
            data = profiles(pictures, rim.ellipse, angles, usable)
            fitted = misfits(data, models)
            if fitted is None:
                return rim
            models = [fitted[1]]
            found, good = _robust_places(fitted[0], shape.basis(rim.ellipse, angles))
            if good.sum() < enough:
                return rim
            radius = rim.ellipse.radius_at(angles) + found / scale
            points = np.array([rim.ellipse.x, rim.ellipse.y]) + radius[:, None] * np.stack(
                [np.cos(angles), np.sin(angles)], axis=-1
            )
            common = (CUSP_ERROR_PX if models[0].terms == CUSP else STEP_ERROR_PX) / scale
            better = _rim_of(rim.ellipse, points[good], shape, rim.coverage, common)
            moved = _distance(better.ellipse, rim.ellipse) * scale
            if moved > BELIEVED_PX:
                return rim
            rim = better
            if moved < SETTLED_PX:
                break
        if models[0].blur_px >= BLURRED_PX or scale == 1.0:
            break  # a larger picture would not be sharper
    return rim


def _distance(one: Ellipse, other: Ellipse) -> float:
    return max(abs(one.x - other.x), abs(one.y - other.y), abs(one.radius - other.radius))


def _robust_places(misfit: FloatArray, shape: FloatArray) -> tuple[FloatArray, BoolArray]:
    """The rim's place (A,) at each angle by misfits (A, T), and which lie near the curve with a shape (A, n) they make."""
    tried = places()
    bounded = np.minimum(misfit, 9.0)
    change: FloatArray = np.zeros(shape.shape[1])
    change[2] = tried[int(bounded.sum(axis=0).argmin())]
    window = 2.0
    index = np.arange(len(misfit))
    found, weight = np.zeros(len(misfit)), np.zeros(len(misfit))
    for _ in range(12):
        curve = shape @ change
        near = np.abs(tried[None] - curve[:, None]) < window
        place = np.clip(np.where(near, bounded, np.inf).argmin(axis=1), 1, len(tried) - 2)
        before, here, after = (misfit[index, place + shift] for shift in (-1, 0, 1))
        curvature = np.maximum(before - 2.0 * here + after, 1e-9)
        found = tried[place] + np.clip(0.5 * (before - after) / curvature, -1.0, 1.0) * SEARCH_STEP_PX
        residual = found - curve
        weight = np.minimum(curvature / SEARCH_STEP_PX**2, 50.0)
        weight *= (bounded[index, place] < 4.0) & (np.abs(residual) < window)
        weight /= 1.0 + 0.25 * residual**2 * weight
        root = np.sqrt(weight)
        change = np.linalg.lstsq(shape * root[:, None], found * root, rcond=None)[0]
        window = max(0.8, 0.8 * window)
    return found, np.asarray(weight > 0.05 * max(float(weight.max()), 1e-9))

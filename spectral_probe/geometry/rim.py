"""The rim of a mirrored ball to a small part of a pixel, from an outline known to a hundredth of its radius.

Just inside the rim a mirrored ball shows, squeezed ever tighter, what lies behind it: a depth of delta pixels
inside the rim of radius r turns the line of sight by about 2 sqrt(2 delta / r). So the picture has, seen
along a radius, no step at the rim but a cusp, a polynomial in sqrt(delta), and the steepest place of its
blurred image lies up to a pixel *inside* the rim. Fitting that cusp, blurred, in place of a step takes the
error from 0.7 px to under 0.1 px. A dull, tarnished or lacquered rim does have a step; the picture itself
tells which model describes it. Pictures with sharpening and a tone curve (JPEG) are always fitted with a
step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..model import BoolArray, FloatArray, Photograph
from .circle_search import (
    ANGLES,
    Circle,
    PolarEvidence,
    best_circle,
    full_turn,
    harmonics,
    polar_evidence,
    shares_along,
    shrunk,
)

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

SIGNAL = 6.0
"""Variance along a profile, summed over the channels and over that of noise alone (3), from which it says something."""

BLURRED_SHARE = 0.8
BELIEVED_PX = 1.8
"""A fit that moves the outline further than this, in pixels of its picture, has followed something else."""

RIM_ANGLES = 360
ENOUGH_ANGLES, ENOUGH_DEVELOPED_ANGLES = 108, 144
"""So many of the 360 angles must speak for a fit, or the outline stays as it was; more of them where sharpening and
JPEG leave false edges."""

DEPTH_INSIDE_PX, DEPTH_OUTSIDE_PX, DEPTH_STEP_PX = 7.0, 6.0, 0.5
SEARCH_PX, SEARCH_STEP_PX = 3.0, 0.2
BLURS_PX = (0.5, 0.6, 0.75, 1.0, 1.5)

CUSP = ("constant", "outside", "root", "inside", "root cubed")
STEP = ("constant", "outside", "step", "inside")
STEP_ADVANTAGE = 0.6
"""A step is believed when its misfit is below this share of the cusp's: a real step beats the cusp by far."""


@dataclass(frozen=True)
class Ellipse:
    """An ellipse in pixels; `angle_rad` of the major axis from +x towards +y."""

    x: float
    y: float
    major: float
    minor: float
    angle_rad: float = 0.0

    @property
    def radius(self) -> float:
        """Mean of the semi-axes."""
        return 0.5 * (self.major + self.minor)

    def radius_at(self, angles_rad: FloatArray) -> FloatArray:
        """Distance of the ellipse from its centre in directions given in the image.

        Examples
        --------
        >>> Ellipse(0, 0, 4, 3).radius_at(np.array([0.0, np.pi / 2])).tolist()
        [4.0, 3.0]
        """
        across = self.minor * np.cos(angles_rad - self.angle_rad)
        along = self.major * np.sin(angles_rad - self.angle_rad)
        return np.asarray(self.major * self.minor / np.hypot(across, along))

    def moved(self, shift_px: FloatArray) -> Ellipse:
        """The ellipse elsewhere: `shift_px` (x, y) is added to its centre."""
        return replace(self, x=self.x + float(shift_px[0]), y=self.y + float(shift_px[1]))

    def changed(self, change: FloatArray) -> Ellipse:
        """The ellipse after small changes of x, y, radius and, where given, ellipticity (`harmonics`)."""
        x, y, radius = (float(value) for value in change[:3])
        second = 0.5 * (self.major - self.minor) * np.exp(2j * self.angle_rad)
        if len(change) > 3:
            second += complex(change[3], change[4])
        bulge = abs(second)
        mean = self.radius + radius
        return Ellipse(self.x + x, self.y + y, mean + bulge, mean - bulge, float(np.angle(second)) / 2.0)


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
    rim = _unrefined(ellipse, coverage, angles[usable])
    for level in FINE_RADII_PX:
        scale = min(1.0, level / rim.ellipse.radius)
        blur = 0.0
        for _ in range(REPEATS):
            refined = _refined(photographs, shifts_px, rim, scale, usable)
            if refined is None:
                return rim
            moved_px = _distance(refined[0].ellipse, rim.ellipse) * scale
            rim, blur = refined
            if moved_px < SETTLED_PX:
                break
        if blur >= BLURRED_PX or scale == 1.0:
            break  # a larger picture would not be sharper
    return rim


def _distance(one: Ellipse, other: Ellipse) -> float:
    return max(abs(one.x - other.x), abs(one.y - other.y), abs(one.radius - other.radius))


def _refined(
    photographs: Sequence[Photograph],
    shifts_px: Sequence[FloatArray],
    rim: Rim,
    scale: float,
    usable: BoolArray,
) -> tuple[Rim, float] | None:
    """The rim fitted in pictures scaled by `scale`, and their blur in their own pixels; None where nothing fits."""
    ellipse = rim.ellipse
    angles = full_turn(RIM_ANGLES)
    profiles = [
        _profiles(one, ellipse.moved(shift), scale, angles)
        for one, shift in zip(photographs, shifts_px, strict=True)
    ]
    # Sharpening and tone curves make halos at the rim that pass for the outer side of a cusp.
    developed = any(one.display_referred for one in photographs)
    model = _best_model(profiles, usable, (STEP,) if developed else (CUSP, STEP))
    if model is None:
        return None
    misfit, blur = model
    change, found, weight = _robust_fit(misfit, angles)
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


def _unrefined(ellipse: Ellipse, coverage: float, angles: FloatArray) -> Rim:
    """The outline as `approach` left it, good to about half a pixel of its picture."""
    if len(angles) < 24:
        angles = full_turn(RIM_ANGLES)
    direction = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    points = np.array([ellipse.x, ellipse.y]) + ellipse.radius_at(angles)[:, None] * direction
    return Rim(ellipse, points, max(0.5, 0.5 * ellipse.radius / 400.0), coverage)


@dataclass(frozen=True)
class _Profiles:
    """Radial profiles `values` (A, R, C), their noise `variance` (A, C), `usable` (A,) in the frame, unclipped."""

    values: FloatArray
    variance: FloatArray
    usable: BoolArray


def _depths() -> FloatArray:
    return np.arange(-DEPTH_INSIDE_PX, DEPTH_OUTSIDE_PX + 0.01, DEPTH_STEP_PX)


def _profiles(photograph: Photograph, ellipse: Ellipse, scale: float, angles: FloatArray) -> _Profiles:
    """Profiles across the rim in the picture scaled by `scale`, averaged along the rim between the angles."""
    import cv2

    height, width = photograph.pixels.shape[:2]
    reach = ellipse.major + 12.0 / scale
    left, top = (
        int(np.clip(c - reach, 0, side - 8)) for c, side in ((ellipse.x, width), (ellipse.y, height))
    )
    right = int(np.clip(ellipse.x + reach, left + 8, width))
    bottom = int(np.clip(ellipse.y + reach, top + 8, height))
    picture = shrunk(photograph.pixels[top:bottom, left:right], scale)
    clipped = shrunk(photograph.clipped[top:bottom, left:right].astype(np.float32), scale)
    scale_x, scale_y = picture.shape[1] / (right - left), picture.shape[0] / (bottom - top)
    values = np.zeros((len(angles), len(_depths()), 3))
    usable = np.ones(len(angles), bool)
    for part in (-1.0 / 3.0, 0.0, 1.0 / 3.0):
        turned = angles + part * (angles[1] - angles[0])
        radius = ellipse.radius_at(turned)[:, None] + _depths() / scale
        x = (ellipse.x + np.cos(turned)[:, None] * radius - left) * scale_x
        y = (ellipse.y + np.sin(turned)[:, None] * radius - top) * scale_y
        map_x, map_y = (x - 0.5).astype(np.float32), (y - 0.5).astype(np.float32)
        values += cv2.remap(picture, map_x, map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE) / 3.0
        usable &= ~(cv2.remap(clipped, map_x, map_y, cv2.INTER_LINEAR) > 0.0).any(axis=1)
        usable &= (
            (x >= 0.5) & (y >= 0.5) & (x <= picture.shape[1] - 0.5) & (y <= picture.shape[0] - 0.5)
        ).all(axis=1)
    return _Profiles(values, _noise(values.mean(axis=1), photograph), usable)


def _noise(level: FloatArray, photograph: Photograph) -> FloatArray:
    """Variance of values about a level: photon and read noise, a code's width, or a hundredth of radiance."""
    level = np.maximum(level, 0.0)
    if photograph.scene_referred_float:
        return (0.01 * level) ** 2 + 1e-8 * max(float(level.mean()), 1e-6) ** 2
    if photograph.display_referred:
        return (0.02 * level**0.58 + 2e-4) ** 2
    return level / 30000.0 + (3e-4) ** 2


def _shapes(terms: Sequence[str], blur_px: float, places_px: FloatArray) -> FloatArray:
    """What a profile may be made of, blurred, with the rim at each of the places: (T, R, terms)."""
    step = 0.05
    line = np.arange(-40.0, 40.0, step)
    kernel = np.exp(-0.5 * (np.arange(-5.0 * blur_px, 5.0 * blur_px + step / 2, step) / blur_px) ** 2)
    inside = np.maximum(-line, 0.0)
    sharp = {
        "constant": np.ones_like(line),
        "outside": np.maximum(line, 0.0),
        "step": (line < 0.0).astype(float),
        "root": np.sqrt(inside),
        "inside": inside,
        "root cubed": inside**1.5,
    }
    at = _depths()[None] - places_px[:, None]
    blurred = [np.convolve(sharp[term], kernel / kernel.sum(), mode="same") for term in terms]
    return np.stack([np.interp(at, line, shape) for shape in blurred], axis=-1)


def _places() -> FloatArray:
    return np.arange(-SEARCH_PX, SEARCH_PX + 0.01, SEARCH_STEP_PX)


def _best_model(
    profiles: Sequence[_Profiles], usable: BoolArray, models: Sequence[Sequence[str]]
) -> tuple[FloatArray, float] | None:
    """Misfit (A, T) of the rim at each place by the best model, in units of the noise shown, and that model's blur.

    Angles that tell nothing have no misfit at all. None where too few tell anything.
    """
    best: tuple[float, FloatArray, float] | None = None
    for terms in models:
        handicap = STEP_ADVANTAGE if terms is CUSP else 1.0
        for blur in BLURS_PX:
            squares, freedom = _squares(profiles, usable, _shapes(terms, blur, _places()))
            least = squares.min(axis=1)
            told = freedom > 0
            if told.sum() < ENOUGH_ANGLES:
                return None
            excess = least / np.maximum(freedom, 1)
            typical = float(np.median(excess[told]))
            if best is None or handicap * typical < best[0]:
                # Where no model fits, something else crosses the rim (a stand, a reflected edge): it does
                # not count.
                trusted = told & (excess < 2.5 * max(typical, 1.0))
                scaled = (squares - least[:, None]) / np.maximum(np.maximum(excess, typical), 1.0)[:, None]
                best = handicap * typical, np.where(trusted[:, None], scaled, 0.0), blur
    return None if best is None else best[1:]


def _squares(
    profiles: Sequence[_Profiles], usable: BoolArray, shapes: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Sum of squares (A, T) left by the best combination of shapes, over noise; degrees of freedom (A,)."""
    basis = np.linalg.qr(shapes)[0]
    squares = np.zeros((len(usable), len(shapes)))
    freedom = np.zeros(len(usable))
    independent = DEPTH_STEP_PX  # samples closer than a pixel share their noise
    for one in profiles:
        chosen = one.usable & usable
        if not chosen.any():
            continue
        values = one.values[chosen] / np.sqrt(one.variance[chosen])[:, None, :]
        # Where a photograph shows nothing but noise it must not dilute what the others say.
        tells = values.var(axis=1).sum(axis=-1) > SIGNAL
        chosen[chosen] = tells
        values = values[tells]
        explained = np.einsum("trk,arc->atck", basis, values, optimize=True)
        left = (values**2).sum(axis=(1, 2))[:, None] - (explained**2).sum(axis=(2, 3))
        squares[chosen] += left * independent
        freedom[chosen] += 3.0 * (values.shape[1] * independent - shapes.shape[-1])
    return squares, freedom


def _robust_fit(misfit: FloatArray, angles: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Change of (x, y, radius) that the misfits (A, T) ask for, the place found at each angle, its weight."""
    places = _places()
    bounded = np.minimum(misfit, 9.0)
    shape = harmonics(angles, 3)
    change = np.array([0.0, 0.0, places[int(bounded.sum(axis=0).argmin())]])
    window = 2.0
    index = np.arange(len(angles))
    found = np.zeros(len(angles))
    weight = np.zeros(len(angles))
    for _ in range(12):
        curve = shape @ change
        near = np.abs(places[None] - curve[:, None]) < window
        place = np.clip(np.where(near, bounded, np.inf).argmin(axis=1), 1, len(places) - 2)
        before, here, after = (misfit[index, place + shift] for shift in (-1, 0, 1))
        curvature = np.maximum(before - 2.0 * here + after, 1e-9)
        found = places[place] + np.clip(0.5 * (before - after) / curvature, -1.0, 1.0) * SEARCH_STEP_PX
        residual = found - curve
        weight = np.minimum(curvature / SEARCH_STEP_PX**2, 50.0)
        weight *= (bounded[index, place] < 4.0) & (np.abs(residual) < window)
        weight /= 1.0 + 0.25 * residual**2 * weight
        root = np.sqrt(weight)
        change = np.linalg.lstsq(shape * root[:, None], found * root, rcond=None)[0]
        window = max(0.8, 0.8 * window)
    return change, found, weight

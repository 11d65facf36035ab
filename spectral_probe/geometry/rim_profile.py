"""Profiles across a mirrored ball's rim, and models of them: a cusp, or a step.

Just inside the rim a mirrored ball shows, squeezed ever tighter, what lies behind it: a depth of delta pixels
inside the rim of radius r turns the line of sight by about 2 sqrt(2 delta / r). So the picture has, seen
along a radius, no step at the rim but a cusp, a polynomial in sqrt(delta), and the steepest place of its
blurred image lies up to a pixel *inside* the rim. Fitting that cusp, blurred, in place of a step takes the
error from 0.7 px to under 0.1 px. A dull, tarnished or lacquered rim does have a step; the picture itself
tells which model describes it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..model import BoolArray, FloatArray, Photograph
from .edges import shrunk
from .ellipse import Ellipse
from .unrolled import harmonics

SIGNAL = 6.0
"""Variance along a profile, summed over the channels and over that of noise alone (3), from which it says something."""

ENOUGH_ANGLES = 108
"""So many of the 360 angles must speak for a fit, or the outline stays as it was."""

DEPTH_INSIDE_PX, DEPTH_OUTSIDE_PX, DEPTH_STEP_PX = 7.0, 6.0, 0.5
SEARCH_PX, SEARCH_STEP_PX = 3.0, 0.2
BLURS_PX = (0.5, 0.6, 0.75, 1.0, 1.5)

CUSP = ("constant", "outside", "root", "inside", "root cubed")
STEP = ("constant", "outside", "step", "inside")
DIMMED_CUSP = ("constant", "outside", "step", "root", "inside")
"""What profiles are made of: a perfect mirror's, a dull ball's, and a mirror's that dims everything by the same share."""

STEP_ADVANTAGE = 0.6
"""A step is believed when its misfit is below this share of the cusp's: a real step beats the cusp by far."""


@dataclass(frozen=True)
class Profiles:
    """Radial profiles `values` (A, R, C), their noise `variance` (A, C), `usable` (A,) in the frame, unclipped."""

    values: FloatArray
    variance: FloatArray
    usable: BoolArray


def _depths() -> FloatArray:
    return np.arange(-DEPTH_INSIDE_PX, DEPTH_OUTSIDE_PX + 0.01, DEPTH_STEP_PX)


def profiles_of(photograph: Photograph, ellipse: Ellipse, scale: float, angles: FloatArray) -> Profiles:
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
    return Profiles(values, _noise(values.mean(axis=1), photograph), usable)


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


def best_model(
    profiles: Sequence[Profiles], usable: BoolArray, models: Sequence[Sequence[str]]
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
    profiles: Sequence[Profiles], usable: BoolArray, shapes: FloatArray
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


def robust_fit(misfit: FloatArray, angles: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
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

"""Profiles across the rim of a mirrored ball, and what the rim may look like in them.

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
from dataclasses import dataclass

import cv2
import numpy as np

from ..model import BoolArray, FloatArray, Photograph
from .edges import shrunk
from .ellipse import Ellipse

SIGNAL = 6.0
"""Variance along a profile, summed over the channels and over that of noise alone (3), from which it says something."""

ENOUGH_ANGLES, ENOUGH_DEVELOPED_ANGLES = 72, 144
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
class RimPicture:
    """The part of a photograph round the rim, scaled down, and where it lies in the bracket's first frame."""

    pixels: FloatArray
    clipped: FloatArray
    corner_px: FloatArray
    scale: FloatArray
    photograph: Photograph


@dataclass(frozen=True)
class Profiles:
    """Radial profiles `values` (A, R, C) over their noise, 0 at angles that tell nothing; `telling` (A,) channels C."""

    values: FloatArray
    telling: FloatArray


def rim_picture(
    photograph: Photograph, shift_px: FloatArray, ellipse: Ellipse, scale: float, margin_px: float
) -> RimPicture:
    """Cut out and shrink what is needed for profiles round an ellipse of the first frame and up to a margin off it."""
    height, width = photograph.clipped.shape
    x, y = ellipse.x + float(shift_px[0]), ellipse.y + float(shift_px[1])
    reach = ellipse.major + margin_px
    left, top = (int(np.clip(c - reach, 0, side - 8)) for c, side in ((x, width), (y, height)))
    right, bottom = int(np.clip(x + reach, left + 8, width)), int(np.clip(y + reach, top + 8, height))
    picture = shrunk(photograph.pixels[top:bottom, left:right], scale)
    clipped = shrunk(photograph.clipped[top:bottom, left:right].astype(np.float32), scale)
    scales = np.array([picture.shape[1] / (right - left), picture.shape[0] / (bottom - top)])
    corner = np.array([left, top]) - np.asarray(shift_px, float)
    return RimPicture(picture, clipped, corner, scales, photograph)


def profiles(
    pictures: Sequence[RimPicture], ellipse: Ellipse, angles: FloatArray, usable: BoolArray
) -> Profiles:
    """Profiles across the rim in all pictures (side by side as channels), averaged along the rim between the angles."""
    values = np.zeros((len(angles), len(_depths()), 3 * len(pictures)), np.float32)
    telling = np.zeros(len(angles))
    for index, picture in enumerate(pictures):
        own, seen = _sampled(picture, ellipse, angles)
        own = own / np.sqrt(_noise(own.mean(axis=1), picture.photograph))[:, None, :]
        # Where a photograph shows nothing but noise it must not dilute what the others say.
        seen &= usable & (own.var(axis=1).sum(axis=-1) > SIGNAL)
        values[..., 3 * index : 3 * index + 3] = np.where(seen[:, None, None], own, 0.0)
        telling += 3.0 * seen
    return Profiles(values, telling)


def _depths() -> FloatArray:
    return np.arange(-DEPTH_INSIDE_PX, DEPTH_OUTSIDE_PX + 0.01, DEPTH_STEP_PX)


def _sampled(picture: RimPicture, ellipse: Ellipse, angles: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Profiles (A, R, 3) of one picture, and whether (A,) they lie in the frame and are nowhere clipped."""
    rows, columns = picture.pixels.shape[:2]
    values = np.zeros((len(angles), len(_depths()), 3))
    seen = np.ones(len(angles), bool)
    scale = float(picture.scale.mean())
    for part in (-1.0 / 3.0, 0.0, 1.0 / 3.0):
        turned = angles + part * (angles[1] - angles[0])
        radius = ellipse.radius_at(turned)[:, None] + _depths() / scale
        x = (ellipse.x + np.cos(turned)[:, None] * radius - picture.corner_px[0]) * picture.scale[0]
        y = (ellipse.y + np.sin(turned)[:, None] * radius - picture.corner_px[1]) * picture.scale[1]
        maps = (x - 0.5).astype(np.float32), (y - 0.5).astype(np.float32)
        values += cv2.remap(picture.pixels, *maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE) / 3.0
        seen &= ~(cv2.remap(picture.clipped, *maps, cv2.INTER_LINEAR) > 0.0).any(axis=1)
        seen &= ((x >= 0.5) & (y >= 0.5) & (x <= columns - 0.5) & (y <= rows - 0.5)).all(axis=1)
    return values, seen


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
    line = np.arange(-12.0, 12.0, step)
    kernel = np.exp(-0.5 * (np.arange(-5.0 * blur_px, 5.0 * blur_px + step / 2, step) / blur_px) ** 2)
    wide = np.arange(-24.0, 24.0, step)
    inside = np.maximum(-wide, 0.0)
    sharp = {
        "constant": np.ones_like(wide),
        "outside": np.maximum(wide, 0.0),
        "step": (wide < 0.0).astype(float),
        "root": np.sqrt(inside),
        "inside": inside,
        "root cubed": inside**1.5,
    }
    middle = np.abs(wide) < line[-1] + 0.5 * step
    at = _depths()[None] - places_px[:, None]
    blurred = [np.convolve(sharp[term], kernel / kernel.sum(), mode="same") for term in terms]
    return np.stack([np.interp(at, wide[middle], shape[middle]) for shape in blurred], axis=-1)


def places() -> FloatArray:
    """Places (T,) of the rim that are tried, in pixels outside the outline."""
    return np.arange(-SEARCH_PX, SEARCH_PX + 0.01, SEARCH_STEP_PX)


@dataclass(frozen=True)
class RimModel:
    """What the rim looks like: the terms of its profile and its blur; `basis` (T, R, terms) is orthonormal."""

    terms: tuple[str, ...]
    blur_px: float
    basis: FloatArray


def rim_models(developed: bool) -> list[RimModel]:
    """The models to choose from.

    Sharpening and tone curves make halos at the rim that pass for the outer side of a cusp, so developed pictures
    (JPEG) are fitted with a step only.
    """
    kinds = (STEP,) if developed else (CUSP, STEP)
    return [
        RimModel(terms, blur, np.linalg.qr(_shapes(terms, blur, places()))[0])
        for terms in kinds
        for blur in BLURS_PX
    ]


def misfits(data: Profiles, models: Sequence[RimModel]) -> tuple[FloatArray, RimModel] | None:
    """Misfit (A, T) of the rim at each place by the best model, in units of the noise shown, and that model.

    Angles that tell nothing have no misfit at all. None where too few tell anything.
    """
    told = data.telling > 0
    if told.sum() < ENOUGH_ANGLES:
        return None
    best: tuple[float, FloatArray, RimModel] | None = None
    for model in models:
        handicap = STEP_ADVANTAGE if model.terms == CUSP else 1.0
        squares, freedom = _squares(data, model.basis)
        least = squares.min(axis=1)
        excess = least / np.maximum(freedom, 1)
        typical = float(np.median(excess[told]))
        if best is None or handicap * typical < best[0]:
            # Where no model fits, something else crosses the rim (a stand, a reflected edge): it does not count.
            trusted = told & (excess < 2.5 * max(typical, 1.0))
            scaled = (squares - least[:, None]) / np.maximum(np.maximum(excess, typical), 1.0)[:, None]
            best = handicap * typical, np.where(trusted[:, None], scaled, 0.0), model
    return None if best is None else best[1:]


def _squares(data: Profiles, basis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Sum of squares (A, T) left by the best combination of shapes, over noise; degrees of freedom (A,)."""
    values = data.values  # (A, R, C)
    count, depths, terms = basis.shape
    flat = basis.transpose(0, 2, 1).reshape(count * terms, depths).astype(np.float32)
    explained = np.matmul(flat, values)  # (A, T * terms, C)
    np.square(explained, out=explained)
    sums = explained.sum(axis=2).reshape(len(values), count, terms).sum(axis=2)
    left = np.maximum((values**2).sum(axis=(1, 2))[:, None] - sums, 0.0)
    independent = DEPTH_STEP_PX  # samples closer than a pixel share their noise
    return left * independent, data.telling * (depths * independent - terms)

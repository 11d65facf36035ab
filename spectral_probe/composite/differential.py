"""Differential rendering (Debevec 1998): virtual objects, and what they do to the light, put into a photograph.

Everything is premultiplied and linear, in one colour space; nothing here knows which.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from ..composite_model import ObjectCoverage
from ..errors import RenderError
from ..model import BoolArray, FloatArray
from .difference_filter import smooth_difference

FADE = (0.004, 0.012)
"""Change of the plate, relative to it, below which it is left as it is, and above which it is made in full. One code of an 8-bit
picture is 0.009 to 0.02 of a mid-tone: what is left out is a third of a code, and what is half left out less than one."""

FADE_ERRORS = (1.0, 3.0)
"""The same in standard errors of the change: what cannot be told from noise is not done to the plate."""

DARKEST_SHARE = 0.5
"""A shadow takes from the plate what it takes from the render of the ground, as long as it leaves at least this share of what the
same proportion would leave. Of a plate that is darker than that render it would take too much, at last more than there is, and of
one channel before the others: there it goes over into the proportion."""

SPECK_PX = 16
"""Changed areas of fewer pixels, away from any object, are noise."""

_WHOLE = 0.999
"""Share of a pixel from which it counts as covered wholly."""

_BESIDE_PX = 7

_DARK = 2e-3
"""Share of the plate's brightness (its 99th percentile) that counts as black: changes are told against no less."""


@dataclass(frozen=True)
class Composite:
    """A photograph with virtual objects in it.

    Parameters
    ----------
    pixels
        (H, W, 3) float32 linear; where nothing was done, the plate's bit for bit.
    difference
        (H, W, 3) what the objects changed on the ground, as it was added to the plate; zero elsewhere.
    weight
        (H, W) in 0..1: how much of the difference was made.
    changed
        (H, W) bool, pixels that are not the plate's.
    limited
        (H, W) bool, pixels in which a shadow was held back (`DARKEST_SHARE`).
    """

    pixels: FloatArray
    difference: FloatArray
    weight: FloatArray
    changed: BoolArray
    limited: BoolArray


def differential(
    plate: FloatArray,
    with_: FloatArray,
    without: FloatArray | None,
    coverage: ObjectCoverage,
    *,
    without_alpha: FloatArray | None = None,
    denoised: FloatArray | None = None,
    smooth: bool = True,
) -> Composite:
    """Compose a photograph with renders of its scene with and without the virtual objects.

    Where objects cover a share a of a pixel, and beside them the share g of its ground is seen, the composite is
    plate (1 - a) + with - g without: the plate where no object is, what the objects do to the ground on top of it, and the
    objects themselves [1]_. Away from the objects the difference with - without is smoothed, and fades to nothing where it would
    not be seen.

    Parameters
    ----------
    plate
        (H, W, 3) the photograph, linear.
    with_
        (H, W, 3) the render with the objects, in the unit of the plate, premultiplied, nothing behind.
    without
        (H, W, 3) the same without the objects; None where nothing real is in the scene.
    coverage
        What each pixel shows.
    without_alpha
        (H, W) how much of each pixel the ground covers without the objects; None where all that the objects hide is ground.
    denoised
        (H, W, 3) `with_` without its noise, from which pixels are then taken that objects cover, also in part. The ground that
        is subtracted from those has no noise either.
    smooth
        Whether noise is taken out of the difference.

    Returns
    -------
    Composite

    Raises
    ------
    RenderError
        If the images differ in size or hold values that are not numbers.

    References
    ----------
    .. [1] Debevec, P. (1998). Rendering Synthetic Objects into Real Scenes. SIGGRAPH 98. doi:10.1145/280814.280864

    Examples
    --------
    A grey pixel beside an object, half of it in the object's shadow, and one that the object covers by half:

    >>> plate = np.full((1, 2, 3), 0.5, np.float32)
    >>> cover = np.array([[0.0, 0.5]], np.float32)
    >>> objects = ObjectCoverage({"ball": cover}, cover, 1 - cover)
    >>> with_ = np.stack([np.full((1, 3), 0.3), np.full((1, 3), 0.5 * 0.8 + 0.5 * 0.3)], 1).astype(np.float32)
    >>> without = np.full((1, 2, 3), 0.6, np.float32)
    >>> composite = differential(plate, with_, without, objects, smooth=False)
    >>> composite.pixels[0, :, 0].astype(float).round(3).tolist()  # 0.5 - 0.3; 0.5 * 0.8 + 0.5 * (0.5 - 0.3)
    [0.2, 0.5]
    """
    plate, with_ = _checked("plate", plate, plate), _checked("render", with_, plate)
    covered = np.clip(np.nan_to_num(np.asarray(coverage.coverage, np.float32)), 0, 1)
    ground = np.clip(np.nan_to_num(np.asarray(coverage.ground, np.float32)), 0, 1)
    if covered.shape != plate.shape[:2]:
        raise RenderError(_sizes("objects.exr", covered, plate))
    touched = covered > 0
    shown = with_ if denoised is None else _checked("denoised render", denoised, plate)
    pixels = plate.copy()
    if without is None:
        difference, weight = np.zeros_like(plate), np.zeros(covered.shape, np.float32)
        limited: BoolArray = np.zeros(covered.shape, bool)
        under: FloatArray = np.zeros_like(plate)
    else:
        without = _checked("render without the objects", without, plate)
        floor = (ground > 0) & ~touched
        difference, weight, alone = _on_ground(plate, with_, without, floor, smooth=smooth)
        weight[_specks(weight > 0, touched)] = 0
        steady = alone  # the ground itself where not smoothed
        if smooth and denoised is None:
            steady = _steadied(without, alone, difference, floor)
        shaded, limited = _shaded(plate, difference, alone)
        limited &= weight > 0
        np.copyto(pixels, shaded, where=(weight > 0)[..., None])
        difference = np.where((weight > 0)[..., None], pixels - plate, np.float32(0))
        whole = (covered + ground if without_alpha is None else without_alpha) > _WHOLE
        under = np.where(whole[..., None], steady, without)
        under *= _seen_beside(covered, ground, without_alpha)[..., None]
    mixed = plate * (1 - covered)[..., None] + shown - under
    # A plate's own noise about black may be negative; nothing else may.
    np.copyto(pixels, np.maximum(mixed, np.minimum(plate, 0)), where=touched[..., None])
    return Composite(pixels, difference, weight, (pixels != plate).any(-1), limited)


def _on_ground(
    plate: FloatArray, with_: FloatArray, without: FloatArray, floor: BoolArray, *, smooth: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Where there is ground and no object: the difference (H, W, 3) to be made, its share (H, W) of the whole, and the ground."""
    raw: FloatArray = np.where(floor[..., None], with_ - without, np.float32(0))
    if not raw.any():
        return raw, np.zeros(floor.shape, np.float32), without
    if not smooth:
        return raw, (raw != 0).any(-1).astype(np.float32), without
    found = smooth_difference(raw, without, plate, floor)
    dark = np.maximum(_DARK * np.percentile(plate, 99, axis=(0, 1)), 1e-12).astype(np.float32)
    against = np.maximum(plate, dark)
    change = (np.abs(found.difference) / against).max(-1)
    error = (found.standard_error / against).max(-1)
    low, high = (np.maximum(limit, errors * error) for limit, errors in zip(FADE, FADE_ERRORS, strict=True))
    part = np.clip((change - low) / (high - low), 0, 1)
    weight = np.asarray(part * part * (3 - 2 * part), np.float32) * floor
    return found.difference * weight[..., None], weight, found.ground


def _specks(changed: BoolArray, touched: BoolArray) -> BoolArray:
    """Changed areas (H, W) of a few pixels with no object beside them: what objects do to the ground is wider."""
    _, labels, statistics, _ = cv2.connectedComponentsWithStats(
        np.asarray(changed | touched, np.uint8), connectivity=8
    )
    small = statistics[:, cv2.CC_STAT_AREA] < SPECK_PX
    small[np.unique(labels[touched])] = False
    return np.asarray(small[labels] & changed)


def _shaded(plate: FloatArray, difference: FloatArray, without: FloatArray) -> tuple[FloatArray, BoolArray]:
    """The plate with the difference, and where (H, W) it is more of a proportion (see `DARKEST_SHARE`)."""
    left = np.clip(1 + np.divide(difference, without, out=np.zeros_like(plate), where=without > 0), 0, 1)
    changed, proportion = plate + difference, np.maximum(plate, 0) * left
    darkened = (difference < 0) & (plate > 0)
    share = np.divide(changed, proportion, out=np.zeros_like(plate), where=proportion > 0)
    least = np.where(darkened, share, np.float32(1)).min(-1, keepdims=True)
    part = np.clip(1 - least / np.float32(DARKEST_SHARE), 0, 1)
    proportion += np.maximum(difference, 0)  # what a channel gains is added all the same
    return changed + part * (proportion - changed), part[..., 0] > 0


def _steadied(without: FloatArray, alone: FloatArray, difference: FloatArray, floor: BoolArray) -> FloatArray:
    """The ground (H, W, 3) at the objects' edges, with as much of its noise as the render with the objects shares.

    In the open both renders have the same noise, which must cancel; in the shadow of an object hardly any is common, and the
    ground's own would only add to it. So its share is that of the light which the objects leave, as seen on the ground beside.
    """
    left = np.clip(1 + np.divide(difference, alone, out=np.zeros_like(alone), where=alone > 0), 0, 1)
    side = (_BESIDE_PX, _BESIDE_PX)
    beside = cv2.blur(np.asarray(floor, np.float32), side)[..., None]
    near = cv2.blur(np.asarray(left * floor[..., None], np.float32), side)
    shared = np.where(beside > 0, near / np.maximum(beside, 1e-6), np.float32(1))
    return np.asarray(alone + shared * (without - alone), np.float32)


def _seen_beside(covered: FloatArray, ground: FloatArray, without_alpha: FloatArray | None) -> FloatArray:
    """Share (H, W) of the ground that is still seen beside the objects: 1 where there are none."""
    alone = covered + ground if without_alpha is None else np.asarray(without_alpha, np.float32)
    share = np.divide(ground, alone, out=np.zeros_like(ground), where=alone > 0)
    return np.where(covered > 0, np.clip(share, 0, 1), np.float32(1))


def _checked(name: str, image: FloatArray, plate: FloatArray) -> FloatArray:
    image = np.asarray(image, np.float32)
    if image.shape != plate.shape:
        raise RenderError(_sizes(f"The {name}", image, plate))
    if not np.isfinite(image).all():
        raise RenderError(f"The {name} holds values that are not numbers. Make it again.")
    return image


def _sizes(name: str, image: FloatArray, plate: FloatArray) -> str:
    return (
        f"{name} has {image.shape[1]} x {image.shape[0]} pixels, the plate {plate.shape[1]} x {plate.shape[0]}. "
        "Render at the size of the plate."
    )

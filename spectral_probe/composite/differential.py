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
from .difference_filter import smooth_change

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

TEXTURE_SHARE = 0.2
"""Side of the square means, applied twice, that tell texture from light, in parts of the picture's shorter side."""

_BRIGHTEST = 3.0
"""As many times as bright as its surroundings the photograph's ground may be and count as ground. What is brighter, and is not so
in the render, is a reflection, or a lamp: an object that shades the ground does not dim it."""

_FAINT = 1e-4
"""Share of the ground's mean that is added wherever a proportion is taken: of no light there is none."""

_FILL_PX = (3, 7, 15)
"""Sides of the square means by which the ground's change is carried on under the objects' edges."""

_CALM_PX = 5
"""Side of the square means that stand for the denoised ground under objects' edges."""

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
    objects themselves [1]_. The difference on the ground is smoothed, takes the photograph's texture (see the notes), and fades
    to nothing where it would not be seen.

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

    Notes
    -----
    with - without is the light that the objects take or give, times the reflectance of the *render*. It is right where
    plate and render differ by light: what a lamp unknown to the render adds stays. Where they differ by reflectance it is off by
    their ratio, and plate with / without is right, whatever the render's reflectance. Nothing in a pixel tells which; over the
    picture, what changes from pixel to pixel is nearly always texture, and what changes slowly may be either. So what is added is
    level (with - without) / without: the proportion, times a level that has the plate's texture and the render's mean over
    `TEXTURE_SHARE` of the picture. It is Debevec's difference where the two differ in level alone, the plate in proportion where
    they differ in texture alone, and both where they agree, as with a ground whose reflectance was taken from the plate. Sharp
    edges of real light on the plate, of shadows above all, count as texture. Without `smooth` it is Debevec's difference, noise
    and all.

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
    seen = ground if without_alpha is None else np.minimum(ground, np.asarray(without_alpha, np.float32))
    if without is None:
        nothing = np.zeros_like(plate)
        unchanged = _Ground(nothing, nothing, nothing[..., 0], np.zeros(touched.shape, bool))
        return _composed(plate, shown, covered, unchanged)
    without = _checked("render without the objects", without, plate)
    alone = covered + ground if without_alpha is None else np.asarray(without_alpha, np.float32)
    share = _seen_beside(covered, ground, alone)[..., None]
    floor = (ground > 0) & ~touched
    if smooth:
        calm = without if denoised is None else _calm(without, alone)
        on_ground = _smooth_ground(plate, with_, without, share, seen, floor, touched, calm)
    else:
        raw = np.where(floor[..., None], with_ - without, np.float32(0))
        shaded, limited = _shaded(plate, raw, np.clip(1 + _ratio(raw, without), 0, 1))
        made = (raw != 0).any(-1).astype(np.float32)
        on_ground = _Ground(shaded - plate, share * without, made, limited)
    return _composed(plate, shown, covered, on_ground)


@dataclass(frozen=True)
class _Ground:
    """What objects do to the ground.

    `difference` (H, W, 3) as it is added to the plate, also under the objects' edges; `rendered` (H, W, 3) what of the render
    with the objects is ground, where it shows an object as well; `weight` and `limited` (H, W) as in `Composite`.
    """

    difference: FloatArray
    rendered: FloatArray
    weight: FloatArray
    limited: BoolArray


def _composed(plate: FloatArray, with_: FloatArray, covered: FloatArray, on_ground: _Ground) -> Composite:
    touched = covered > 0
    pixels = plate.copy()
    changed = (on_ground.weight > 0) & ~touched
    np.copyto(pixels, plate + on_ground.difference, where=changed[..., None])
    mixed = plate * (1 - covered)[..., None] + on_ground.difference + with_ - on_ground.rendered
    # A plate's own noise about black may be negative; nothing else may.
    np.copyto(pixels, np.maximum(mixed, np.minimum(plate, 0)), where=touched[..., None])
    difference = np.where(changed[..., None], pixels - plate, np.float32(0))
    weight = np.where(changed, on_ground.weight, np.float32(0))
    return Composite(pixels, difference, weight, (pixels != plate).any(-1), on_ground.limited & changed)


def _smooth_ground(
    plate: FloatArray,
    with_: FloatArray,
    without: FloatArray,
    share: FloatArray,
    seen: FloatArray,
    floor: BoolArray,
    touched: BoolArray,
    calm: FloatArray,
) -> _Ground:
    """What objects do to the ground, without noise and in proportion to what the photograph shows of its texture.

    `share` (H, W, 1) is what is left of the ground beside the objects; `seen` (H, W) how much of the pixel that is; `calm` the
    ground with just as much noise as what it is to be taken from.
    """
    light = np.maximum(with_, without)[floor]
    faint = np.float32(max(_FAINT * float(light.mean()) if light.size else 0.0, 1e-12))
    ground = np.maximum(without, 0) + faint
    relative = np.where(floor[..., None], (with_ - without) / ground, np.float32(0))
    if relative.any():
        found = smooth_change(relative, ground, floor)
        photographed = _as_photographed(plate, without, seen, floor, faint)
        against = np.maximum(
            plate, np.maximum(_DARK * np.percentile(plate, 99, axis=(0, 1)), 1e-12).astype(np.float32)
        )
        weight = _weight(*(photographed * part / against for part in (found.relative, found.standard_error)))
        weight *= floor
        weight[_specks(weight > 0, touched)] = 0
        relative = _under_edges(found.relative * weight[..., None], floor, touched)
    else:
        weight, photographed = np.zeros(floor.shape, np.float32), ground
    # A pixel's ground is no brighter than all of it: under the edges that is the better guess of a deep shadow.
    most = _ratio(np.maximum(with_, 0), share * ground) - 1
    np.minimum(relative, most, out=relative, where=touched[..., None] & (share > 0))
    shaded, limited = _shaded(plate, photographed * relative, np.clip(1 + relative, 0, 1))
    # The two renders share their noise as far as they share their light: what is taken away has just so much of it.
    rendered = share * (calm + (np.maximum(calm, 0) + faint) * relative)
    return _Ground((shaded - plate) * seen[..., None], rendered, weight, limited)


def _calm(without: FloatArray, alone: FloatArray) -> FloatArray:
    """The render without the objects (H, W, 3) as means of a few pixels; `alone` (H, W) is the share of ground in each."""
    share = np.repeat(alone[..., None], 3, -1)
    return np.asarray(share * _ratio(_mean(without, _CALM_PX), _mean(share, _CALM_PX)))


def _weight(change: FloatArray, error: FloatArray) -> FloatArray:
    """Share (H, W) in which a change (H, W, 3) relative to the plate is made, by `FADE` and `FADE_ERRORS`."""
    size, doubt = np.abs(change).max(-1), np.abs(error).max(-1)
    low, high = (np.maximum(limit, errors * doubt) for limit, errors in zip(FADE, FADE_ERRORS, strict=True))
    part = np.clip((size - low) / (high - low), 0, 1)
    return np.asarray(part * part * (3 - 2 * part), np.float32)


def _as_photographed(
    plate: FloatArray, without: FloatArray, seen: FloatArray, floor: BoolArray, faint: np.float32
) -> FloatArray:
    """The ground (H, W, 3) as bright as the render has it, with the texture of the photograph; of a pixel that is all ground."""
    side = round(TEXTURE_SHARE * min(floor.shape)) | 1
    share = np.repeat(np.asarray(seen * floor, np.float32)[..., None], 3, -1)
    area = _mean(_mean(share, side), side)

    def level(light: FloatArray) -> FloatArray:
        """Mean without what is far brighter than the rest; `light` (H, W, 3) is premultiplied by the share of ground."""
        for _ in range(2):
            around = _ratio(_mean(_mean(light, side), side), area)
            light = np.minimum(light, np.float32(_BRIGHTEST) * share * around)
        return around

    own = np.maximum(without, 0) * floor[..., None]
    rendered, photographed = level(own), level(np.maximum(plate, 0) * share)
    textured = (rendered + faint) * (np.maximum(plate, 0) + faint) / (photographed + faint)
    return np.asarray(np.minimum(textured, np.float32(_BRIGHTEST) * (np.maximum(rendered, own) + faint)))


def _ratio(values: FloatArray, by: FloatArray) -> FloatArray:
    """Quotient (H, W, 3), zero where there is nothing to divide by."""
    return np.asarray(np.divide(values, by, out=np.zeros_like(values), where=by > 0))


def _under_edges(relative: FloatArray, floor: BoolArray, touched: BoolArray) -> FloatArray:
    """The ground's change (H, W, 3), carried on from beside the objects to under their edges: from as near as there is ground."""
    filled, missing = relative.copy(), touched.copy()
    for side in _FILL_PX:
        beside = _mean(floor.astype(np.float32), side)[..., None]
        near = _mean(relative, side)
        found = missing & (beside[..., 0] > 1e-6)
        np.divide(near, beside, out=filled, where=found[..., None])
        missing &= ~found
    return filled


def _mean(values: FloatArray, side: int) -> FloatArray:
    """A square mean, the picture continued by its mirror image."""
    return np.asarray(cv2.blur(values, (side, side), borderType=cv2.BORDER_REFLECT))


def _specks(changed: BoolArray, touched: BoolArray) -> BoolArray:
    """Changed areas (H, W) of a few pixels with no object beside them: what objects do to the ground is wider."""
    _, labels, statistics, _ = cv2.connectedComponentsWithStats(
        np.asarray(changed | touched, np.uint8), connectivity=8
    )
    small = statistics[:, cv2.CC_STAT_AREA] < SPECK_PX
    small[np.unique(labels[touched])] = False
    return np.asarray(small[labels] & changed)


def _shaded(plate: FloatArray, difference: FloatArray, left: FloatArray) -> tuple[FloatArray, BoolArray]:
    """The plate with the difference, and where (H, W) it is more of a proportion (see `DARKEST_SHARE`)."""
    changed, proportion = plate + difference, np.maximum(plate, 0) * left
    darkened = (difference < 0) & (plate > 0)
    share = _ratio(changed, proportion)
    least = np.where(darkened, share, np.float32(1)).min(-1, keepdims=True)
    part = np.clip(1 - least / np.float32(DARKEST_SHARE), 0, 1)
    proportion += np.maximum(difference, 0)  # what a channel gains is added all the same
    return changed + part * (proportion - changed), part[..., 0] > 0


def _seen_beside(covered: FloatArray, ground: FloatArray, alone: FloatArray) -> FloatArray:
    """Share (H, W) of the ground that is still seen beside the objects, of what is seen of it alone: 1 where there are none."""
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

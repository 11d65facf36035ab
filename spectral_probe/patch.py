"""How bright a patch of a picture is: a card or lamp in the photographs, or its reflection in the ball."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from .errors import CaptureError
from .geometry.ball import find_reflection, reflect
from .geometry.camera import pixel_rays, project
from .light_settings import Rectangle
from .model import BallFit, BoolArray, Camera, FloatArray, Photograph, RadianceImage
from .photo.bracket import MergedBracket
from .photo.merge import merge

_SMALLEST_PX = 3
_CLIPPED_SHARE = 0.02
"""Of a patch so many pixels may be clipped in every photograph (defects, a highlight): they are left out."""

_LEAST_SIGNIFICANCE = 20.0
"""A patch's mean must be known to 5 % in every channel, or it says nothing of gains."""

_UNEVEN = 0.15
"""Beyond this relative spread (standard deviation) within a patch, part of it is something else, or in a shadow."""

_LAMP_REACH_RAD = np.radians(2.0)
"""A lamp is looked for so far from where it is said to be."""

_LAMP_SHARE = 0.7
"""Pixels brighter than this share of a lamp's brightest are the lamp; its blurred edge is not."""

_LEAST_LAMP_PX = 4
_LEAST_COSINE = 0.2
"""Nearer to the ball's rim than this cosine of incidence its reflectance is too uncertain."""


@dataclass(frozen=True)
class Patch:
    """A patch of light: mean `responses` (3,) of its pixels, their standard `error` (3,), and the relative spread within it.

    `cos_incidence` is that on the ball, for a patch seen in it; None for one seen directly.
    """

    responses: FloatArray
    error: FloatArray
    spread: float
    pixels: int
    cos_incidence: float | None = None

    @property
    def uneven(self) -> bool:
        """Whether something else than one evenly lit thing seems to lie in it."""
        return self.spread > _UNEVEN


def direct_patch(
    photographs: Sequence[Photograph],
    bracket: MergedBracket,
    rectangle: Rectangle,
    shifts_px: Sequence[FloatArray],
) -> Patch:
    """A patch in whole photographs, merged as their ball was.

    Parameters
    ----------
    photographs
        A bracket, whole; of each only the patch is looked at.
    bracket
        How the bracket was merged: its exposures and response are used.
    rectangle
        The patch in pixels of the first photograph.
    shifts_px
        Where each photograph's ball lies from the first's: the patch beside it is taken to have moved alike.

    Raises
    ------
    CaptureError
        If the patch leaves a photograph, is clipped, dark or too small; the message says what to do.
    """
    parts = []
    for photograph, shift in zip(photographs, shifts_px, strict=True):
        columns, rows = _inside(rectangle, photograph.clipped.shape, np.round(shift).astype(int), "patch_px")
        part = (rows, columns)
        parts.append(replace(photograph, pixels=photograph.pixels[part], clipped=photograph.clipped[part]))
    merged = merge(parts, bracket.exposures, bracket.response)
    return _patch(merged, np.ones(merged.valid.shape, bool), "patch_px")


def mirrored_patch(
    image: RadianceImage,
    camera: Camera,
    ball: BallFit,
    corner_px: tuple[int, int],
    rectangle: Rectangle,
) -> Patch:
    """A patch in the ball's picture, which begins at `corner_px` of the photograph; `rectangle` is in the photograph's pixels.

    Raises
    ------
    CaptureError
        If it is not on the ball, too near to its rim, clipped, dark or too small.
    """
    name = "ball_patch_px"
    left, top = corner_px
    moved = (rectangle[0] - left, rectangle[1] - top, rectangle[2] - left, rectangle[3] - top)
    shape = image.valid.shape
    if moved[0] < 0 or moved[1] < 0 or moved[2] > shape[1] or moved[3] > shape[0]:
        raise CaptureError(f"[calibration]: {name} does not lie on the ball. Give a rectangle on it.")
    columns, rows = _inside(moved, shape, np.zeros(2, int), name)
    x, y = np.meshgrid(np.arange(columns.start, columns.stop) + 0.5, np.arange(rows.start, rows.stop) + 0.5)
    mirrored = reflect(ball, pixel_rays(camera, np.stack([x, y], axis=-1)))
    if not (mirrored.hit.all() and mirrored.cos_incidence.min() > _LEAST_COSINE):
        raise CaptureError(
            f"[calibration]: {name} lies on the ball's rim or beside the ball. Place the card so that the ball mirrors it "
            "further inside."
        )
    part = RadianceImage(
        image.radiance[rows, columns], image.variance[rows, columns], image.valid[rows, columns]
    )
    patch = _patch(part, np.ones(part.valid.shape, bool), name)
    return replace(patch, cos_incidence=float(mirrored.cos_incidence.mean()))


def lamp_patch(image: RadianceImage, camera: Camera, ball: BallFit, direction: FloatArray) -> Patch:
    """The brightest thing near a direction (3,), in the camera's frame, as the ball shows it.

    Raises
    ------
    CaptureError
        If the direction is not seen, or what is there is clipped or dark.
    """
    name = "light_at"
    point, cosine = find_reflection(ball, np.asarray(direction, float))
    place = project(camera, point)
    radius_px = max(camera.focal_px) * np.tan(ball.cone_angle_rad)
    height, width = image.valid.shape
    if cosine < _LEAST_COSINE or not (0 <= place[0] < width and 0 <= place[1] < height):
        raise CaptureError(
            "[calibration]: no view sees light_at well enough in the ball. Check its bearing and elevation."
        )
    level = cv2.blur(image.radiance.mean(axis=-1), (3, 3))
    y, x = np.ogrid[:height, :width]
    distance = np.hypot(x + 0.5 - place[0], y + 0.5 - place[1])
    near = distance < max(_SMALLEST_PX, 0.5 * radius_px * _LAMP_REACH_RAD)  # a pixel spans 2 / R radians
    peak = np.unravel_index(int(np.where(near, level, -np.inf).argmax()), level.shape)
    _, labels = cv2.connectedComponents((level > _LAMP_SHARE * level[peak]).astype(np.uint8))
    lamp = labels == labels[peak]
    patch = _patch(image, lamp, name)
    rays = pixel_rays(camera, np.argwhere(lamp)[:, ::-1] + 0.5)
    return replace(patch, cos_incidence=float(reflect(ball, rays).cos_incidence.mean()))


def _inside(
    rectangle: Rectangle, shape: tuple[int, ...], shift: FloatArray, name: str
) -> tuple[slice, slice]:
    """Columns and rows of a rectangle moved by a shift, whole pixels; refuses what lies outside."""
    left, top, right, bottom = (round(edge) for edge in rectangle)
    columns, rows = (
        slice(left + int(shift[0]), right + int(shift[0])),
        slice(top + int(shift[1]), bottom + int(shift[1])),
    )
    height, width = shape[:2]
    if columns.start < 0 or rows.start < 0 or columns.stop > width or rows.stop > height:
        raise CaptureError(
            f"[calibration]: {name} = [{left}, {top}, {right}, {bottom}] leaves the photograph of {width} x {height} pixels. "
            "Correct it."
        )
    if right - left < _SMALLEST_PX or bottom - top < _SMALLEST_PX:
        raise CaptureError(
            f"[calibration]: {name} is smaller than {_SMALLEST_PX} x {_SMALLEST_PX} pixels. Make it larger."
        )
    return columns, rows


def _patch(image: RadianceImage, where: BoolArray, name: str) -> Patch:
    """Mean of the valid pixels of an image at `where` (H, W)."""
    usable = where & image.valid
    count = int(np.count_nonzero(usable))
    if count < (1 - _CLIPPED_SHARE) * np.count_nonzero(where):
        raise CaptureError(
            f"[calibration]: {name} is clipped in every photograph of its view. Add a shorter exposure."
        )
    values = image.radiance[usable].astype(float)
    responses = values.mean(0)
    error = np.sqrt(image.variance[usable].astype(float).sum(0)) / count
    if not (responses > _LEAST_SIGNIFICANCE * error).all():
        raise CaptureError(
            f"[calibration]: {name} is too dark to calibrate by. Choose a brighter place, or add a longer exposure."
        )
    spread = float((values.std(0) / responses).max())
    return Patch(responses, error, spread, count)

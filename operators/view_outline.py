"""What is found of the ball in one view, and how a view keeps it. Finding touches no Blender data, keeping does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import bpy

from ..spectral_probe.errors import CaptureError
from ..spectral_probe.model import Capture, Outline, Photograph, ViewSettings

if TYPE_CHECKING:
    from ..spectral_probe.geometry.outline import FoundBall


@dataclass(frozen=True)
class ViewOutline:
    """The outline in each photograph of a view, and what is to be drawn of it (`OutlineSummary` as text)."""

    outline: Outline
    shifts_px: tuple[tuple[float, float], ...]
    summary: str
    cone_angle_rad: float
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Development:
    """A photograph of a view developed into a picture file; `size_px` is what the outline's pixels count."""

    picture: Path
    size_px: tuple[int, int]
    photo: int


def outline_in(photographs: Sequence[Photograph], view: ViewSettings, capture: Capture) -> ViewOutline:
    """The outline in photographs that were read, as the view asks for it: found, near a circle, or given."""
    from ..spectral_probe.view import locate_ball

    return described(locate_ball(photographs, view), photographs[0], capture)


def described(found: FoundBall, photograph: Photograph, capture: Capture) -> ViewOutline:
    """An outline with its summary; without zones where the focal length is not known."""
    from ..spectral_probe.geometry.camera import camera_for
    from ..spectral_probe.geometry.outline_summary import summary_of, to_text

    try:
        camera = camera_for(capture.camera, photograph)
    except (
        CaptureError
    ):  # the outline is worth seeing without it; building the probe asks for the focal length
        camera = None
    summary = summary_of(found.outlines[0], camera, capture.ball.radius_m)
    shifts = tuple((float(x), float(y)) for x, y in found.shifts_px)
    return ViewOutline(found.outlines[0], shifts, to_text(summary), summary.cone_angle_rad, found.warnings)


def develop(
    photograph: Photograph,
    outline: Outline | None,
    folder: Path,
    name: str,
    exposure_ev: float,
    *,
    times: int = 1,
) -> tuple[Path, tuple[int, int]]:
    """Write a photograph's picture; its path, and the photograph's size where it was read `times` smaller."""
    from ..spectral_probe.figures.photograph import developed, write_picture

    height, width = photograph.clipped.shape
    picture = developed(photograph, outline, exposure_ev=exposure_ev)
    return write_picture(folder / name, picture), (times * width, times * height)


def keep_outline(view: bpy.types.PropertyGroup, found: ViewOutline, *, dragging: bool = False) -> None:
    """Keep an outline in its view's settings.

    The circle that is corrected by hand becomes the one found, unless it is given as it is, or in the mouse's hand.
    """
    outline = found.outline
    view.has_outline = True
    view.found_centre_px = outline.centre_px
    view.found_semi_axes_px = outline.semi_axes_px
    view.found_angle = outline.angle_rad
    view.found_rms_px = outline.rms_px
    view.shown.summary, view.shown.cone_angle = found.summary, found.cone_angle_rad
    for photo, shift in zip(view.photos, found.shifts_px, strict=False):
        photo.shift_px = shift
    mean_px = sum(outline.semi_axes_px) / 2
    if view.outline_source != "GIVEN" and not dragging:
        view.outline_px = (*outline.centre_px, mean_px)
    view.shown.fitted_px = (*outline.centre_px, mean_px)

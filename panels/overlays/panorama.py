"""Over the panorama in the Image Editor: regions as great circles, the direction pointed at, and its spectrum."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import bpy

from ...operators.bridge.opened_probe import MEMORY
from ...operators.bridge.panorama_image import picture_of, view_in
from ...operators.direction_target import POLYGON_TARGETS, region_fields
from ...operators.settings import probe_folder
from ...operators.typed import corners_of
from ...spectral_probe.errors import SpectralDataError
from .lines import DARK, disc, segments
from .spectrum_box import draw_spectrum

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ...operators.bridge.panorama_image import PanoramaView

    type Array = NDArray[np.floating[Any]]

_REGION = (1.0, 0.75, 0.15, 1.0)  # orange: the region that a glass or lamp is put into
_OTHER = (0.45, 0.85, 1.0, 0.9)  # blue: regions with a light of their own, or to be exchanged
_EDIT = (0.95, 0.45, 0.95, 0.9)  # pink: where the light was changed
_ACTIVE_EDIT = (1.0, 0.65, 1.0, 1.0)
_HOVERED = (1.0, 1.0, 1.0, 1.0)
_DIRECTION = (1.0, 1.0, 1.0, 1.0)


def draw_panorama() -> None:
    """Draw over the Image Editor's main region that Blender draws now."""
    context = bpy.context
    space = context.space_data
    if not picture_of(space.image) or not space.overlay.show_overlays:
        return
    view = view_in(context.region, space.image)
    if view is None:
        return
    import gpu

    settings, shown = context.scene.spectral_probe, context.window_manager.spectral_probe_panorama
    unit = context.preferences.system.ui_scale
    gpu.state.blend_set("ALPHA")
    try:
        _draw_edits(context, settings, view, unit)
        for target, _, _ in POLYGON_TARGETS:
            _draw_polygon(context, settings, shown, target, view, unit)
        if settings.region.kind == "SEED" and not shown.polygon_of:
            bearing = math.degrees(settings.region.azimuth), math.degrees(settings.region.elevation)
            _draw_seed(context, view, bearing, unit)
        if shown.has_spectrum:
            bearing = math.degrees(shown.azimuth), math.degrees(shown.elevation)
            _draw_cross(context, view, bearing, unit)
            draw_spectrum(context, shown, unit)
    finally:
        gpu.state.blend_set("NONE")


def _draw_edits(context: bpy.types.Context, settings: Any, view: PanoramaView, unit: float) -> None:
    """Where the light was changed, as far as the probe in memory is the scene's."""
    if not settings.edits.items:
        return
    held = MEMORY.peek(probe_folder(settings) / "probe.exr")
    for number, outline in enumerate(held.outlines if held is not None else ()):
        active = number == settings.edits.active_edit
        colour, width = (_ACTIVE_EDIT, 2.0) if active else (_EDIT, 1.2)
        segments(context, view.placed(outline), DARK, (width + 1.5) * unit)
        segments(context, view.placed(outline), colour, width * unit)


def _draw_polygon(
    context: bpy.types.Context, settings: Any, shown: Any, target: str, view: PanoramaView, unit: float
) -> None:
    """The polygon of a target: edges, corners, and while it is being drawn the line to the mouse."""
    fields = region_fields(settings, target)
    if fields is None:
        return
    changing = shown.polygon_of == target
    is_open = changing and shown.is_open
    corners = read_corners(fields.corners)
    if is_open:
        mouse = (math.degrees(shown.azimuth), math.degrees(shown.elevation))
        corners = (*corners, mouse)
    if not corners:
        return
    colour = _REGION if target == "EDIT" else _OTHER
    lines = view.placed(polygon(corners, not is_open))
    segments(context, lines, DARK, 3.5 * unit)
    segments(context, lines, colour, (2.0 if changing or target == "EDIT" else 1.2) * unit)
    for number, corner in enumerate(corners if changing else ()):
        hovered = number == shown.corner
        x, y = view.placed(point(corner))
        disc(context, (x, y), (6.5 if hovered else 5.0) * unit, DARK)
        disc(context, (x, y), (5.0 if hovered else 3.5) * unit, _HOVERED if hovered else colour)


def _draw_seed(
    context: bpy.types.Context, view: PanoramaView, bearing: tuple[float, float], unit: float
) -> None:
    """The point that a region is grown from: a ring."""
    import numpy as np

    turn = np.linspace(0.0, 2.0 * np.pi, 33)
    ring = view.placed(point(bearing)) + 7.0 * unit * np.stack([np.cos(turn), np.sin(turn)], -1)
    lines = np.stack([ring[:-1], ring[1:]], axis=1).astype(np.float32)
    segments(context, lines, DARK, 3.5 * unit)
    segments(context, lines, _REGION, 2.0 * unit)


def _draw_cross(
    context: bpy.types.Context, view: PanoramaView, bearing: tuple[float, float], unit: float
) -> None:
    """The direction whose spectrum is shown."""
    import numpy as np

    x, y = view.placed(point(bearing))
    near, far = 4.0 * unit, 11.0 * unit
    arms = [((x + a * near, y + b * near), (x + a * far, y + b * far)) for a, b in _ARMS]
    lines = np.array(arms, np.float32)
    segments(context, lines, DARK, 3.5 * unit)
    segments(context, lines, _DIRECTION, 1.5 * unit)


_ARMS = ((1, 0), (-1, 0), (0, 1), (0, -1))


# ---------------------------------------------------------------- shapes, computed once for each polygon


def read_corners(text: str) -> tuple[tuple[float, float], ...]:
    """The corners of a field; none where they cannot be read: the operator that needs them says what is wrong."""
    try:
        return corners_of(text) if text.strip() else ()
    except SpectralDataError:
        return ()


@lru_cache(maxsize=16)
def polygon(corners: tuple[tuple[float, float], ...], closed: bool) -> Array:
    """Edges of a polygon as lines of the picture, (N, 2, 2)."""
    from ...spectral_probe.geometry.arcs import polygon_lines

    return polygon_lines(corners, closed=closed)


@lru_cache(maxsize=256)
def point(bearing: tuple[float, float]) -> Array:
    """A bearing as a point of the picture, (2,)."""
    from ...spectral_probe.geometry.arcs import bearing_to_picture

    return bearing_to_picture(*bearing)

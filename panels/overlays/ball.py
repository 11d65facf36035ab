"""The ball over its photograph: outline, centre, residuals, and how well the ball shows what is where."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import bpy
from bpy.app.translations import pgettext_iface as iface_

from ...operators.bridge.image_space import ImageSpace
from ...operators.bridge.photograph_image import view_shown
from ...operators.edit_outline import outline_of, space_of
from .lines import coloured_segments, strip

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ...operators.outline_handles import HandOutline

    type Array = NDArray[np.floating[Any]]

FOUND_RGBA = (1.0, 0.25, 0.63, 1.0)
"""Colour of the outline found, as in the figures."""

DRAWN_RGBA = (1.0, 1.0, 1.0, 0.9)
_SHADE_RGBA = (0.0, 0.0, 0.0, 0.5)
_GOOD_RGB, _FAIR_RGB, _BAD_RGB = (0.3, 1.0, 0.45), (1.0, 0.75, 0.15), (1.0, 0.15, 0.1)
_OWN_RGBA = (0.25, 0.55, 1.0, 0.22)
_BAD_RESIDUAL_PX = 0.6
_TINTS = (0.0, 0.04, 0.1, 0.18, 0.25, 0.32, 0.4, 0.55)
"""Opacity at the rings of `ball_zones.SPANS`, and at the rim."""

_CURVE = 256
_TEXT_POINTS = 11


def draw_ball() -> None:
    """Draw over the Image Editor's main region that Blender draws now."""
    context = bpy.context
    number = view_shown(context.scene, context.space_data.image)
    if number is None:
        return
    settings = context.scene.spectral_probe
    overlay, view = settings.overlay, settings.views[number]
    if not overlay.show or not all(view.shown.size_px):
        return
    import gpu

    space, unit = space_of(context.region, view), context.preferences.system.ui_scale
    hand = outline_of(view) if view.outline_source != "AUTOMATIC" else None
    gpu.state.blend_set("ALPHA")
    try:
        if hand is not None:
            _draw_hand(context, hand, space, unit)
        if view.has_outline:
            _draw_found(context, view, overlay, space, unit)
        _draw_text(view, number, unit)
    finally:
        gpu.state.blend_set("NONE")


def _draw_found(context: bpy.types.Context, view: Any, overlay: Any, space: ImageSpace, unit: float) -> None:
    """The outline found with its zones and residuals."""
    summary = view.shown.summary
    ellipse = (*view.found_centre_px, *view.found_semi_axes_px, view.found_angle)
    if overlay.show_zones and summary:
        for points, colours, triangles in _zones(summary, ellipse):
            _triangles(placed(points, space), colours, triangles)
    curve = placed(_ellipse(ellipse), space)
    strip(context, curve, _SHADE_RGBA, 3.0 * unit, closed=True)
    strip(context, curve, FOUND_RGBA, 1.5 * unit, closed=True)
    if overlay.show_residuals and summary:
        ends, colours = _residuals(summary, ellipse, overlay.residual_scale)
        coloured_segments(context, placed(ends, space), colours, 1.5 * unit)
    x, y = space.to_region(*view.found_centre_px)
    for reach, colour, width in ((9, _SHADE_RGBA, 3.0), (8, FOUND_RGBA, 1.5)):
        arm = reach * unit
        strip(context, ((x - arm, y), (x + arm, y)), colour, width * unit)
        strip(context, ((x, y - arm), (x, y + arm)), colour, width * unit)


def _draw_hand(context: bpy.types.Context, hand: HandOutline, space: ImageSpace, unit: float) -> None:
    """The circle or ellipse drawn by hand, thinner than what was found near it."""
    second = hand.radius_px if hand.round else hand.second_px
    curve = placed(_ellipse((hand.x_px, hand.y_px, hand.radius_px, second, hand.angle_rad)), space)
    strip(context, curve, _SHADE_RGBA, 2.0 * unit, closed=True)
    strip(context, curve, DRAWN_RGBA, 1.0 * unit, closed=True)


def _draw_text(view: Any, number: int, unit: float) -> None:
    """Which photograph it is, and how well the outline fits, at the lower left."""
    import blf

    lines = [
        iface_("{view}: photograph {photo} of {photos}").format(
            view=view.name or iface_("View {number}").format(number=number + 1),
            photo=view.shown.photo + 1,
            photos=len(view.photos),
        )
    ]
    if view.has_outline:
        lines.append(
            iface_("Centre {x:.1f}, {y:.1f}   radius {radius:.1f}   RMS {rms:.2f} px").format(
                x=view.found_centre_px[0],
                y=view.found_centre_px[1],
                radius=sum(view.found_semi_axes_px) / 2,
                rms=view.found_rms_px,
            )
        )
    font = 0
    blf.size(font, _TEXT_POINTS * unit)
    blf.color(font, 1.0, 1.0, 1.0, 1.0)
    blf.enable(font, blf.SHADOW)
    blf.shadow(font, 3, 0.0, 0.0, 0.0, 0.9)
    for row, line in enumerate(reversed(lines)):
        blf.position(font, 14 * unit, (14 + 1.5 * _TEXT_POINTS * row) * unit, 0)
        blf.draw(font, line)
    blf.disable(font, blf.SHADOW)


# ---------------------------------------------------------------- shapes, in pixels of the first photograph


@lru_cache(maxsize=8)
def _ellipse(ellipse: tuple[float, ...]) -> Array:
    """Points (N, 2) round an ellipse (x, y, semi-axis, semi-axis, angle)."""
    import numpy as np

    x, y, first, second, angle = ellipse
    turn = np.arange(_CURVE) * (2.0 * np.pi / _CURVE)
    along, across = first * np.cos(turn), second * np.sin(turn)
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.stack([x + along * cosine - across * sine, y + along * sine + across * cosine], axis=-1)


@lru_cache(maxsize=4)
def _residuals(summary: str, ellipse: tuple[float, ...], times: float) -> tuple[Array, Array]:
    """Lines (2 N, 2) from the outline to its edge points, longer by `times`, and their colours (2 N, 4)."""
    import numpy as np

    from ...spectral_probe.geometry.ellipse import Ellipse
    from ...spectral_probe.geometry.outline_summary import from_text

    kept = from_text(summary)
    direction = np.stack([np.cos(kept.angles_rad), np.sin(kept.angles_rad)], axis=-1)
    radius = Ellipse(*ellipse).radius_at(kept.angles_rad)
    ends = np.stack([radius, radius + times * kept.residuals_px], axis=-1)
    points = np.array(ellipse[:2]) + ends[..., None] * direction[:, None]
    bad = np.clip(np.abs(kept.residuals_px) / _BAD_RESIDUAL_PX, 0.0, 1.0)[:, None]
    stops = np.array([_GOOD_RGB, _FAIR_RGB, _BAD_RGB])
    colour = np.where(
        bad < 0.5,
        stops[0] + 2 * bad * (stops[1] - stops[0]),
        stops[1] + (2 * bad - 1) * (stops[2] - stops[1]),
    )
    colours = np.concatenate([colour, np.ones((len(colour), 1))], axis=-1)
    return points.reshape(-1, 2), colours.repeat(2, axis=0)


@lru_cache(maxsize=4)
def _zones(summary: str, ellipse: tuple[float, ...]) -> list[tuple[Array, Array, Array]]:
    """Meshes of the zones: points (N, 2), colours (N, 4), triangles (T, 3)."""
    import numpy as np

    from ...spectral_probe.geometry.ball_zones import around
    from ...spectral_probe.geometry.outline_summary import from_text

    zones = from_text(summary).zones
    if not zones:
        return []
    turn = np.arange(_CURVE)
    own = np.concatenate([zones[0].points_px.mean(axis=0)[None], around(zones[0].points_px, _CURVE)])
    fan = np.stack([np.zeros(_CURVE, int), turn + 1, (turn + 1) % _CURVE + 1], axis=-1)
    rings = [around(ring.points_px, _CURVE) for ring in zones[1:]]
    centre = np.array(ellipse[:2])
    rim = _ellipse(ellipse)
    # The last ring's points by angle, so that the strip to the rim does not twist.
    last = rings[-1] - centre
    angles = np.arctan2(last[:, 1], last[:, 0])
    of_rim = np.arctan2(rim[:, 1] - centre[1], rim[:, 0] - centre[0])
    order = np.argsort(of_rim)
    radius = np.interp(angles, of_rim[order], np.hypot(*(rim - centre).T)[order], period=2.0 * np.pi)
    rings.append(centre + radius[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=-1))
    points = np.concatenate(rings)
    shares = np.linspace(0.0, 1.0, len(rings))[:, None]
    colour = np.concatenate(
        [np.array(_FAIR_RGB) + shares * (np.array(_BAD_RGB) - _FAIR_RGB), np.array(_TINTS)[:, None]], axis=-1
    )
    colours = colour.repeat(_CURVE, axis=0)
    after = (turn + 1) % _CURVE
    strips = []
    for ring in range(len(rings) - 1):
        inner, outer = ring * _CURVE, (ring + 1) * _CURVE
        strips.append(np.stack([inner + turn, inner + after, outer + turn], axis=-1))
        strips.append(np.stack([inner + after, outer + after, outer + turn], axis=-1))
    return [
        (own, np.array(_OWN_RGBA)[None].repeat(len(own), axis=0), fan),
        (points, colours, np.concatenate(strips)),
    ]


# ---------------------------------------------------------------- drawing, in pixels of the region


def placed(points_px: Array, space: ImageSpace) -> Array:
    """Points (N, 2) of the photograph in region pixels."""
    import numpy as np

    scale = np.array([space.scale_x, -space.scale_y])
    return np.asarray((points_px * scale + [space.left, space.top]).astype(np.float32))


def _triangles(points: Array, colours: Array, triangles: Array) -> None:
    """Triangles, colours blended between their corners."""
    import gpu
    import numpy as np
    from gpu_extras.batch import batch_for_shader

    shader = gpu.shader.from_builtin("SMOOTH_COLOR")
    attributes = {"pos": points, "color": colours.astype(np.float32)}
    batch_for_shader(shader, "TRIS", attributes, indices=triangles.astype(np.int32)).draw(shader)

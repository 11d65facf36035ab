"""The spectrum of the direction pointed at: a curve with its 95 % band, beside the mouse or in a corner."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import bpy
from bpy.app.translations import pgettext_iface as iface_

from .lines import Rgba, band, box, segments, strip, text

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    type Array = NDArray[np.floating[Any]]

_WIDTH, _PLOT_HEIGHT = 300.0, 110.0
_MARGIN, _LINE, _LETTERS, _SMALL = 12.0, 16.0, 11.0, 9.0
_GROUND: Rgba = (0.08, 0.085, 0.1, 0.92)
_INK: Rgba = (0.95, 0.95, 0.95, 1.0)
_SOFT: Rgba = (0.65, 0.67, 0.7, 1.0)
_GRID: Rgba = (1.0, 1.0, 1.0, 0.14)
_CURVE: Rgba = (1.0, 1.0, 1.0, 1.0)
_BAND: Rgba = (0.55, 0.75, 1.0, 0.35)
_AWAY = 22.0  # from the mouse
_TICKS_NM = (400, 500, 600, 700)
_STRIP = 5.0  # of the colours of the wavelengths


def draw_spectrum(context: bpy.types.Context, shown: bpy.types.AnyType, unit: float) -> None:
    """Draw the box: where it is, what it says, the curve."""
    lines = _words(shown)
    has_curve = len(shown.points) > 1
    width = _WIDTH * unit
    height = (2 * _MARGIN + _LINE * len(lines) + (_PLOT_HEIGHT + 2 * _LINE if has_curve else 0.0)) * unit
    left, bottom = _place(context, shown, width, height, unit)
    box(left, bottom, width, height, _GROUND)
    x, y = left + _MARGIN * unit, bottom + height - _MARGIN * unit
    for number, line in enumerate(lines):
        y -= _LINE * unit
        text(line, x, y + 4 * unit, _LETTERS * unit, _SOFT if number else _INK)
    if has_curve:
        top = y - 0.5 * _LINE * unit
        _draw_plot(context, shown, x, top - _PLOT_HEIGHT * unit, width - 2 * _MARGIN * unit, unit)


def _words(shown: bpy.types.AnyType) -> list[str]:
    """What is said above the curve."""
    azimuth, elevation = math.degrees(shown.azimuth) % 360.0, math.degrees(shown.elevation)
    lines = [
        iface_("Bearing {azimuth:.1f}°, elevation {elevation:.1f}°").format(
            azimuth=azimuth, elevation=elevation
        )
    ]
    if shown.problem:
        return [*lines, shown.problem]
    if shown.kinds:
        lines.append(", ".join(shown.kinds.splitlines()))
    lines.append(iface_("Confidence {confidence:.3f}").format(confidence=shown.confidence))
    return lines


def _place(
    context: bpy.types.Context, shown: bpy.types.AnyType, width: float, height: float, unit: float
) -> tuple[float, float]:
    """Lower left corner: beside the mouse where there is room, else at the lower left of the editor."""
    region = context.region
    if not shown.following:
        return 14 * unit, 14 * unit
    x, y = shown.cursor_px[0] - region.x, shown.cursor_px[1] - region.y
    free = region.width - _covered_right(context)
    left = x + _AWAY * unit if x + _AWAY * unit + width < free else x - _AWAY * unit - width
    bottom = min(max(y - height / 2, 4 * unit), region.height - height - 4 * unit)
    if left < 4 * unit:  # no room beside it: below, or above
        left = min(max(x - width / 2, 4 * unit), max(free - width - 4 * unit, 4 * unit))
        below = y - _AWAY * unit - height
        bottom = below if below > 4 * unit else y + _AWAY * unit
    return left, bottom


def _covered_right(context: bpy.types.Context) -> int:
    """How much of the region lies under the sidebar."""
    sidebar = next((region for region in context.area.regions if region.type == "UI"), None)
    return sidebar.width if sidebar is not None and sidebar.width > 1 else 0


def _draw_plot(
    context: bpy.types.Context,
    shown: bpy.types.AnyType,
    left: float,
    bottom: float,
    width: float,
    unit: float,
) -> None:
    """The curve over its wavelengths."""
    import numpy as np

    nm, radiance, lower, upper = (
        _column(shown.points, name) for name in ("wavelength_nm", "radiance", "lower", "upper")
    )
    height = _PLOT_HEIGHT * unit
    highest = float(max(radiance.max(), min(upper.max(), 2.0 * radiance.max()), 1e-30))
    across = left + width * (nm - nm[0]) / max(float(nm[-1] - nm[0]), 1e-9)

    def curve(values: Array) -> Array:
        up = bottom + height * np.clip(values / (1.08 * highest), 0.0, 1.0)
        return np.stack([across, up], axis=-1).astype(np.float32)

    ticks = [tick for tick in _TICKS_NM if nm[0] <= tick <= nm[-1]]
    places = [left + width * (tick - float(nm[0])) / float(nm[-1] - nm[0]) for tick in ticks]
    grid = np.array([((x, bottom), (x, bottom + height)) for x in places], np.float32).reshape(-1, 2, 2)
    segments(context, grid, _GRID, unit)
    _draw_colours(float(nm[0]), float(nm[-1]), left, bottom - _STRIP * unit, width, _STRIP * unit)
    band(curve(lower), curve(upper), _BAND)
    strip(context, curve(radiance), _CURVE, 1.8 * unit)
    under = bottom - (_STRIP + _SMALL + 4.0) * unit
    for tick, x in zip(ticks, places, strict=True):
        words = f"{tick}" if tick != ticks[-1] else iface_("{wavelength} nm").format(wavelength=tick)
        from_left = {ticks[0]: 0.0, ticks[-1]: 38.0}.get(tick, 9.0)
        text(words, x - from_left * unit, under, _SMALL * unit, _SOFT)


def _column(points: bpy.types.AnyType, name: str) -> Array:
    import numpy as np

    values = np.empty(len(points), np.float32)
    points.foreach_get(name, values)
    return values


def _draw_colours(
    first_nm: float, last_nm: float, left: float, bottom: float, width: float, height: float
) -> None:
    """A strip of the colours of the wavelengths."""
    import gpu
    import numpy as np
    from gpu_extras.batch import batch_for_shader

    colours = _colours(first_nm, last_nm)
    across = left + width * np.linspace(0.0, 1.0, len(colours))
    points = np.stack(
        [np.stack([across, np.full_like(across, level)], -1) for level in (bottom, bottom + height)], 1
    )
    shader = gpu.shader.from_builtin("SMOOTH_COLOR")
    attributes = {"pos": points.reshape(-1, 2).astype(np.float32), "color": colours.repeat(2, axis=0)}
    batch_for_shader(shader, "TRI_STRIP", attributes).draw(shader)


@lru_cache(maxsize=2)
def _colours(first_nm: float, last_nm: float) -> Array:
    """(N, 4) of wavelengths at equal distances."""
    import numpy as np

    from ...spectral_probe.figures.spectrum import wavelength_colours

    rgb = wavelength_colours(first_nm, last_nm)[0, ::12] / 255.0
    return np.concatenate([rgb, np.ones((len(rgb), 1))], axis=-1).astype(np.float32)

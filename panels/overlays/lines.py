"""Lines, discs, boxes and letters in pixels of a region."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy

if TYPE_CHECKING:
    from collections.abc import Sequence

type Rgba = tuple[float, float, float, float]

DARK: Rgba = (0.0, 0.0, 0.0, 0.55)
"""Under a bright line, so that it is seen on a bright picture too."""

_FONT = 0


def segments(context: bpy.types.Context, lines: Any, rgba: Rgba, width: float) -> None:
    """Antialiased lines (N, 2, 2), `width` pixels wide."""
    if not len(lines):
        return
    import gpu
    from gpu_extras.batch import batch_for_shader

    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    batch = batch_for_shader(shader, "LINES", {"pos": lines.reshape(-1, 2)})
    shader.uniform_float("viewportSize", (context.region.width, context.region.height))
    shader.uniform_float("lineWidth", width)
    shader.uniform_float("color", rgba)
    batch.draw(shader)


def coloured_segments(context: bpy.types.Context, ends: Any, colours: Any, width: float) -> None:
    """Antialiased lines between pairs of points (2 N, 2), with a colour (2 N, 4) at each end."""
    if not len(ends):
        return
    import gpu
    import numpy as np
    from gpu_extras.batch import batch_for_shader

    shader = gpu.shader.from_builtin("POLYLINE_SMOOTH_COLOR")
    batch = batch_for_shader(shader, "LINES", {"pos": ends, "color": colours.astype(np.float32)})
    shader.uniform_float("viewportSize", (context.region.width, context.region.height))
    shader.uniform_float("lineWidth", width)
    batch.draw(shader)


def strip(context: bpy.types.Context, points: Any, rgba: Rgba, width: float, *, closed: bool = False) -> None:
    """An antialiased line through points (N, 2), back to the first where it is closed."""
    import gpu
    from gpu_extras.batch import batch_for_shader

    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    batch = batch_for_shader(shader, "LINE_LOOP" if closed else "LINE_STRIP", {"pos": points})
    shader.uniform_float("viewportSize", (context.region.width, context.region.height))
    shader.uniform_float("lineWidth", width)
    shader.uniform_float("color", rgba)
    batch.draw(shader)


def band(lower: Any, upper: Any, rgba: Rgba) -> None:
    """What lies between two curves, (N, 2) each."""
    import gpu
    import numpy as np
    from gpu_extras.batch import batch_for_shader

    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    points = np.stack([lower, upper], axis=1).reshape(-1, 2)
    batch = batch_for_shader(shader, "TRI_STRIP", {"pos": points})
    shader.uniform_float("color", rgba)
    batch.draw(shader)


def box(left: float, bottom: float, width: float, height: float, rgba: Rgba) -> None:
    """A filled rectangle."""
    import numpy as np

    ends = np.array([[left, bottom], [left + width, bottom]], np.float32)
    band(ends, ends + np.array([0, height], np.float32), rgba)


def disc(_context: bpy.types.Context, centre: Sequence[float], radius: float, rgba: Rgba) -> None:
    """A filled circle."""
    import gpu
    import numpy as np
    from gpu_extras.batch import batch_for_shader

    turn = np.linspace(0.0, 2.0 * np.pi, 25)
    rim = np.array(centre) + radius * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    points = np.concatenate([[centre], rim]).astype(np.float32)
    batch = batch_for_shader(shader, "TRI_FAN", {"pos": points})
    shader.uniform_float("color", rgba)
    batch.draw(shader)


def text(words: str, x: float, y: float, size: float, rgba: Rgba) -> float:
    """Letters from (x, y) on; returns how wide they are."""
    import blf
    import gpu

    blf.size(_FONT, size)
    blf.color(_FONT, *rgba)
    blf.position(_FONT, x, y, 0)
    blf.draw(_FONT, words)
    gpu.state.blend_set("ALPHA")  # letters leave another way of blending behind
    return float(blf.dimensions(_FONT, words)[0])

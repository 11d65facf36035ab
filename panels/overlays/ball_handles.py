"""Handles on the ball's outline: gizmos of the Image Editor that start the operator which drags it."""

from __future__ import annotations

from typing import Any, ClassVar

import bpy

from ...operators.bridge.photograph_image import view_shown
from ...operators.edit_outline import handle_at, outline_of, space_of
from ...operators.outline_handles import HANDLES

_RADIUS = 5.0
"""Of a handle, in pixels at a resolution scale of 1."""

_RGBA, _HIGHLIGHT_RGBA, _BORDER_RGBA = (1.0, 1.0, 1.0, 0.9), (1.0, 0.85, 0.2, 1.0), (0.0, 0.0, 0.0, 0.7)


def place_of(context: bpy.types.Context, name: str) -> tuple[float, float] | None:
    """Where a handle lies in the region, in pixels; None where the image shows no photograph of a view."""
    number = view_shown(context.scene, context.space_data.image)
    if number is None or context.region is None:
        return None
    view = context.scene.spectral_probe.views[number]
    return space_of(context.region, view).to_region(*outline_of(view).handle(name))


class SPECTRAL_PROBE_GT_handle(bpy.types.Gizmo):
    """A dot that can be dragged."""

    bl_idname = "SPECTRAL_PROBE_GT_handle"
    __slots__ = ("name",)

    def setup(self) -> None:
        """Called by Blender."""
        if not hasattr(self, "name"):
            self.name = HANDLES[0]

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the dot."""
        place = place_of(context, self.name)
        if place is not None:
            unit = context.preferences.system.ui_scale
            fill = _HIGHLIGHT_RGBA if self.is_highlight else _RGBA
            _dot(place, (_RADIUS + 1.5) * unit, _BORDER_RGBA)
            _dot(place, _RADIUS * unit, fill)

    def test_select(self, context: bpy.types.Context, location: Any) -> int:
        """0 where the mouse (region pixels) is on the dot, else -1."""
        number = view_shown(context.scene, context.space_data.image)
        if number is None:
            return -1
        view = context.scene.spectral_probe.views[number]
        return 0 if handle_at(context, view, (location[0], location[1])) == self.name else -1


class SPECTRAL_PROBE_GGT_outline(bpy.types.GizmoGroup):
    """The handles, where the Image Editor shows a photograph of a view."""

    bl_idname = "SPECTRAL_PROBE_GGT_outline"
    bl_label = "Ball Outline"
    bl_space_type = "IMAGE_EDITOR"
    bl_region_type = "WINDOW"
    bl_options: ClassVar[set[str]] = {"PERSISTENT", "SHOW_MODAL_ALL"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A photograph is shown, and the handles are on."""
        overlay = context.scene.spectral_probe.overlay
        space = context.space_data
        if not (overlay.show and overlay.show_handles) or space is None or space.type != "IMAGE_EDITOR":
            return False
        number = view_shown(context.scene, space.image)
        return number is not None and all(context.scene.spectral_probe.views[number].shown.size_px)

    def setup(self, _context: bpy.types.Context) -> None:
        """Make the handles."""
        for name in HANDLES:
            gizmo = self.gizmos.new(SPECTRAL_PROBE_GT_handle.bl_idname)
            gizmo.name = name
            gizmo.use_draw_modal = True
            gizmo.target_set_operator("spectral_probe.edit_outline").handle = name


def _dot(place: tuple[float, float], radius: float, rgba: tuple[float, ...]) -> None:
    """A filled disc with a soft edge."""
    import math

    import gpu
    from gpu_extras.batch import batch_for_shader

    steps = 24
    turns = [2.0 * math.pi * step / steps for step in range(steps)]
    points, colours, triangles = [place], [rgba], []
    for reach, alpha in ((radius - 0.75, rgba[3]), (radius + 0.75, 0.0)):
        points += [(place[0] + reach * math.cos(turn), place[1] + reach * math.sin(turn)) for turn in turns]
        colours += [(*rgba[:3], alpha)] * steps
    for step in range(steps):
        here, after = 1 + step, 1 + (step + 1) % steps
        triangles += [(0, here, after), (here, after, here + steps), (after, after + steps, here + steps)]
    shader = gpu.shader.from_builtin("SMOOTH_COLOR")
    gpu.state.blend_set("ALPHA")
    batch_for_shader(shader, "TRIS", {"pos": points, "color": colours}, indices=triangles).draw(shader)
    gpu.state.blend_set("NONE")

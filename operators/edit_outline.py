"""Move the ball's outline with the mouse, while the rim near it is found."""

from __future__ import annotations

import math
from contextlib import ExitStack
from typing import ClassVar

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.props import EnumProperty

from ..spectral_probe.errors import SpectralProbeError
from ..translations import of_core
from .base import CANCELLED, FINISHED, OperatorResult
from .bridge.image_space import ImageSpace
from .bridge.photograph_image import shift_of, view_shown
from .open_modals import keep_open, status_text, timer
from .outline_handles import HANDLES, HandOutline
from .rim_follower import RimFollower
from .settings import capture_from
from .view_outline import keep_outline

RUNNING: OperatorResult = {"RUNNING_MODAL"}
_TICK_S = 0.04
_PRECISE = 0.1
REACH = 11.0
"""How far from a handle a click counts, in pixels at a resolution scale of 1."""

_KEPT = (
    "outline_source", "outline_px", "outline_minor_px", "outline_angle", "has_outline", "found_centre_px",
    "found_semi_axes_px", "found_angle", "found_rms_px",
)  # fmt: skip


class SPECTRAL_PROBE_OT_edit_outline(bpy.types.Operator):
    """Drag the ball's outline. Shift moves it precisely, Ctrl does not snap to the rim, Esc restores it"""

    bl_idname = "spectral_probe.edit_outline"
    bl_label = "Edit Outline"
    bl_options: ClassVar[set[str]] = {"REGISTER", "UNDO", "BLOCKING", "INTERNAL"}

    handle: EnumProperty(
        name="Handle",
        description="Which part of the outline is dragged",
        items=(
            ("CENTRE", "Centre", "Move the outline"),
            ("RIGHT", "Right", "The end of the first semi-axis"),
            ("BOTTOM", "Bottom", "The end of the second semi-axis"),
            ("LEFT", "Left", "The other end of the first semi-axis"),
            ("TOP", "Top", "The other end of the second semi-axis"),
        ),
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A photograph of ours must be shown."""
        space = context.space_data
        image = space.image if space is not None and space.type == "IMAGE_EDITOR" else None
        if view_shown(context.scene, image) is not None:
            return True
        cls.poll_message_set("Show a photograph of a view in the Image Editor first")
        return False

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        """Begin to drag."""
        number = view_shown(context.scene, context.space_data.image)
        self._number, self._scene = number, context.scene.name
        view = context.scene.spectral_probe.views[number]
        try:
            capture = capture_from(context.scene.spectral_probe)
        except SpectralProbeError as problem:
            self.report({"ERROR"}, of_core(str(problem)))
            return CANCELLED
        self._before = {name: _value(view, name) for name in _KEPT}
        shown = view.shown
        self._before_shown = (shown.summary, shown.cone_angle, tuple(shown.fitted_px))
        self._outline = outline_of(view)
        self._follower = RimFollower(capture, capture.views[number], view.shown.photo, shift_of(view))
        self._dragging, self._done = True, False
        self._grab(context, event)
        words = rpt_("Shift: precise, Ctrl: do not snap to the rim, Esc: restore the outline")
        with ExitStack() as opened:
            opened.callback(self._follower.close)
            opened.callback(self._restore_unless_done)
            opened.enter_context(timer(context, _TICK_S))
            opened.enter_context(status_text(context, words))
            context.window_manager.modal_handler_add(self)
            self._open = opened.pop_all()
            keep_open(self._open)
        return RUNNING

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        """Called by Blender for every event while the outline is dragged, and until its rim is found."""
        view = self._view(context)
        if view is None:  # the view or its picture went away
            return self._end(context, CANCELLED)
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            return self._end(context, CANCELLED)
        if event.type == "TIMER":
            return self._tick(context, view)
        if not self._dragging:
            return self._between(context, event, view)
        if event.type == "MOUSEMOVE":
            self._drag(context, event, view)
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            self._dragging = False
            self._ask(view, final=True)
        elif event.type in {"WHEELUPMOUSE", "WHEELDOWNMOUSE", "MIDDLEMOUSE", "TRACKPADPAN", "TRACKPADZOOM"}:
            return {"PASS_THROUGH"}
        return RUNNING

    def _between(
        self, context: bpy.types.Context, event: bpy.types.Event, view: bpy.types.PropertyGroup
    ) -> OperatorResult:
        """While the rim is found after a drag: another one may begin."""
        if event.type == "LEFTMOUSE" and event.value == "PRESS":
            mouse = (event.mouse_x - context.region.x + 0.5, event.mouse_y - context.region.y + 0.5)
            handle = handle_at(context, view, mouse)
            if handle is not None:
                self.handle, self._dragging = handle, True
                self._outline = outline_of(view)
                self._grab(context, event)
                return RUNNING
        return {"PASS_THROUGH"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Called by Blender when it ends the operator itself, such as when another file is opened."""
        self._end(context, CANCELLED)

    def _view(self, context: bpy.types.Context) -> bpy.types.PropertyGroup | None:
        scene = bpy.data.scenes.get(self._scene)
        if scene is None or context.area is None or context.area.type != "IMAGE_EDITOR":
            return None
        if view_shown(scene, context.space_data.image) != self._number:
            return None
        return scene.spectral_probe.views[self._number]

    def _grab(self, context: bpy.types.Context, event: bpy.types.Event) -> None:
        """Remember where the handle and the mouse were."""
        view = self._view(context)
        self._mouse = space_of(context.region, view).of_mouse(event, context.region)
        self._place = self._outline.handle(self.handle)

    def _drag(
        self, context: bpy.types.Context, event: bpy.types.Event, view: bpy.types.PropertyGroup
    ) -> None:
        mouse = space_of(context.region, view).of_mouse(event, context.region)
        share = _PRECISE if event.shift else 1.0
        moved = [share * (now - before) for now, before in zip(mouse, self._mouse, strict=True)]
        self._mouse = mouse
        self._place = (self._place[0] + moved[0], self._place[1] + moved[1])
        self._outline = self._outline.dragged(self.handle, self._place)
        self._snap = context.scene.spectral_probe.overlay.snap and not event.ctrl
        put_outline(view, self._outline, snap=self._snap)
        self._ask(view)
        context.area.tag_redraw()

    def _ask(self, view: bpy.types.PropertyGroup, *, final: bool = False) -> None:
        snap = view.outline_source == "SNAP"
        outline = self._outline
        values = (outline.x_px, outline.y_px, outline.radius_px)
        if not outline.round and not snap:
            values = (*values, outline.second_px, math.degrees(outline.angle_rad))
        self._follower.ask(values, snap=snap, final=final)

    def _tick(self, context: bpy.types.Context, view: bpy.types.PropertyGroup) -> OperatorResult:
        try:
            answer = self._follower.answer()
        except SpectralProbeError as problem:
            if self._dragging:
                return RUNNING  # the next place may be better
            self.report({"ERROR"}, of_core(str(problem)))
            return self._end(context, CANCELLED)
        if answer is None:
            return RUNNING
        found, final = answer
        done = final and not self._dragging
        keep_outline(view, found, dragging=not done)
        context.area.tag_redraw()
        if not done:
            return RUNNING
        for warning in found.warnings:
            self.report({"WARNING"}, of_core(warning))
        return self._end(context, FINISHED)

    def _restore_unless_done(self) -> None:
        scene = bpy.data.scenes.get(self._scene)
        views = scene.spectral_probe.views if scene is not None else ()
        if self._done or self._number >= len(views):  # or the view was removed
            return
        view = views[self._number]
        for name, value in self._before.items():
            setattr(view, name, value)
        shown = view.shown
        shown.summary, shown.cone_angle, shown.fitted_px = self._before_shown

    def _end(self, context: bpy.types.Context, result: OperatorResult) -> OperatorResult:
        self._done = result == FINISHED
        self._open.close()
        if context.area is not None:
            context.area.tag_redraw()
        return result


def space_of(region: bpy.types.Region, view: bpy.types.PropertyGroup) -> ImageSpace:
    """Where the first photograph's pixels, which outlines count, lie in a region that shows a photograph of a view."""
    return ImageSpace.of(region, view.shown.size_px).moved(shift_of(view))


def handle_at(
    context: bpy.types.Context, view: bpy.types.PropertyGroup, mouse: tuple[float, float]
) -> str | None:
    """The handle that the mouse (region pixels) is on."""
    space, outline = space_of(context.region, view), outline_of(view)
    reach = REACH * context.preferences.system.ui_scale
    for name in HANDLES:
        x, y = space.to_region(*outline.handle(name))
        if math.hypot(mouse[0] - x, mouse[1] - y) <= reach:
            return name
    return None


def outline_of(view: bpy.types.PropertyGroup) -> HandOutline:
    """The outline of a view as handles show it: the one drawn by hand, the one found, or a circle in the picture's middle."""
    if view.outline_source != "AUTOMATIC" and view.outline_px[2] > 0:
        second_px = view.outline_minor_px if view.outline_source == "GIVEN" else 0.0
        return HandOutline(*view.outline_px, second_px, view.outline_angle)
    if view.has_outline:
        return HandOutline(*view.found_centre_px, sum(view.found_semi_axes_px) / 2)
    width, height = view.shown.size_px
    return HandOutline(width / 2, height / 2, 0.35 * min(width, height))


def put_outline(view: bpy.types.PropertyGroup, outline: HandOutline, *, snap: bool) -> None:
    """Make an outline drawn by hand that of a view."""
    view.outline_source = "SNAP" if snap else "GIVEN"
    view.outline_px = (outline.x_px, outline.y_px, outline.radius_px)
    if not outline.round:
        view.outline_minor_px, view.outline_angle = outline.second_px, outline.angle_rad


def _value(view: bpy.types.PropertyGroup, name: str) -> object:
    value = getattr(view, name)
    return tuple(value) if hasattr(value, "__len__") and not isinstance(value, str) else value

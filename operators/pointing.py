"""What the modal tools over the panorama share: where the mouse points, and a tidy end."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from .base import CANCELLED, OperatorResult, ReportsErrors
from .bridge.panorama_image import panorama_regions, redraw_panoramas, region_under
from .job import RUNNING
from .polls import has_probe

if TYPE_CHECKING:
    from .bridge.panorama_image import PanoramaView

_PASSED_ON = {
    "MIDDLEMOUSE",
    "WHEELUPMOUSE",
    "WHEELDOWNMOUSE",
    "TRACKPADPAN",
    "TRACKPADZOOM",
    "NUMPAD_PLUS",
    "NUMPAD_MINUS",
    "HOME",
    "TIMER",
}
"""Events with which one moves about in the picture."""


class PointsAtPanorama(ReportsErrors):
    """Mixin for modal operators over the panorama: `handle` takes the events, `words` says what they do."""

    words = ""
    """For the status bar."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a probe; its panorama must be shown, unless a script gives the direction."""
        if not has_probe(cls, context):
            return False
        if bpy.app.background or any(panorama_regions(context.window)):
            return True
        cls.poll_message_set("Show the panorama in an Image Editor of this window first")
        return False

    def begin(self, context: bpy.types.Context) -> None:
        """Get ready; every tool has its own."""

    def handle(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        """Take one event; every tool has its own."""
        raise NotImplementedError

    def restore(self, context: bpy.types.Context) -> None:
        """Put everything back as it was before `begin`, after ESC; every tool has its own."""

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        """Start pointing."""
        if bpy.app.background:
            return self.execute(context)
        return self.reporting(lambda: self._start(context))

    def _start(self, context: bpy.types.Context) -> OperatorResult:
        self.begin(context)
        context.window_manager.modal_handler_add(self)
        context.window.cursor_modal_set("CROSSHAIR")
        context.workspace.status_text_set(rpt_(self.words))
        redraw_panoramas(context.window_manager)
        return RUNNING

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        """Called by Blender for every event."""
        result = CANCELLED
        try:
            if event.type == "ESC" and event.value == "PRESS":
                self.restore(context)
            elif event.type in _PASSED_ON:
                result = {"PASS_THROUGH"}
            elif not any(panorama_regions(context.window)):  # another image is shown, or another workspace
                self.restore(context)
            else:
                result = self.reporting(lambda: self.handle(context, event))
        finally:  # after a defect too
            if result not in (RUNNING, {"PASS_THROUGH"}):
                self.end(context)
        redraw_panoramas(context.window_manager)
        return result

    def cancel(self, context: bpy.types.Context) -> None:
        """Called by Blender when it ends the operator itself, such as when another file is opened."""
        self.end(context)

    def end(self, context: bpy.types.Context) -> None:
        """Leave nothing of the tool behind."""
        shown = context.window_manager.spectral_probe_panorama
        shown.following = shown.is_open = False
        shown.polygon_of, shown.corner = "", -1
        if context.window is not None:
            context.window.cursor_modal_restore()
        if context.workspace is not None:
            context.workspace.status_text_set(None)

    @staticmethod
    def under(
        context: bpy.types.Context, event: bpy.types.Event
    ) -> tuple[PanoramaView, float, float, tuple[float, float]] | None:
        """The panorama under the mouse, the mouse in its region's pixels, and the bearing there; None beside it."""
        found = region_under(context.window, event.mouse_x, event.mouse_y)
        if found is None:
            return None
        region, view = found
        x, y = event.mouse_x - region.x + 0.5, event.mouse_y - region.y + 0.5  # the pixel's middle
        bearing = view.bearing_at(x, y)
        return None if bearing is None else (view, x, y, bearing)

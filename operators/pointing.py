"""What the modal tools over the panorama share: where the mouse points, and a tidy end."""

from __future__ import annotations

from contextlib import ExitStack, suppress
from typing import TYPE_CHECKING

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..spectral_probe.errors import SpectralProbeError
from .base import CANCELLED, OperatorResult, ReportsErrors
from .bridge.panorama_image import panorama_regions, redraw_panoramas, region_under
from .job import RUNNING
from .open_modals import keep_open, status_text
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

    _open: ExitStack | None = None  # what must be closed when the tool ends
    _scene_uid = 0
    _to_restore = False

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a probe; its panorama must be shown, unless a script gives the direction."""
        if not has_probe(cls, context):
            return False
        if bpy.app.background or any(panorama_regions(context.window)):
            return True
        cls.poll_message_set("Show the panorama in an Image Editor of this window first")
        return False

    def begin(self, context: bpy.types.Context, opened: ExitStack) -> None:
        """Get ready; every tool has its own. `opened` is closed at its end."""

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
        with ExitStack() as opened:
            self._scene_uid = context.scene.session_uid
            self.begin(context, opened)
            self._to_restore = True
            opened.callback(self._leave, context.window_manager)
            opened.enter_context(status_text(context, rpt_(self.words)))
            context.window_manager.modal_handler_add(self)
            context.window.cursor_modal_set("CROSSHAIR")
            opened.callback(_cursor_back, context.window_manager)
            self._open = opened.pop_all()
            keep_open(self._open)
        redraw_panoramas(context.window_manager)
        return RUNNING

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        """Called by Blender for every event."""
        result = CANCELLED
        try:
            if self._is_over(context, event):
                pass
            elif event.type in _PASSED_ON:
                result = {"PASS_THROUGH"}
            else:
                result = self.reporting(lambda: self.handle(context, event))
        finally:  # after a defect too
            if result not in (RUNNING, {"PASS_THROUGH"}):
                self._to_restore = result == CANCELLED
                self._end()
        redraw_panoramas(context.window_manager)
        return result

    def cancel(self, _context: bpy.types.Context) -> None:
        """Called by Blender when it ends the operator itself, such as when another file is opened."""
        self._end()

    def _is_over(self, context: bpy.types.Context, event: bpy.types.Event) -> bool:
        """ESC was pressed, or another image, workspace or scene is shown now."""
        if event.type == "ESC" and event.value == "PRESS":
            return True
        if context.scene.session_uid != self._scene_uid:
            return True
        return event.type not in _PASSED_ON and not any(panorama_regions(context.window))

    def _end(self) -> None:
        if self._open is not None:
            self._open.close()

    def _leave(self, window_manager: bpy.types.WindowManager) -> None:
        """Leave nothing of the tool behind."""
        scene = next((scene for scene in bpy.data.scenes if scene.session_uid == self._scene_uid), None)
        # What the tool was for, such as an entry of a list, may have been removed meanwhile.
        if self._to_restore and scene is not None:
            with suppress(SpectralProbeError), bpy.context.temp_override(scene=scene):
                self.restore(bpy.context)
        shown = window_manager.spectral_probe_panorama
        shown.following = shown.is_open = False
        shown.polygon_of, shown.corner = "", -1

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


def _cursor_back(window_manager: bpy.types.WindowManager) -> None:
    """The usual cursor: the window in which the tool began may be closed, or show another scene."""
    for window in window_manager.windows:
        window.cursor_modal_restore()

"""Move the corners of a polygon on the panorama."""

from __future__ import annotations

import math
from contextlib import ExitStack
from typing import TYPE_CHECKING

import bpy
from bpy.props import EnumProperty

from .base import FINISHED, OperatorResult
from .direction_target import POLYGON_TARGETS, needed_fields, region_fields
from .draw_region import FEWEST, Bearing, corners_text, nearness_px
from .job import RUNNING
from .pointing import PointsAtPanorama
from .typed import corners_of

if TYPE_CHECKING:
    from .bridge.panorama_image import PanoramaView


class SPECTRAL_PROBE_OT_edit_region(PointsAtPanorama, bpy.types.Operator):
    """Drag the corners of the polygon on the panorama; drag an edge to put a corner there, Ctrl click to remove one"""

    bl_idname = "spectral_probe.edit_region"
    bl_label = "Edit Corners"
    words = "Drag: corner or edge, Ctrl click or X: remove corner, Enter or right click: done, ESC: as it was"

    target: EnumProperty(
        name="For", description="What the polygon is for", items=POLYGON_TARGETS, options={"SKIP_SAVE"}
    )

    _before = ("POLYGON", "")
    _dragged: int | None = None

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a polygon, in the picture."""
        if not super().poll(context):
            return False
        settings = context.scene.spectral_probe
        fields = (region_fields(settings, key) for key, _, _ in POLYGON_TARGETS)
        if any(field is not None and field.corners.strip() for field in fields):
            return True
        cls.poll_message_set("Draw a region first")
        return False

    def run(self, _context: bpy.types.Context) -> OperatorResult:
        """A script writes the corners into their field."""
        return FINISHED

    def begin(self, context: bpy.types.Context, _opened: ExitStack) -> None:
        """Take the corners as they are.

        Raises
        ------
        SpectralDataError
            If there is no region, or its corners cannot be read.
        """
        fields = needed_fields(context.scene.spectral_probe, self.target)
        self._before = fields.state()
        self._corners: list[Bearing] = list(corners_of(fields.corners))
        shown = context.window_manager.spectral_probe_panorama
        shown.polygon_of, shown.has_spectrum = self.target, False

    def restore(self, context: bpy.types.Context) -> None:
        """The corners as they were."""
        needed_fields(context.scene.spectral_probe, self.target).restore(self._before)

    def handle(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        """Drag, insert or remove a corner, or end."""
        if event.type in {"RET", "NUMPAD_ENTER", "RIGHTMOUSE"} and event.value == "PRESS":
            return FINISHED
        if event.type == "LEFTMOUSE" and event.value == "RELEASE":
            self._dragged = None
        place = self.under(context, event)
        if place is None:
            return RUNNING
        view, x, y, bearing = place
        shown = context.window_manager.spectral_probe_panorama
        if event.type == "MOUSEMOVE" and self._dragged is not None:
            self._corners[self._dragged] = bearing
        elif self._dragged is None:
            shown.corner = self._corner_at(view, x, y, nearness_px(context))
        removes = event.type in {"X", "DEL"} or (event.type == "LEFTMOUSE" and event.ctrl)
        if removes and event.value == "PRESS":
            if shown.corner >= 0 and len(self._corners) > FEWEST:
                del self._corners[shown.corner]
                shown.corner = -1
        elif event.type == "LEFTMOUSE" and event.value in {"PRESS", "DOUBLE_CLICK"}:
            self._take_hold(context, view, x, y, bearing)
        needed_fields(context.scene.spectral_probe, self.target).set_corners(corners_text(self._corners))
        return RUNNING

    def _take_hold(
        self, context: bpy.types.Context, view: PanoramaView, x: float, y: float, bearing: Bearing
    ) -> None:
        """Begin to drag the corner under the mouse, or one put on the edge there."""
        shown = context.window_manager.spectral_probe_panorama
        if shown.corner < 0:
            edge = self._edge_at(view, x, y, nearness_px(context))
            if edge is None:
                return
            self._corners.insert(edge + 1, bearing)
            shown.corner = edge + 1
        self._dragged = shown.corner

    def _corner_at(self, view: PanoramaView, x: float, y: float, near_px: float) -> int:
        """Number of the corner at a point of the region; -1 where there is none."""
        import numpy as np

        from ..spectral_probe.geometry.arcs import bearing_to_picture

        places = view.placed(bearing_to_picture(*np.array(self._corners).T))
        apart = np.hypot(*(places - (x, y)).T)
        nearest = int(apart.argmin())
        return nearest if apart[nearest] <= near_px else -1

    def _edge_at(self, view: PanoramaView, x: float, y: float, near_px: float) -> int | None:
        """Number of the edge (that of the corner it begins at) at a point of the region."""
        import numpy as np

        from ..spectral_probe.geometry.arcs import polygon_lines

        best, found = near_px, None
        for number, start in enumerate(self._corners):
            end = self._corners[(number + 1) % len(self._corners)]
            lines = view.placed(polygon_lines([start, end], closed=False))
            if not len(lines):
                continue
            along = lines[:, 1] - lines[:, 0]
            length = np.maximum((along**2).sum(-1), 1e-9)
            share = np.clip((((x, y) - lines[:, 0]) * along).sum(-1) / length, 0, 1)
            apart = float(np.hypot(*(lines[:, 0] + share[:, None] * along - (x, y)).T).min())
            if apart < best and math.isfinite(apart):
                best, found = apart, number
        return found

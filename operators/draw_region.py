"""Draw a polygon on the panorama: a corner at every click, or a line drawn with the button held."""

from __future__ import annotations

import math
from contextlib import ExitStack

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.props import EnumProperty, StringProperty

from ..spectral_probe.errors import SpectralDataError
from ..translations import of_core
from .base import FINISHED, OperatorResult
from .direction_target import POLYGON_TARGETS, needed_fields
from .job import RUNNING
from .pointing import PointsAtPanorama
from .typed import corners_of

type Bearing = tuple[float, float]

FEWEST = 3
_NEAR_PX = 10.0
"""Within so many pixels, times the resolution scale, the mouse is on a corner."""

_LASSO_PX = 14.0
"""A line drawn with the button held gets a corner after so many."""


def corners_text(corners: list[Bearing]) -> str:
    """Corners as people write them, for the field of a polygon; `corners_of` reads it."""
    return ", ".join(f"{azimuth % 360.0:.2f} {elevation:.2f}" for azimuth, elevation in corners)


def nearness_px(context: bpy.types.Context) -> float:
    """How near to a corner the mouse is on it."""
    return _NEAR_PX * context.preferences.system.ui_scale


class SPECTRAL_PROBE_OT_draw_region(PointsAtPanorama, bpy.types.Operator):
    """Draw a polygon on the panorama: click its corners, or draw round it with the button held"""

    bl_idname = "spectral_probe.draw_region"
    bl_label = "Draw Region"
    words = "Click: corner, hold: draw, Enter, double click or right click: close, Backspace: last corner away, ESC: stop"

    target: EnumProperty(
        name="For", description="What the polygon is for", items=POLYGON_TARGETS, options={"SKIP_SAVE"}
    )
    corners: StringProperty(
        name="Corners",
        description="Bearing and elevation of each corner in degrees, such as 10 0, 30 0, 30 20",
        options={"SKIP_SAVE"},
    )

    _before = ("SEED", "")
    _held: tuple[float, float] | None = None
    _lasso = False

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Take the corners given.

        Raises
        ------
        SpectralDataError
            If they are no corners, or too few.
        """
        from ..spectral_probe.spectra.regions import polygon_mask

        given = corners_of(self.corners)
        if len(given) < FEWEST:
            raise SpectralDataError("A polygon needs three corners or more.")
        polygon_mask(given, 4, 8)  # neighbours that lie opposite each other are refused
        needed_fields(context.scene.spectral_probe, self.target).set_corners(corners_text(list(given)))
        return FINISHED

    def begin(self, context: bpy.types.Context, _opened: ExitStack) -> None:
        """Start without a corner."""
        fields = needed_fields(context.scene.spectral_probe, self.target)
        self._before = fields.state()
        self._corners: list[Bearing] = []
        fields.set_corners("")
        shown = context.window_manager.spectral_probe_panorama
        shown.polygon_of, shown.is_open, shown.has_spectrum = self.target, True, False

    def restore(self, context: bpy.types.Context) -> None:
        """The region as it was."""
        needed_fields(context.scene.spectral_probe, self.target).restore(self._before)

    def handle(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        """Add corners, take the last away, or close."""
        place = self.under(context, event)
        if place is not None:
            self._follow(context, place[3])
        closes = event.type in {"RET", "NUMPAD_ENTER", "RIGHTMOUSE"} and event.value == "PRESS"
        if closes or (event.type == "LEFTMOUSE" and event.value == "DOUBLE_CLICK"):
            return self._close(context)
        if event.type == "BACK_SPACE" and event.value == "PRESS" and self._corners:
            self._corners.pop()
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            self._held = None
            if self._lasso:
                self._lasso = False
                return self._close(context)
        elif place is not None:
            view, x, y, bearing = place
            if event.type == "LEFTMOUSE" and event.value == "PRESS":
                if len(self._corners) >= FEWEST and self._on_first(context, view, x, y):
                    return self._close(context)
                self._corners.append(bearing)
                self._held = (x, y)
            elif event.type == "MOUSEMOVE" and self._held is not None:
                self._draw_on(context, x, y, bearing)
        self._write(context)
        return RUNNING

    def _follow(self, context: bpy.types.Context, bearing: Bearing) -> None:
        shown = context.window_manager.spectral_probe_panorama
        shown.azimuth, shown.elevation = map(math.radians, bearing)

    def _draw_on(self, context: bpy.types.Context, x: float, y: float, bearing: Bearing) -> None:
        """Another corner of a line drawn with the button held, far enough from the last."""
        apart = math.hypot(x - self._held[0], y - self._held[1])
        if apart >= _LASSO_PX * context.preferences.system.ui_scale:
            self._corners.append(bearing)
            self._held = (x, y)
            self._lasso = self._lasso or len(self._corners) > FEWEST

    def _on_first(self, context: bpy.types.Context, view: object, x: float, y: float) -> bool:
        from ..spectral_probe.geometry.arcs import bearing_to_picture

        first = view.placed(bearing_to_picture(*self._corners[0]))
        return math.hypot(first[0] - x, first[1] - y) <= nearness_px(context)

    def _write(self, context: bpy.types.Context) -> None:
        fields = needed_fields(context.scene.spectral_probe, self.target)
        fields.set_corners(corners_text(self._corners))

    def _close(self, context: bpy.types.Context) -> OperatorResult:
        """Take the polygon, if it is one."""
        if len(self._corners) < FEWEST:
            context.workspace.status_text_set(rpt_("A polygon needs three corners or more. ESC: stop"))
            return RUNNING
        self.corners = corners_text(self._corners)
        try:
            return self.run(context)
        except SpectralDataError as problem:
            self.report({"WARNING"}, of_core(str(problem)))
            self._corners.pop()
            self._write(context)
            return RUNNING

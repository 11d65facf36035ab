"""Menus beside the lists of views and photographs: what is done rarely."""

import math

import bpy
from bpy.app.translations import pgettext_iface as iface_


class SPECTRAL_PROBE_MT_views(bpy.types.Menu):
    """Join views, and spread them evenly round the ball"""

    bl_label = "Views"

    def draw(self, _context: bpy.types.Context) -> None:
        """Draw joining and spreading."""
        layout = self.layout
        layout.operator(
            "spectral_probe.join_views", text="Join with View Before", icon="TRIA_UP"
        ).other = "BEFORE"
        layout.operator(
            "spectral_probe.join_views", text="Join with View After", icon="TRIA_DOWN"
        ).other = "AFTER"
        layout.separator()
        clockwise = layout.operator(
            "spectral_probe.spread_views", text="Spread Evenly, Clockwise", icon="LOOP_FORWARDS"
        )
        clockwise.clockwise = True
        other = layout.operator(
            "spectral_probe.spread_views", text="Spread Evenly, Counterclockwise", icon="LOOP_BACK"
        )
        other.clockwise = False


class SPECTRAL_PROBE_MT_photos(bpy.types.Menu):
    """Move the active photograph to another view"""

    bl_label = "Photograph"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the other views, and a new one."""
        layout, settings = self.layout, context.scene.spectral_probe
        new = layout.operator("spectral_probe.move_photo", text="Move to New View", icon="ADD")
        new.view, new.following = 0, False
        split = layout.operator(
            "spectral_probe.move_photo", text="Begin New View Here", icon="NODE_INSERT_ON"
        )
        split.view, split.following = 0, True
        layout.separator()
        for number, view in enumerate(settings.views, 1):
            if number == settings.active_view + 1:
                continue
            text = iface_("Move to {view} ({bearing}\u00b0)").format(
                view=view.name, bearing=f"{math.degrees(view.azimuth):.4g}"
            )
            move = layout.operator(
                "spectral_probe.move_photo", text=text, icon="CAMERA_DATA", translate=False
            )
            move.view, move.following = number, False

"""The Image Editor's sidebar: the ball's outline over a photograph, its numbers and what is drawn."""

from __future__ import annotations

import math
from typing import Any

import bpy
from bpy.app.translations import pgettext_iface as iface_

from .main import InImageEditor, job_button, results, row, settings_layout


class SPECTRAL_PROBE_PT_image_ball(InImageEditor, bpy.types.Panel):
    """The photograph of the active view and the ball's outline in it."""

    bl_label = "Ball"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the views, the outline's settings and what was found."""
        layout, settings = self.layout, context.scene.spectral_probe
        if not settings.views:
            layout.label(text="Import photographs first", icon="INFO")
            return
        layout.template_list(
            "SPECTRAL_PROBE_UL_views", "image", settings, "views", settings, "active_view", rows=2
        )
        if settings.active_view >= len(settings.views):
            return
        view = settings.views[settings.active_view]
        _draw_photograph(layout, context, view)
        column = settings_layout(layout)
        column.row().prop(view, "outline_source", expand=True)
        if view.outline_source != "AUTOMATIC":
            for index, name in enumerate(("X", "Y", "Radius")):
                column.prop(view, "outline_px", index=index, text=name)
        if view.outline_source == "GIVEN":
            column.prop(view, "outline_minor_px")
            if view.outline_minor_px > 0:
                column.prop(view, "outline_angle")
        if view.has_outline and view.outline_source != "AUTOMATIC" and changed_since(view):
            layout.label(text="Changed: Detect Ball fits it again", icon="INFO")
        column.prop(settings, "all_views")
        job_button(layout, context, "spectral_probe.detect_ball", "VIEWZOOM")
        if view.has_outline:
            draw_found(results(layout), view)


class SPECTRAL_PROBE_PT_image_overlay(InImageEditor, bpy.types.Panel):
    """What is drawn over the photograph."""

    bl_label = "Overlay"
    bl_parent_id = "SPECTRAL_PROBE_PT_image_ball"

    def draw_header(self, context: bpy.types.Context) -> None:
        """Draw the switch of all of it."""
        self.layout.prop(context.scene.spectral_probe.overlay, "show", text="")

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the switches."""
        overlay = context.scene.spectral_probe.overlay
        column = settings_layout(self.layout)
        column.active = overlay.show
        column.prop(overlay, "show_handles")
        column.prop(overlay, "snap")
        column.prop(overlay, "show_zones")
        column.prop(overlay, "show_residuals")
        times = column.column()
        times.active = overlay.show_residuals
        times.prop(overlay, "residual_scale")


def _draw_photograph(layout: bpy.types.UILayout, context: bpy.types.Context, view: Any) -> None:
    verb = "spectral_probe.show_photograph"
    if view.shown.picture is not None:
        steps = layout.row(align=True)
        steps.operator(verb, text="Before", icon="TRIA_LEFT").step = -1
        steps.operator(verb, text="Next", icon="TRIA_RIGHT").step = 1
    job_button(layout, context, verb, "IMAGE_DATA")
    settings_layout(layout).prop(context.scene.spectral_probe.overlay, "exposure_ev")


def changed_since(view: Any) -> bool:
    """Whether the outline's numbers were edited after the ball was found."""
    radius = view.outline_px[2]
    if view.outline_source == "GIVEN" and view.outline_minor_px > 0:
        radius = (radius + view.outline_minor_px) / 2
    now = (view.outline_px[0], view.outline_px[1], radius)
    return any(abs(one - other) > 0.05 for one, other in zip(now, view.shown.fitted_px, strict=True))


def draw_found(column: bpy.types.UILayout, view: Any) -> None:
    """The outline found in a view, in numbers."""
    column.label(text=view.name, icon="CHECKMARK", translate=False)
    row(column, iface_("Centre"), "{:.1f}, {:.1f} px".format(*view.found_centre_px))
    row(column, iface_("Semi-Axes"), "{:.2f}, {:.2f} px".format(*view.found_semi_axes_px))
    row(column, iface_("Angle"), f"{math.degrees(view.found_angle):.1f}°")
    row(column, iface_("RMS"), f"{view.found_rms_px:.3f} px")
    if view.shown.cone_angle > 0.0:
        row(column, iface_("Blind Cone"), f"±{math.degrees(view.shown.cone_angle):.1f}°")

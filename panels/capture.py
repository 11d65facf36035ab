"""Stages 1 and 2: what was photographed, with what, and the ball in it."""

from pathlib import PurePath
from typing import ClassVar

import bpy

from .image_ball import draw_found
from .known_light import draw_own_lights
from .main import InWorld, job_button, results, settings_layout
from .preset_menus import SPECTRAL_PROBE_PT_capture_presets, SPECTRAL_PROBE_PT_lamps_presets


class SPECTRAL_PROBE_PT_capture(InWorld, bpy.types.Panel):
    """The capture file, the views and their photographs."""

    bl_label = "Capture"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the views."""
        layout, settings = self.layout, context.scene.spectral_probe
        files = layout.row(align=True)
        files.operator("spectral_probe.import_photographs", icon="IMPORT", text="Import...")
        files.operator("spectral_probe.save_capture", icon="EXPORT", text="Save...")
        if settings.capture_path:
            name = layout.row()
            name.active = False
            name.label(text=PurePath(settings.capture_path).name, icon="FILE_TEXT")

        list_row = layout.row()
        rows = max(2, min(4, len(settings.views)))
        list_row.template_list(
            "SPECTRAL_PROBE_UL_views", "", settings, "views", settings, "active_view", rows=rows
        )
        buttons = list_row.column(align=True)
        buttons.operator("spectral_probe.add_view", icon="ADD", text="")
        buttons.operator("spectral_probe.remove_view", icon="REMOVE", text="")
        buttons.separator()
        buttons.menu("SPECTRAL_PROBE_MT_views", icon="DOWNARROW_HLT", text="")
        if settings.active_view < len(settings.views):
            view = settings.views[settings.active_view]
            angles = settings_layout(layout)
            angles.prop(view, "azimuth")
            angles.prop(view, "elevation")
            angles.prop(view, "roll")
            angles.prop(view, "refine")


class SPECTRAL_PROBE_PT_photographs(InWorld, bpy.types.Panel):
    """The bracket of the active view."""

    bl_label = "Photographs"
    bl_parent_id = "SPECTRAL_PROBE_PT_capture"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be an active view."""
        settings = context.scene.spectral_probe
        return settings.active_view < len(settings.views)

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the list, and the exposure of the active photograph."""
        layout, settings = self.layout, context.scene.spectral_probe
        view = settings.views[settings.active_view]
        rows = max(2, min(4, len(view.photos)))
        list_row = layout.row()
        list_row.template_list(
            "SPECTRAL_PROBE_UL_photos", "", view, "photos", view, "active_photo", rows=rows
        )
        buttons = list_row.column(align=True)
        buttons.operator("spectral_probe.add_photos", icon="ADD", text="")
        buttons.operator("spectral_probe.remove_photo", icon="REMOVE", text="")
        buttons.separator()
        buttons.menu("SPECTRAL_PROBE_MT_photos", icon="DOWNARROW_HLT", text="")
        column = settings_layout(layout)
        column.prop(view, "solve_exposures")
        column.prop(view, "filter")
        if view.active_photo < len(view.photos):
            photo = view.photos[view.active_photo]
            column = settings_layout(layout)
            column.prop(photo, "path", text="File")
            column.prop(photo, "exposure_s")
            column.prop(photo, "iso")
            column.prop(photo, "f_number")


class SPECTRAL_PROBE_PT_camera(InWorld, bpy.types.Panel):
    """How the camera sees colours, and its lens."""

    bl_label = "Camera"
    bl_parent_id = "SPECTRAL_PROBE_PT_capture"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}

    def draw_header_preset(self, _context: bpy.types.Context) -> None:
        """Draw the menu of presets."""
        SPECTRAL_PROBE_PT_capture_presets.draw_panel_header(self.layout)

    def draw(self, context: bpy.types.Context) -> None:
        """Draw sensitivities and lens."""
        camera = context.scene.spectral_probe.camera
        column = settings_layout(self.layout)
        model = column.column()
        model.active = not camera.sensitivities
        model.prop(camera, "model", placeholder="Rec.709")
        column.prop(camera, "sensitivities")
        column.prop(camera, "half_size")
        column.separator()
        column.prop(camera, "focal_source")
        if camera.focal_source == "PX":
            column.prop(camera, "focal_px", text="Pixels")
        if camera.focal_source == "MM":
            column.prop(camera, "focal_mm", text="Millimetres")
        if camera.focal_source in {"EXIF", "MM"}:
            column.prop(camera, "sensor_width_mm")
        if camera.focal_source == "CALIBRATION":
            column.prop(camera, "calibration", text="File")
        job_button(self.layout, context, "spectral_probe.calibrate", "MOD_LATTICE")
        if camera.focal_source == "CALIBRATION":
            return
        principal = column.row(heading="Principal Point")
        principal.prop(camera, "has_principal", text="")
        values = principal.row(align=True)
        values.active = camera.has_principal
        values.prop(camera, "principal_px", text="")
        self.layout.label(text="Lens Distortion")
        grid = self.layout.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
        for index, name in enumerate(("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")):
            grid.prop(camera, "distortion", index=index, text=name)


class SPECTRAL_PROBE_PT_lamps(InWorld, bpy.types.Panel):
    """Which lamp families may be present."""

    bl_label = "Lamps"
    bl_parent_id = "SPECTRAL_PROBE_PT_capture"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}

    def draw_header_preset(self, _context: bpy.types.Context) -> None:
        """Draw the menu of presets."""
        SPECTRAL_PROBE_PT_lamps_presets.draw_panel_header(self.layout)

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the families as a list of switches."""
        settings = context.scene.spectral_probe
        self.layout.prop(settings, "families_automatic")
        families = self.layout.column(align=True)
        families.enabled = not settings.families_automatic
        families.prop(settings, "families", expand=True)
        draw_own_lights(self.layout, settings.known_light)


class SPECTRAL_PROBE_PT_ball(InWorld, bpy.types.Panel):
    """The mirrored ball and its outline in the photographs."""

    bl_label = "Ball"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the ball's settings and the outline found in the active view."""
        layout, settings = self.layout, context.scene.spectral_probe
        column = settings_layout(layout)
        column.prop(settings, "ball_radius")
        column.prop(settings, "ball_material")
        if settings.active_view >= len(settings.views):
            job_button(layout, context, "spectral_probe.detect_ball", "VIEWZOOM")
            return
        view = settings.views[settings.active_view]
        column.row().prop(view, "outline_source", expand=True)
        if view.outline_source != "AUTOMATIC":
            column.prop(view, "outline_px")
        else:
            chosen = column.row(heading="Choose Ball")
            chosen.prop(view, "has_ball_at", text="")
            point = chosen.row(align=True)
            point.active = view.has_ball_at
            point.prop(view, "ball_at_px", text="")
        column.prop(settings, "all_views")
        job_button(layout, context, "spectral_probe.detect_ball", "VIEWZOOM")
        job_button(layout, context, "spectral_probe.show_photograph", "IMAGE_DATA")
        if view.has_outline:
            draw_found(results(layout), view)

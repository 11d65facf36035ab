"""Stages 3 and 4: the spectral probe, and the world it lights."""

import math

import bpy

from .main import InWorld, cells, duration, job_button, paragraph, results, row, settings_layout


class SPECTRAL_PROBE_PT_probe(InWorld, bpy.types.Panel):
    """How the spectra are recovered, and what came out."""

    bl_label = "Probe"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the settings, the button and the results."""
        layout, settings = self.layout, context.scene.spectral_probe
        column = settings_layout(layout)
        column.prop(settings, "method")
        column.prop(settings, "composition")
        column.prop(settings, "probe_width")
        column.prop(settings, "probe_directory")
        job_button(layout, context, "spectral_probe.build_probe", "LIGHTPROBE_SPHERE")
        if settings.probe.width_px:
            _draw_probe(results(layout), settings)
            for warning in settings.probe.warnings.splitlines():
                paragraph(results(layout), context, warning, "ERROR")


def _draw_probe(column: bpy.types.UILayout, settings: bpy.types.AnyType) -> None:
    probe = settings.probe
    row(column, "Panorama", f"{probe.width_px} x {probe.height_px} px")
    row(column, "Blind", f"{probe.blind_fraction:.2%}")
    row(column, "Time", duration(probe.seconds))
    column.separator()
    cells(column, "View", "Bearing", "RMS", "Clipped", active=False)
    for view in settings.views:
        if view.has_probe:
            cells(
                column,
                view.name,
                f"{math.degrees(view.probe_azimuth):.1f}°",
                f"{view.probe_rms_px:.2f} px",
                f"{view.clipped_fraction:.1%}",
            )


class SPECTRAL_PROBE_PT_world(InWorld, bpy.types.Panel):
    """Lighting the scene."""

    bl_label = "Light"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the button and the scene's world."""
        layout, scene = self.layout, context.scene
        layout.operator("spectral_probe.light_world", icon="WORLD")
        layout.template_ID(scene, "world")

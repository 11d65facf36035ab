"""Stage 5: the spectral render, in the render properties and the Render menu."""

import bpy
from bpy.app.translations import pgettext_iface as iface_

from ..operators.render_folder import sharing_scenes
from .main import duration, job_button, paragraph, results, row, settings_layout
from .output import draw_output
from .preset_menus import SPECTRAL_PROBE_PT_render_presets
from .swap import draw_plan


class SPECTRAL_PROBE_PT_render(bpy.types.Panel):
    """The spectral render."""

    bl_label = "Spectral Render"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"

    def draw_header_preset(self, _context: bpy.types.Context) -> None:
        """Draw the menu of presets."""
        SPECTRAL_PROBE_PT_render_presets.draw_panel_header(self.layout)

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the settings, the button and what the last render took."""
        layout, settings = self.layout, context.scene.spectral_probe
        column = settings_layout(layout)
        column.prop(settings, "light")
        column.prop(settings, "plan")
        if settings.plan == "NUMBER":
            column.prop(settings, "passes")
        if settings.plan != "REFERENCE":
            column.prop(settings, "max_de2000")
        column.prop(settings, "samples")
        if settings.plan != "REFERENCE":
            column.prop(settings, "full_samples")
        column.prop(settings, "rgb_twin")
        column.prop(settings, "render_directory")
        if sharing_scenes(context.scene):
            layout.operator("spectral_probe.own_render_folder", icon="DUPLICATE")
        draw_output(column, settings.output)
        if context.scene.render.engine != "CYCLES":
            paragraph(
                layout,
                context,
                "Spectral rendering needs Cycles; other engines only approximate metals.",
                "ERROR",
            )
            layout.operator("spectral_probe.use_cycles", icon="SHADING_RENDERED")
        draw_plan(layout, context)
        job_button(layout, context, "spectral_probe.render_spectral", "RENDER_STILL")
        job_button(layout, context, "spectral_probe.render_animation", "RENDER_ANIMATION")
        job_button(layout, context, "spectral_probe.export_farm_job", "EXPORT")
        if settings.render.passes:
            _draw_render(results(layout), settings.render)
            for warning in settings.render.warnings.splitlines():
                paragraph(results(layout), context, warning, "ERROR")


def _draw_render(column: bpy.types.UILayout, render: bpy.types.AnyType) -> None:
    told = iface_("{passes} at {samples} samples").format(passes=render.passes, samples=render.samples)
    row(column, "Passes", told)
    if render.predicted_de2000:
        row(column, "Predicted ΔE", f"{render.predicted_de2000:.2f}")
    row(column, "Spectral", duration(render.seconds))
    if render.has_rgb:
        row(column, "RGB", duration(render.rgb_seconds))


def draw_render_menu(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """Entries of the Render menu."""
    self.layout.separator()
    self.layout.operator("spectral_probe.render_spectral", icon="RENDER_STILL")
    self.layout.operator("spectral_probe.render_animation", icon="RENDER_ANIMATION")
    self.layout.operator("spectral_probe.render_and_compare", icon="IMAGE_DATA")

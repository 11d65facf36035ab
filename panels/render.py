"""Stages 5 and 6: objects of measured metal, and the spectral render."""

import bpy

from .main import InSidebar, duration, job_button, paragraph, results, row, settings_layout
from .material import draw_spectrum
from .output import draw_output
from .swap import draw_plan


class SPECTRAL_PROBE_PT_objects(InSidebar, bpy.types.Panel):
    """The objects of the paper."""

    bl_label = "Objects"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw a button for each object, and the active object's material."""
        column = self.layout.column(align=True)
        for kind, text, icon in (
            ("GOLD_PEDESTAL", "Gold Pedestal", "MESH_CYLINDER"),
            ("SILVER_BALL", "Silver Ball", "MESH_UVSPHERE"),
            ("COPPER_BALL", "Copper Ball", "MESH_UVSPHERE"),
        ):
            column.operator("spectral_probe.add_object", text=text, icon=icon).kind = kind
        material = context.object.active_material if context.object else None
        if material is not None:
            column = settings_layout(self.layout)
            column.label(text=material.name, icon="MATERIAL")
            draw_spectrum(column, material)


class SPECTRAL_PROBE_PT_render(InSidebar, bpy.types.Panel):
    """The spectral render."""

    bl_label = "Render"

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
        if settings.render.passes:
            _draw_render(results(layout), settings.render)
            for warning in settings.render.warnings.splitlines():
                paragraph(results(layout), context, warning, "ERROR")


def _draw_render(column: bpy.types.UILayout, render: bpy.types.AnyType) -> None:
    row(column, "Passes", f"{render.passes} at {render.samples} samples")
    if render.predicted_de2000:
        row(column, "Predicted ΔE", f"{render.predicted_de2000:.2f}")
    row(column, "Spectral", duration(render.seconds))
    if render.has_rgb:
        row(column, "RGB", duration(render.rgb_seconds))

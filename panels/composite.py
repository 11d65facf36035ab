"""The composite of a render and its photograph."""

import bpy

from .main import InRender, job_button, paragraph, results, row, settings_layout


class SPECTRAL_PROBE_PT_composite(InRender, bpy.types.Panel):
    """The render put into its photograph."""

    bl_label = "Composite"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the settings, the button and what came of it."""
        layout, settings = self.layout, context.scene.spectral_probe.composite
        column = settings_layout(layout)
        column.prop(settings, "background")
        if settings.background == "PHOTO":
            column.prop(settings, "plate", placeholder="The backplate's")
            column.prop(settings, "srgb")
            column.prop(settings, "camera", placeholder="The backplate's")
            column.prop(settings, "exposure_s")
        column.prop(settings, "denoised")
        column.prop(settings, "show")
        job_button(layout, context, "spectral_probe.composite", "IMAGE_BACKGROUND")
        if settings.directory:
            row(results(layout), "Changed", f"{settings.changed_fraction:.1%}")
            for remark in settings.remarks.splitlines():
                paragraph(results(layout), context, remark, "ERROR")

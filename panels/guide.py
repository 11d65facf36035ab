"""The three steps from photographs to the comparison, in the 3D viewport's sidebar; the details are in the properties."""

import bpy

from .main import job_button

_STEPS = (
    ("spectral_probe.import_photographs", "IMPORT"),
    ("spectral_probe.light_from_photographs", "LIGHTPROBE_SPHERE"),
    ("spectral_probe.render_and_compare", "RENDER_STILL"),
)


class SPECTRAL_PROBE_PT_main(bpy.types.Panel):
    """The shortest way, and the parent of what needs a viewport."""

    bl_label = "Spectral Probe"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Spectral Probe"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the steps, a check mark before those that are done."""
        settings = context.scene.spectral_probe
        done = (bool(settings.views), bool(settings.probe.width_px), bool(settings.comparison.directory))
        column = self.layout.column()
        for (operator, icon), finished in zip(_STEPS, done, strict=True):
            job_button(column, context, operator, "CHECKMARK" if finished else icon)

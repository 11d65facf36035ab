"""The parent of the stages from photographs to light: it says what is wrong with the file before all else."""

import bpy

from .files import draw_missing, draw_newer


class SPECTRAL_PROBE_PT_light_probe(bpy.types.Panel):
    """The parent of the stages from photographs to light."""

    bl_label = "Spectral Probe"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "world"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw what is missing or not known; the stages say the rest."""
        draw_newer(self.layout, context)
        draw_missing(self.layout, context)

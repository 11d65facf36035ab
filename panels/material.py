"""What a material is in spectral renders, in the material properties."""

from typing import ClassVar

import bpy

from .main import settings_layout
from .render import draw_spectrum


class SPECTRAL_PROBE_PT_material(bpy.types.Panel):
    """Spectral settings of the active material."""

    bl_label = "Spectral Probe"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a material."""
        return context.material is not None

    def draw(self, context: bpy.types.Context) -> None:
        """Draw its settings."""
        draw_spectrum(settings_layout(self.layout), context.material)

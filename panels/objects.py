"""The objects of the paper, of measured metal."""

import bpy

from ..preferences import addon_preferences
from .add_menu import OBJECTS
from .main import InSidebar, settings_layout
from .material import draw_spectrum


class SPECTRAL_PROBE_PT_objects(InSidebar, bpy.types.Panel):
    """The objects of the paper."""

    bl_label = "Objects"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw a button for each object, and the active object's material."""
        column = self.layout.column(align=True)
        for kind, text, icon in OBJECTS:
            column.operator("spectral_probe.add_object", text=text, icon=icon).kind = kind
        chosen = addon_preferences()
        if chosen is None or not chosen.asset_library:
            self.layout.operator("spectral_probe.add_asset_library", icon="ASSET_MANAGER")
        material = context.object.active_material if context.object else None
        if material is not None:
            column = settings_layout(self.layout)
            column.label(text=material.name, icon="MATERIAL")
            draw_spectrum(column, material)

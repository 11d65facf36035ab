"""The objects of the paper, of measured metal."""

import bpy

from .main import InSidebar, settings_layout
from .material import draw_spectrum


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

"""Add > Spectral Metal in the 3D viewport."""

import bpy
from bpy.app.translations import pgettext_n as n_

OBJECTS = (
    ("GOLD_PEDESTAL", n_("Gold Pedestal", "Operator"), "MESH_CYLINDER"),
    ("SILVER_BALL", n_("Silver Ball", "Operator"), "MESH_UVSPHERE"),
    ("COPPER_BALL", n_("Copper Ball", "Operator"), "MESH_UVSPHERE"),
    ("GROUP", n_("All Three", "Operator"), "OUTLINER_OB_GROUP_INSTANCE"),
)
"""What can be added: the word of `spectral_probe.add_object`, its text and its icon."""


class SPECTRAL_PROBE_MT_add_metal(bpy.types.Menu):
    """Add an object of measured metal"""

    bl_label = "Spectral Metal"

    def draw(self, _context: bpy.types.Context) -> None:
        """Draw a line for each."""
        for kind, text, icon in OBJECTS:
            self.layout.operator("spectral_probe.add_object", text=text, icon=icon).kind = kind


def draw_add_menu(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """The line in the Add menu."""
    menu.layout.menu("SPECTRAL_PROBE_MT_add_metal", icon="MATERIAL")


def register() -> None:
    """Put the line into the Add menu, once."""
    unregister()
    bpy.types.VIEW3D_MT_add.append(draw_add_menu)


def unregister() -> None:
    """Take it out."""
    bpy.types.VIEW3D_MT_add.remove(draw_add_menu)

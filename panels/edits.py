"""Stained glasses and other lamps in the probe's light."""

from typing import ClassVar

import bpy

from .main import InWorld, job_button, name_or_file, paragraph, results, row, settings_layout

_ICONS = {"glass": "MOD_LATTICE", "lamp": "LIGHT"}


class SPECTRAL_PROBE_UL_edits(bpy.types.UIList):
    """One glass or lamp a row: its name, and how large it is."""

    def draw_item(
        self,
        _context: bpy.types.Context,
        layout: bpy.types.UILayout,
        _data: bpy.types.AnyType,
        edit: bpy.types.AnyType,
        _icon: int,
        _active_data: bpy.types.AnyType,
        _active_property: str,
    ) -> None:
        """Draw one row."""
        line = layout.split(factor=0.45, align=True)
        line.label(text=edit.name, icon=_ICONS[edit.kind])
        details = line.row()
        details.alignment = "RIGHT"
        details.active = False
        details.label(text=f"{edit.solid_angle_sr:.3g} sr")


class SPECTRAL_PROBE_PT_edits(InWorld, bpy.types.Panel):
    """The list of glasses and lamps, the region, and what to put there."""

    bl_label = "Glass and Lamps"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the list, then the region, then both verbs."""
        layout, settings = self.layout, context.scene.spectral_probe
        draw_list(layout, context, settings.edits)
        region = settings.region
        layout.row().prop(region, "kind", expand=True)
        column = settings_layout(layout)
        if region.kind == "SEED":
            column.prop(region, "azimuth")
            column.prop(region, "elevation")
            column.operator("spectral_probe.seed_from_view", icon="VIEW3D")
        elif region.kind == "POLYGON":
            column.prop(region, "polygon")
        else:
            column.template_ID(region, "mask", open="image.open")
            column.operator("spectral_probe.add_mask", icon="BRUSH_DATA")
        column.separator()
        name_or_file(column, region, "glass")
        job_button(layout, context, "spectral_probe.add_glass", "MOD_LATTICE")
        layout.separator()
        column = settings_layout(layout)
        name_or_file(column, region, "lamp")
        column.prop(region, "keeps")
        if region.keeps == "surfaces":
            column.prop(region, "was")
        job_button(layout, context, "spectral_probe.replace_lamp", "LIGHT")


def draw_list(layout: bpy.types.UILayout, context: bpy.types.Context, edits: bpy.types.AnyType) -> None:
    """The glasses and lamps that the light has, with buttons to take them back."""
    line = layout.row()
    count = len(edits.items)
    line.template_list(
        "SPECTRAL_PROBE_UL_edits", "", edits, "items", edits, "active_edit", rows=max(2, min(4, count))
    )
    buttons = line.column(align=True)
    if context.window_manager.spectral_probe.operator != "spectral_probe.remove_edit":
        buttons.operator("spectral_probe.remove_edit", icon="REMOVE", text="")
        buttons.operator("spectral_probe.remove_edit", icon="TRASH", text="").everything = True
    else:
        job_button(layout, context, "spectral_probe.remove_edit", "REMOVE")
    if edits.active_edit < count:
        edit = edits.items[edits.active_edit]
        column = results(layout)
        paragraph(column, context, edit.region, "NONE")
        row(column, "Solid Angle", f"{edit.solid_angle_sr:.4f} sr")

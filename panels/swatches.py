"""The library as a list with swatches, in the properties of materials and lamps."""

import bpy
from bpy.app.translations import pgettext_iface as iface_

from ..operators.bridge.swatches import SwatchShelf
from .main import InProperties, job_button, paragraph, settings_layout

_SURFACES = ("METAL", "REFLECTANCE", "GLASS", "DISPERSIVE")


class SPECTRAL_PROBE_UL_swatches(bpy.types.UIList):
    """One entry a row, with its swatch; of the kind that the list is named for."""

    def draw_item(
        self,
        _context: bpy.types.Context,
        layout: bpy.types.UILayout,
        _data: bpy.types.AnyType,
        swatch: bpy.types.AnyType,
        _icon: int,
        _active_data: bpy.types.AnyType,
        _active_property: str,
    ) -> None:
        """Draw one row."""
        split = layout.split(factor=0.5)
        split.label(text=swatch.label, icon_value=SwatchShelf.icon_of(swatch.name), translate=False)
        details = split.row()
        details.active = False
        details.label(text=swatch.detail, icon="ERROR" if swatch.remark else "NONE", translate=False)

    def draw_filter(self, _context: bpy.types.Context, _layout: bpy.types.UILayout) -> None:
        """Nothing: the field above the list searches, pages that are not listed yet among it."""

    def filter_items(
        self, _context: bpy.types.Context, data: bpy.types.AnyType, name: str
    ) -> tuple[list[int], list[int]]:
        """Leave out entries of other kinds, the search having left out the rest."""
        kind, shown, never = self.list_id, self.bitflag_filter_item, self.bitflag_item_never_show
        return [shown if swatch.kind == kind else never for swatch in getattr(data, name)], []


def draw_swatches(
    layout: bpy.types.UILayout, context: bpy.types.Context, owner: bpy.types.ID, kind: str, chosen: str
) -> None:
    """The light, the button that lists, the search and the list for a material's or a lamp's settings."""
    settings, listed = context.scene.spectral_probe.swatches, context.window_manager.spectral_probe_swatches
    if kind != "LAMP":
        column = settings_layout(layout)
        column.prop(settings, "light")
        if settings.light == "LAMP":
            column.prop(settings, "lamp")
        elif settings.light == "DIRECTION":
            column.prop(settings, "azimuth")
            column.prop(settings, "elevation")
    job_button(layout, context, "spectral_probe.show_swatches", "COLOR")
    if not listed.light:
        return
    layout.prop(listed, "search", text="", icon="VIEWZOOM", placeholder="Search")
    layout.template_list(
        "SPECTRAL_PROBE_UL_swatches", kind, listed, "items", owner.spectral_probe, chosen, rows=8
    )
    layout.prop(settings, "set_look")
    index = getattr(owner.spectral_probe, chosen)
    _draw_details(layout, context, listed.items[index] if index >= 0 else None, listed.light, kind)


def _draw_details(
    layout: bpy.types.UILayout, context: bpy.types.Context, swatch: bpy.types.AnyType, light: str, kind: str
) -> None:
    """Where the chosen entry is from, and what the swatches are."""
    column = layout.column(align=True)
    column.scale_y = 0.8
    column.active = False
    if kind != "LAMP":
        paragraph(
            column,
            context,
            iface_("Swatches under {light}, as adapted to it: a perfect white is white").format(light=light),
            "NONE",
        )
    if swatch is None:
        return
    paragraph(column, context, swatch.source, "NONE")
    column.label(text=swatch.licence, translate=False)
    if swatch.remark:
        paragraph(column, context, swatch.remark, "ERROR")


class SPECTRAL_PROBE_PT_material_swatches(InProperties, bpy.types.Panel):
    """The library of what the material is."""

    bl_label = "Library"
    bl_context = "material"
    bl_parent_id = "SPECTRAL_PROBE_PT_material"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """The material must be something measured."""
        return context.material is not None and context.material.spectral_probe.kind in _SURFACES

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the list."""
        material = context.material
        draw_swatches(self.layout, context, material, material.spectral_probe.kind, "chosen_surface")


class SPECTRAL_PROBE_PT_light_swatches(InProperties, bpy.types.Panel):
    """The library of lamps."""

    bl_label = "Library"
    bl_context = "data"
    bl_parent_id = "SPECTRAL_PROBE_PT_light"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """The lamp must be a measured one."""
        return context.light is not None and context.light.spectral_probe.light == "LAMP"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the list."""
        draw_swatches(self.layout, context, context.light, "LAMP", "chosen_lamp")

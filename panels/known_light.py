"""What is known of the light beside the lamp families: own lamps, regions, the known light to calibrate by."""

from typing import ClassVar

import bpy
from bpy.app.translations import pgettext_iface as iface_
from bpy.app.translations import pgettext_n as n_

from .main import InWorld, settings_layout


def draw_own_lights(layout: bpy.types.UILayout, known: bpy.types.AnyType) -> None:
    """The list of measured lamps."""
    layout.label(text="Measured Lamps")
    _draw_list(layout, known, "own_lights", "active_own_light", "own_light")


def _draw_list(
    layout: bpy.types.UILayout, known: bpy.types.AnyType, items: str, active: str, verb: str
) -> None:
    """A list with buttons to add and remove."""
    row = layout.row()
    rows = max(2, min(4, len(getattr(known, items))))
    row.template_list(f"SPECTRAL_PROBE_UL_{verb}s", "", known, items, known, active, rows=rows)
    buttons = row.column(align=True)
    buttons.operator(f"spectral_probe.add_{verb}", icon="ADD", text="")
    buttons.operator(f"spectral_probe.remove_{verb}", icon="REMOVE", text="")


class SPECTRAL_PROBE_PT_region_lights(InWorld, bpy.types.Panel):
    """Regions of the panorama with a light of their own."""

    bl_label = "Lamps by Region"
    bl_parent_id = "SPECTRAL_PROBE_PT_capture"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the list and the active region."""
        layout, known = self.layout, context.scene.spectral_probe.known_light
        _draw_list(layout, known, "regions", "active_region", "region_light")
        if known.active_region >= len(known.regions):
            return
        region = known.regions[known.active_region]
        column = settings_layout(layout)
        column.prop(region, "place")
        if region.place == "SEED":
            column.prop(region, "bearing")
            column.prop(region, "elevation")
            column.operator("spectral_probe.seed_from_view", icon="VIEW3D").target = "LIGHT"
        else:
            column.prop(region, "polygon_deg" if region.place == "POLYGON" else "mask")
        column.prop(region, "light")
        if region.light == "SPECTRUM":
            column.prop(region, "spectrum")
            return
        layout.prop(region, "families_automatic")
        families = layout.column(align=True)
        families.enabled = not region.families_automatic
        families.prop(region, "families", expand=True)


class SPECTRAL_PROBE_PT_calibration(InWorld, bpy.types.Panel):
    """A light of known spectrum, which gives the camera's channels their gains."""

    bl_label = "Calibration"
    bl_parent_id = "SPECTRAL_PROBE_PT_capture"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        """Draw where the light is, and what it is."""
        known = context.scene.spectral_probe.known_light.calibration
        column = settings_layout(self.layout)
        column.prop(known, "source")
        if known.source == "NONE":
            return
        if known.source == "PATCH":
            column.prop(known, "view")
            _draw_edges(column, known, "patch_px", iface_("Patch"))
        else:
            column.prop(known, "bearing")
            column.prop(known, "elevation")
            column.operator("spectral_probe.seed_from_view", icon="VIEW3D").target = "CALIBRATION"
        column.separator()
        column.prop(known, "light")
        if known.light == "SPECTRUM":
            column.prop(known, "spectrum", text="File")
            column.prop(known, "absolute")
        else:
            column.prop(known, "illuminant", text="Name")
        number = column.column()
        number.active = not known.reflectance_path
        number.prop(known, "reflectance")
        column.prop(known, "reflectance_path")
        if known.source == "PATCH":
            column.separator()
            column.prop(known, "has_ball_patch")
            if known.has_ball_patch:
                _draw_edges(column, known, "ball_patch_px", iface_("Reflection"))


def _draw_edges(column: bpy.types.UILayout, known: bpy.types.AnyType, rectangle: str, name: str) -> None:
    """The four edges of a rectangle, each with its name."""
    edges = column.column(align=True)
    for index, edge in enumerate((n_("Left"), n_("Top"), n_("Right"), n_("Bottom"))):
        edges.prop(known, rectangle, index=index, text=f"{name} {iface_(edge)}" if index == 0 else edge)

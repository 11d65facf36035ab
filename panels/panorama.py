"""The Image Editor's sidebar over a panorama: its pictures, a direction, a region, and what is put there."""

import math
from typing import Any, ClassVar

import bpy
from bpy.app.translations import pgettext_iface as iface_

from ..operators.bridge.panorama_image import picture_of
from ..operators.show_panorama import PICTURE_ITEMS
from .edits import draw_list
from .main import InImageEditor, job_button, results, row, settings_layout

_PICTURE_ICONS = {"LIGHT": "IMAGE_RGB", "CONFIDENCE": "IMAGE_ALPHA", "KINDS": "COLOR"}


class SPECTRAL_PROBE_PT_panorama(InImageEditor, bpy.types.Panel):
    """Which picture of the panorama is shown."""

    bl_label = "Panorama"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the choice of pictures, and the direction."""
        layout, space = self.layout, context.space_data
        shown = picture_of(space.image if space is not None else None)
        buttons = layout.row(align=True)
        for picture, name, _ in PICTURE_ITEMS:
            button = buttons.operator(
                "spectral_probe.show_panorama",
                text=iface_(name),
                icon=_PICTURE_ICONS[picture],
                depress=shown == picture,
            )
            button.picture = picture
        running = context.window_manager.spectral_probe
        if running.operator == "spectral_probe.show_panorama":
            layout.progress(factor=running.fraction, text=running.message)


class SPECTRAL_PROBE_PT_pick(InImageEditor, bpy.types.Panel):
    """The direction pointed at, and what its light is."""

    bl_label = "Direction"
    bl_parent_id = "SPECTRAL_PROBE_PT_panorama"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the button, the fields and the numbers."""
        layout = self.layout
        chosen = context.scene.spectral_probe.spectrum
        layout.operator("spectral_probe.pick_direction", icon="EYEDROPPER").target = "SPECTRUM"
        column = settings_layout(layout)
        column.prop(chosen, "azimuth")
        column.prop(chosen, "elevation")
        column.prop(chosen, "radius")
        shown = context.window_manager.spectral_probe_panorama
        if shown.has_spectrum:
            _draw_direction(results(layout), shown, chosen)
        layout.operator_menu_enum(
            "spectral_probe.pick_direction", "target", text="Pick for", icon="EYEDROPPER"
        )


def _draw_direction(column: bpy.types.UILayout, shown: Any, chosen: Any) -> None:
    """What was found at the direction pointed at; the numbers of the one taken, while it is the same."""
    place = f"{math.degrees(shown.azimuth) % 360:.1f}°, {math.degrees(shown.elevation):.1f}°"
    row(column, iface_("Direction"), place)
    if shown.problem:
        column.label(text=shown.problem, icon="INFO")
        return
    for number, kind in enumerate(shown.kinds.splitlines()):
        row(column, "" if number else iface_("Kind of Light"), kind)
    row(column, iface_("Confidence"), f"{shown.confidence:.3f}")
    same = abs(shown.azimuth - chosen.azimuth) < 1e-5 and abs(shown.elevation - chosen.elevation) < 1e-5
    if same and chosen.has_numbers and chosen.cct_kelvin:
        row(column, iface_("CCT"), f"{chosen.cct_kelvin:.0f} K")
        row(column, iface_("Ra, Rf"), f"{chosen.ra:.0f}, {chosen.rf:.0f}")


class SPECTRAL_PROBE_PT_region(InImageEditor, bpy.types.Panel):
    """The region in the panorama, and the glass or lamp for it."""

    bl_label = "Glass and Lamps"
    bl_parent_id = "SPECTRAL_PROBE_PT_panorama"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw how the region is given, what is put there, and what was."""
        layout, settings = self.layout, context.scene.spectral_probe
        region = settings.region
        layout.row().prop(region, "kind", expand=True)
        column = settings_layout(layout)
        if region.kind == "SEED":
            column.operator("spectral_probe.pick_direction", icon="EYEDROPPER").target = "EDIT"
            column.prop(region, "azimuth")
            column.prop(region, "elevation")
        elif region.kind == "POLYGON":
            line = column.row(align=True)
            line.operator("spectral_probe.draw_region", icon="GREASEPENCIL").target = "EDIT"
            line.operator("spectral_probe.edit_region", icon="EDITMODE_HLT").target = "EDIT"
            column.prop(region, "polygon")
        else:
            column.template_ID(region, "mask", open="image.open")
            column.operator("spectral_probe.add_mask", icon="BRUSH_DATA")
        layout.separator()
        _draw_choices(layout, context, region)
        draw_list(layout, context, settings.edits)


def _draw_choices(layout: bpy.types.UILayout, context: bpy.types.Context, region: Any) -> None:
    """Glasses and lamps to choose from, and the job that puts one there."""
    running = context.window_manager.spectral_probe.operator
    for verb in ("add_glass", "replace_lamp"):
        if running == f"spectral_probe.{verb}":
            job_button(layout, context, running, "NONE")
            return
    column = layout.column(align=True)
    column.operator("spectral_probe.choose_glass", icon="MOD_LATTICE")
    column.operator("spectral_probe.choose_lamp", icon="LIGHT")
    settings_layout(layout).prop(region, "keeps")


class SPECTRAL_PROBE_PT_other_regions(InImageEditor, bpy.types.Panel):
    """Polygons for other settings."""

    bl_label = "Other Regions"
    bl_parent_id = "SPECTRAL_PROBE_PT_panorama"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        """Draw a row for each setting that has a region."""
        settings = context.scene.spectral_probe
        there = {"LIGHT": len(settings.known_light.regions), "SWAP": len(settings.swap.items)}
        names = {"LIGHT": iface_("Lamps by Region"), "SWAP": iface_("Swap")}
        for target, count in there.items():
            line = self.layout.row(align=True)
            line.enabled = count > 0
            line.label(text=names[target])
            line.operator("spectral_probe.pick_direction", text="", icon="EYEDROPPER").target = target
            line.operator("spectral_probe.draw_region", text="", icon="GREASEPENCIL").target = target
            line.operator("spectral_probe.edit_region", text="", icon="EDITMODE_HLT").target = target

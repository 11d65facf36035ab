"""The photograph behind the scene, and the ground in it."""

from typing import ClassVar

import bpy

from .main import InSidebar, job_button, paragraph, results, row, settings_layout


class SPECTRAL_PROBE_PT_backplate(InSidebar, bpy.types.Panel):
    """Which photograph, and how it is matched."""

    bl_label = "Backplate"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the settings, the button and what matching measured."""
        layout, plate = self.layout, context.scene.spectral_probe.backplate
        column = settings_layout(layout)
        column.prop(plate, "plate")
        column.prop(plate, "view")
        column.prop(plate, "reduce")
        if plate.reduce:
            column.prop(plate, "width_px")
        column.prop(plate, "align")
        column.prop(plate, "srgb")
        column.prop(plate, "exposure_s")
        if plate.exposure_s:
            column.prop(plate, "iso")
            column.prop(plate, "f_number")
        column.prop(plate, "on_ground")
        if not plate.on_ground:
            column.prop(plate, "ground_below")
        job_button(layout, context, "spectral_probe.match_backplate", "CAMERA_DATA")
        if plate.matched:
            _draw_match(results(layout), plate)
            for remark in plate.remarks.splitlines():
                paragraph(results(layout), context, remark, "ERROR")


def _draw_match(column: bpy.types.UILayout, plate: bpy.types.AnyType) -> None:
    if plate.aligned:
        row(column, "Moved", "{:+.2f}, {:+.2f} px".format(*plate.shift_px))
        row(column, "Error", f"{plate.error_px:.2f} px")
    if any(plate.gain):
        row(column, "Brighter By", "{:.2f}, {:.2f}, {:.2f}".format(*plate.gain))
    row(column, "Ground", "{:.2f}, {:.2f}, {:.2f}".format(*plate.ground_mean))


class SPECTRAL_PROBE_PT_ground(InSidebar, bpy.types.Panel):
    """The ground that takes shadows."""

    bl_label = "Ground"
    bl_parent_id = "SPECTRAL_PROBE_PT_backplate"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the settings and the button."""
        layout, plate = self.layout, context.scene.spectral_probe.backplate
        column = settings_layout(layout)
        column.prop(plate, "ground_source", text="Reflectance")
        if plate.ground_source == "GIVEN":
            column.prop(plate, "reflectance", text="Colour")
        column.prop(plate, "ground_radius")
        job_button(layout, context, "spectral_probe.add_ground", "MESH_CIRCLE")

"""Plots of the probe: a direction's spectrum, its basis, the camera, the confidence."""

import math
from typing import ClassVar

import bpy

from .main import InWorld, job_button, results, row, settings_layout


class SPECTRAL_PROBE_PT_plots(InWorld, bpy.types.Panel):
    """Which direction is looked at, and its numbers."""

    bl_label = "Plots"
    bl_parent_id = "SPECTRAL_PROBE_PT_probe"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the direction, the buttons and the numbers."""
        layout, chosen = self.layout, context.scene.spectral_probe.spectrum
        column = settings_layout(layout)
        column.prop(chosen, "azimuth")
        column.prop(chosen, "elevation")
        column.operator("spectral_probe.seed_from_view", icon="VIEW3D").target = "SPECTRUM"
        column.prop(chosen, "radius")
        column.prop(chosen, "measured")
        job_button(layout, context, "spectral_probe.show_spectrum", "GRAPH")
        job_button(layout, context, "spectral_probe.show_basis", "FCURVE")
        job_button(layout, context, "spectral_probe.show_confidence", "IMAGE_DATA")
        layout.operator("spectral_probe.show_sensitivities", icon="CAMERA_DATA")
        if chosen.has_numbers:
            _draw_numbers(results(layout), chosen)


def _draw_numbers(column: bpy.types.UILayout, chosen: bpy.types.AnyType) -> None:
    row(column, "Confidence", f"{chosen.confidence:.3f}")
    if chosen.cct_kelvin:
        row(column, "CCT", f"{chosen.cct_kelvin:.0f} K")
        row(column, "Duv", f"{chosen.duv:.4f}")
        row(column, "Ra, Rf", f"{chosen.ra:.0f}, {chosen.rf:.0f}")
    else:
        row(column, "CCT", "undefined")
    if chosen.has_comparison:
        row(column, "GFC", f"{math.floor(chosen.gfc * 1e4) / 1e4:.4f}")  # 1.0000 is said of no imperfect fit
        row(column, "Relative RMSE", f"{chosen.relative_rmse:.1%}")
        row(column, "ΔE of the Light", f"{chosen.de2000_light:.2f}")

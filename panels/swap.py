"""Lights that can be exchanged after rendering, and their exchange; and what a plan says."""

import bpy
from bpy.app.translations import pgettext_iface as iface_

from .main import InRender, job_button, name_or_file, paragraph, results, row, settings_layout


class SPECTRAL_PROBE_UL_swappable(bpy.types.UIList):
    """One swappable region a row."""

    def draw_item(
        self,
        _context: bpy.types.Context,
        layout: bpy.types.UILayout,
        _data: bpy.types.AnyType,
        item: bpy.types.AnyType,
        _icon: int,
        _active_data: bpy.types.AnyType,
        _active_property: str,
    ) -> None:
        """Draw one row: its name can be changed."""
        layout.prop(item, "name", text="", emboss=False, icon="LIGHT_DATA")


class SPECTRAL_PROBE_PT_swap(InRender, bpy.types.Panel):
    """What can be exchanged, and what takes its place."""

    bl_label = "Swap Light"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the marked regions, then the lights of the render."""
        layout, settings = self.layout, context.scene.spectral_probe
        swap = settings.swap
        line = layout.row()
        line.template_list("SPECTRAL_PROBE_UL_swappable", "", swap, "items", swap, "active_item", rows=2)
        buttons = line.column(align=True)
        buttons.operator("spectral_probe.add_swappable", icon="ADD", text="")
        buttons.operator("spectral_probe.remove_swappable", icon="REMOVE", text="")
        settings_layout(layout).prop(swap, "lamps")
        if not swap.lights:
            paragraph(
                layout.column(align=True),
                context,
                "Choose a region in Glass and Lamps and press +, or switch on Lamps Too; then render.",
                "INFO",
            )
        else:
            column = results(layout)
            for light in swap.lights.splitlines():
                name, _, now = light.partition("\t")
                row(column, name, now)
        column = settings_layout(layout)
        column.prop(swap, "light")
        layout.row().prop(swap, "kind", expand=True)
        _draw_replacement(settings_layout(layout), swap)
        job_button(layout, context, "spectral_probe.swap_light", "FILE_REFRESH")


def _draw_replacement(column: bpy.types.UILayout, swap: bpy.types.AnyType) -> None:
    if swap.kind == "LAMP":
        name_or_file(column, swap, "lamp")
        column.prop(swap, "keeps")
    elif swap.kind == "GLASS":
        name_or_file(column, swap, "glass")


def draw_plan(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    """The button that makes a plan without rendering, and what the last one says; for the panel of the render."""
    job_button(layout, context, "spectral_probe.plan_render", "PRESET")
    planned = context.scene.spectral_probe.planned
    if not planned.passes:
        return
    column = results(layout)
    row(column, "Plan", planned.kind)
    row(column, "Passes", str(planned.passes))
    if planned.max_de2000:
        row(column, "Mean ΔE 2000", f"{planned.mean_de2000:.2f}")
        row(column, "99 % below", f"{planned.max_de2000:.2f}")
    row(column, "Cost", iface_("{cost:.2f} RGB renders").format(cost=planned.cost))
    for sentence in planned.text.splitlines():
        paragraph(column, context, sentence, "NONE")

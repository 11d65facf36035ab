"""Stage 7: how far the RGB render is from the spectral one."""

import bpy
from bpy.app.translations import pgettext_iface as iface_

from .main import InRender, cells, job_button, name_or_file, paragraph, results, row, settings_layout

_MOST_ROWS = 12


class SPECTRAL_PROBE_PT_compare(InRender, bpy.types.Panel):
    """How far RGB is from spectral."""

    bl_label = "Compare"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the settings, the button, the numbers and what can be shown."""
        layout, settings = self.layout, context.scene.spectral_probe
        comparison, chosen = settings.comparison, settings.compare
        column = settings_layout(layout)
        column.prop(settings, "comparison_blur_px")
        column.prop(chosen, "light")
        if chosen.light == "LAMP":
            name_or_file(column, chosen, "lamp")
        elif chosen.light == "DIRECTION":
            column.prop(chosen, "azimuth")
            column.prop(chosen, "elevation")
        column.prop(chosen, "metals")
        job_button(layout, context, "spectral_probe.compare", "IMAGE_DATA")
        if not comparison.directory:
            return
        column = results(layout)
        row(column, "Mean ΔE 2000", f"{comparison.mean_de2000:.2f}")
        row(column, "95 % below", f"{comparison.p95_de2000:.2f}")
        row(column, "Largest", f"{comparison.max_de2000:.2f}")
        row(column, "xy Shift", "{:+.4f}, {:+.4f}".format(*comparison.xy_shift))
        if chosen.objects:
            _draw_objects(results(layout), chosen.objects)
        for warning in comparison.warnings.splitlines():
            paragraph(results(layout), context, warning, "ERROR")
        column = layout.column(align=True)
        column.operator_enum("spectral_probe.show_comparison", "view")
        settings_layout(layout).prop(chosen, "split", slider=True)


def _draw_objects(column: bpy.types.UILayout, objects: bpy.types.AnyType) -> None:
    """A row for each object: its mean and 95th percentile of the colour difference."""
    cells(column, "Object", "ΔE", "95 %", active=False)
    for thing in objects[:_MOST_ROWS]:
        cells(column, thing.name, f"{thing.mean_de2000:.2f}", f"{thing.p95_de2000:.2f}")
    if len(objects) > _MOST_ROWS:
        more = iface_("and {count} more in compare.json").format(count=len(objects) - _MOST_ROWS)
        column.label(text=more, translate=False)

"""The last report of a job, under its button."""

import bpy

_ICONS = {"INFO": "BLANK1", "WARNING": "ERROR", "ERROR": "CANCEL"}


def draw_report(layout: bpy.types.UILayout, context: bpy.types.Context, operator: str) -> None:
    """A box that opens: how the last job of an operator ended, what it told, and a button that copies all of it."""
    from .main import paragraph

    report = context.window_manager.spectral_probe_reports.get(operator)
    if report is None:
        return
    box = layout.box()
    header = box.row()
    opened = header.row()
    opened.alignment = "LEFT"
    arrow = "DOWNARROW_HLT" if report.opened else "RIGHTARROW"
    opened.prop(report, "opened", text="", icon=arrow, emboss=False)
    header.label(text=report.outcome, icon="CHECKMARK" if report.finished else "CANCEL", translate=False)
    header.operator("spectral_probe.copy_report", text="", icon="COPYDOWN", emboss=False).operator = operator
    if report.opened:
        column = box.column(align=True)
        for line in report.lines:
            paragraph(column, context, line.text, _ICONS[line.kind])

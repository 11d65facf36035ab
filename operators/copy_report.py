"""Copy what a job told."""

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.props import StringProperty

from ..spectral_probe.errors import SpectralProbeError
from .base import FINISHED, OperatorResult, ReportsErrors
from .job_report import report_text


class SPECTRAL_PROBE_OT_copy_report(ReportsErrors, bpy.types.Operator):
    """Copy this report as text"""

    bl_idname = "spectral_probe.copy_report"
    bl_label = "Copy Report"
    bl_options = {"INTERNAL"}  # noqa: RUF012  (as Blender wants it; nothing to be undone)

    operator: StringProperty(name="Job", description="Operator whose report is meant", options={"SKIP_SAVE"})

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Put the text into the clipboard."""
        text = report_text(self.operator)
        if not text:
            raise SpectralProbeError(rpt_("There is no report yet. Start the job first."))
        context.window_manager.clipboard = text
        return FINISHED

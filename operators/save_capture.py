"""Write the settings of the scene as a capture file."""

from pathlib import Path

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.props import BoolProperty, StringProperty

from .base import FINISHED, OperatorResult, ReportsErrors
from .polls import has_views
from .settings import capture_from
from .typed import path_text


class SPECTRAL_PROBE_OT_save_capture(ReportsErrors, bpy.types.Operator):
    """Save these settings as a capture file, which the command line reads too"""

    bl_idname = "spectral_probe.save_capture"
    bl_label = "Save Capture"

    filepath: StringProperty(name="File", subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_glob: StringProperty(default="*.toml", options={"HIDDEN"})
    check_existing: BoolProperty(default=True, options={"HIDDEN"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be something to save."""
        return has_views(cls, context)

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        """Ask for the file."""
        self.filepath = context.scene.spectral_probe.capture_path or "capture.toml"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Write the file."""
        from ..spectral_probe.files.capture import save_capture

        settings = context.scene.spectral_probe
        path = Path(bpy.path.ensure_ext(bpy.path.abspath(self.filepath), ".toml"))
        save_capture(capture_from(settings), path)
        settings.capture_path = path_text(path)
        self.report({"INFO"}, rpt_("Saved {file}").format(file=path.name))
        return FINISHED

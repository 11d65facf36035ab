"""Read a capture file into the settings of the scene."""

from pathlib import Path

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.props import StringProperty

from ..spectral_probe.model import Capture
from .base import FINISHED, OperatorResult, ReportsErrors
from .settings import fill


class SPECTRAL_PROBE_OT_import_capture(ReportsErrors, bpy.types.Operator):
    """Read a capture file: the photographs of the ball, the camera, the exposures and the angles"""

    bl_idname = "spectral_probe.import_capture"
    bl_label = "Import Capture"

    filepath: StringProperty(name="File", subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_glob: StringProperty(default="*.toml", options={"HIDDEN"})

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        """Ask for the file, unless one was dropped on the window."""
        if self.filepath:
            return self.execute(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Load the file and fill the settings."""
        from ..spectral_probe.files.capture import load_capture

        path = Path(bpy.path.abspath(self.filepath))
        capture = load_capture(path)
        fill(context.scene.spectral_probe, capture, path)
        self.report({"INFO"}, describe(capture))
        return FINISHED


def describe(capture: Capture) -> str:
    """The number of views and photographs, in words."""
    views, photos = len(capture.views), sum(len(view.photos) for view in capture.views)
    of_views = rpt_("1 view") if views == 1 else rpt_("{count} views").format(count=views)
    of_photos = rpt_("1 photograph") if photos == 1 else rpt_("{count} photographs").format(count=photos)
    return f"{of_views}, {of_photos}"

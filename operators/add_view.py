"""Add and remove views by hand, without a capture file."""

from pathlib import Path

import bpy
from bpy.props import CollectionProperty, StringProperty

from ..spectral_probe.errors import CaptureError
from .base import FINISHED, OperatorResult, ReportsErrors
from .photograph_views import place_views
from .polls import has_views
from .settings import add_photos


class SPECTRAL_PROBE_OT_add_view(ReportsErrors, bpy.types.Operator):
    """Add a view: choose all photographs of its bracket at once"""

    bl_idname = "spectral_probe.add_view"
    bl_label = "Add View"

    directory: StringProperty(subtype="DIR_PATH", options={"SKIP_SAVE"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"SKIP_SAVE"})

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        """Ask for the photographs."""
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Append the view and make it the active one."""
        paths = [Path(self.directory) / file.name for file in self.files if file.name]
        missing = next((path for path in paths if not path.is_file()), None)
        if missing or not paths:
            raise CaptureError(
                f"There is no photograph {missing}." if missing else "Choose at least one photograph."
            )
        settings = context.scene.spectral_probe
        add_photos(settings.views.add(), paths)
        settings.active_view = len(settings.views) - 1
        place_views(settings, range(settings.active_view, len(settings.views)))
        return FINISHED


class SPECTRAL_PROBE_OT_remove_view(ReportsErrors, bpy.types.Operator):
    """Remove the active view; its photographs stay on disk"""

    bl_idname = "spectral_probe.remove_view"
    bl_label = "Remove View"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a view."""
        return has_views(cls, context)

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Remove it and make its neighbour active."""
        settings = context.scene.spectral_probe
        settings.views.remove(settings.active_view)
        settings.active_view = max(0, min(settings.active_view, len(settings.views) - 1))
        return FINISHED

"""Add and remove measured lamps, which join the lamp families."""

from pathlib import Path

import bpy
from bpy.props import CollectionProperty, StringProperty

from ..spectral_probe.errors import CaptureError
from .base import FINISHED, OperatorResult, ReportsErrors
from .typed import path_text


class SPECTRAL_PROBE_OT_add_own_light(ReportsErrors, bpy.types.Operator):
    """Add measured spectra of lamps that may be present: several files at once if you like"""

    bl_idname = "spectral_probe.add_own_light"
    bl_label = "Add Measured Lamp"

    directory: StringProperty(subtype="DIR_PATH", options={"SKIP_SAVE"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"SKIP_SAVE"})

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        """Ask for the files."""
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Append those that can be read."""
        from ..spectral_probe.files.spectrum_csv import read_spectrum_csv

        paths = [Path(self.directory) / file.name for file in self.files if file.name]
        if not paths:
            raise CaptureError("Choose at least one file with a spectrum.")
        for path in paths:
            read_spectrum_csv(path)
        known = context.scene.spectral_probe.known_light
        for path in paths:
            known.own_lights.add().path = path_text(path)
        known.active_own_light = len(known.own_lights) - 1
        return FINISHED


class SPECTRAL_PROBE_OT_remove_own_light(ReportsErrors, bpy.types.Operator):
    """Remove the active lamp; its file stays on disk"""

    bl_idname = "spectral_probe.remove_own_light"
    bl_label = "Remove Measured Lamp"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be one."""
        if context.scene.spectral_probe.known_light.own_lights:
            return True
        cls.poll_message_set("Add a measured lamp first")
        return False

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Remove it and make its neighbour active."""
        known = context.scene.spectral_probe.known_light
        known.own_lights.remove(known.active_own_light)
        known.active_own_light = max(0, min(known.active_own_light, len(known.own_lights) - 1))
        return FINISHED

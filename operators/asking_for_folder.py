"""Jobs on a folder that is chosen in the file browser first."""

import bpy

from .base import FINISHED, OperatorResult
from .job import JobOperator


class AsksForFolder(JobOperator):
    """An operator whose `directory` is asked for where it is not given; the job begins when it was chosen.

    A file browser ends by executing the operator that opened it, which would hold the window up: so it invokes itself anew.
    """

    _asked = False

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        """Ask for the folder."""
        if self.directory or bpy.app.background:
            return super().invoke(context, event)
        self._asked = True
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        """Begin at once in a script; as a job in the window once the folder was chosen."""
        if self._asked:
            verb = self.bl_idname.partition("_OT_")[2]
            getattr(bpy.ops.spectral_probe, verb)("INVOKE_DEFAULT", **self.as_keywords())
            return FINISHED
        return super().execute(context)

"""Let the scene be rendered by Cycles."""

import bpy

from .base import FINISHED, OperatorResult, ReportsErrors


class SPECTRAL_PROBE_OT_use_cycles(ReportsErrors, bpy.types.Operator):
    """Set the render engine to Cycles, which alone knows the refractive index of metals"""

    bl_idname = "spectral_probe.use_cycles"
    bl_label = "Switch to Cycles"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """It must be another engine."""
        if context.scene.render.engine != "CYCLES":
            return True
        cls.poll_message_set("The render engine is Cycles already")
        return False

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Switch."""
        context.scene.render.engine = "CYCLES"
        return FINISHED

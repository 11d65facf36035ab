"""Light the scene with the probe."""

from pathlib import Path

import bpy

from .base import FINISHED, OperatorResult, ReportsErrors
from .polls import has_probe


class SPECTRAL_PROBE_OT_light_world(ReportsErrors, bpy.types.Operator):
    """Light the scene's world with the probe, as ordinary colour; spectral renders use its spectra"""

    bl_idname = "spectral_probe.light_world"
    bl_label = "Light World"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a probe."""
        return has_probe(cls, context)

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Give the scene a world with the probe's panorama."""
        from .bridge.world import light_world

        settings = context.scene.spectral_probe
        light_world(context.scene, Path(bpy.path.abspath(settings.probe_directory)) / "world.exr")
        self.report({"INFO"}, f"{context.scene.world.name} lights the scene")
        return FINISHED

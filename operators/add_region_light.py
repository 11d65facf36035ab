"""Add and remove regions of the panorama whose light is known better than that of the rest."""

import bpy

from .base import FINISHED, OperatorResult, ReportsErrors


class SPECTRAL_PROBE_OT_add_region_light(ReportsErrors, bpy.types.Operator):
    """Add a region with lamp families, or a measured spectrum, of its own"""

    bl_idname = "spectral_probe.add_region_light"
    bl_label = "Add Region"

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Append it and make it the active one."""
        known = context.scene.spectral_probe.known_light
        region = known.regions.add()
        region.name = f"Region {len(known.regions)}"
        known.active_region = len(known.regions) - 1
        return FINISHED


class SPECTRAL_PROBE_OT_remove_region_light(ReportsErrors, bpy.types.Operator):
    """Remove the active region"""

    bl_idname = "spectral_probe.remove_region_light"
    bl_label = "Remove Region"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be one."""
        if context.scene.spectral_probe.known_light.regions:
            return True
        cls.poll_message_set("Add a region first")
        return False

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Remove it and make its neighbour active."""
        known = context.scene.spectral_probe.known_light
        known.regions.remove(known.active_region)
        known.active_region = max(0, min(known.active_region, len(known.regions) - 1))
        return FINISHED

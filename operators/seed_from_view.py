"""Take the direction that the 3D viewport looks in as the seed of a region."""

import math

import bpy
from mathutils import Euler, Quaternion, Vector

from .base import FINISHED, OperatorResult, ReportsErrors


class SPECTRAL_PROBE_OT_seed_from_view(ReportsErrors, bpy.types.Operator):
    """Take the direction in the middle of the viewport: look at a window or lamp of the world, then press this"""

    bl_idname = "spectral_probe.seed_from_view"
    bl_label = "From View"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a 3D viewport."""
        if context.region_data is not None:
            return True
        cls.poll_message_set("Use this in the sidebar of a 3D viewport")
        return False

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Put bearing and elevation into the panel."""
        from .bridge.world import placement

        settings = context.scene.spectral_probe.region
        turn, _ = placement(context.scene.world)
        settings.azimuth, settings.elevation = bearing_of_view(context.region_data.view_rotation, turn)
        settings.kind = "SEED"
        return FINISHED


def bearing_of_view(view: Quaternion, turn: tuple[float, float, float]) -> tuple[float, float]:
    """Compass bearing (0 to 2 pi) and elevation in radians, in a panorama turned by `turn`, that a view looks in."""
    direction = Euler(turn).to_matrix().inverted() @ (view @ Vector((0.0, 0.0, -1.0)))
    azimuth = math.atan2(direction.x, direction.y) % (2 * math.pi)
    return azimuth, math.asin(max(-1.0, min(1.0, direction.z)))

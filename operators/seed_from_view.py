"""Take the direction that the 3D viewport looks in: as the seed of a region, or to see its spectrum."""

import math

import bpy
from bpy.props import EnumProperty
from mathutils import Euler, Quaternion, Vector

from .base import FINISHED, OperatorResult, ReportsErrors
from .direction_target import TARGETS, put_direction


class SPECTRAL_PROBE_OT_seed_from_view(ReportsErrors, bpy.types.Operator):
    """Take the direction in the middle of the viewport: look at a window or lamp of the world, then press this"""

    bl_idname = "spectral_probe.seed_from_view"
    bl_label = "From View"

    target: EnumProperty(
        name="For",
        description="What the direction is for",
        items=TARGETS,
        default="EDIT",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a 3D viewport."""
        if _viewport(context) is not None:
            return True
        cls.poll_message_set("Open a 3D viewport in this window, and look at the window or lamp in it")
        return False

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Put bearing and elevation into the panel."""
        from .bridge.world import placement

        turn, _ = placement(context.scene.world)
        azimuth, elevation = bearing_of_view(_viewport(context).view_rotation, turn)
        put_direction(context.scene.spectral_probe, self.target, azimuth, elevation)
        return FINISHED


def _viewport(context: bpy.types.Context) -> bpy.types.RegionView3D | None:
    """The viewport that the button is beside, else the largest of its window; None where there is none."""
    if context.region_data is not None:
        return context.region_data
    areas = context.screen.areas if context.screen is not None else ()
    viewports = [area for area in areas if area.type == "VIEW_3D"]
    largest = max(viewports, key=lambda area: area.width * area.height, default=None)
    return largest.spaces.active.region_3d if largest is not None else None


def bearing_of_view(view: Quaternion, turn: tuple[float, float, float]) -> tuple[float, float]:
    """Compass bearing (0 to 2 pi) and elevation in radians, in a panorama turned by `turn`, that a view looks in."""
    direction = Euler(turn).to_matrix().inverted() @ (view @ Vector((0.0, 0.0, -1.0)))
    azimuth = math.atan2(direction.x, direction.y) % (2 * math.pi)
    return azimuth, math.asin(max(-1.0, min(1.0, direction.z)))

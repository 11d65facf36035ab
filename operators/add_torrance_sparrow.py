"""Give the active object a Torrance-Sparrow surface."""

import math

import bpy
from bpy.props import FloatProperty

from ..settings.material import metal_name
from .base import FINISHED, OperatorResult, ReportsErrors


class SPECTRAL_PROBE_OT_add_torrance_sparrow(ReportsErrors, bpy.types.Operator):
    """Give the active object a new material after Torrance and Sparrow: diffuse, a lobe of facets, a mirror of measured metal"""

    bl_idname = "spectral_probe.add_torrance_sparrow"
    bl_label = "Add Torrance-Sparrow"

    metal: metal_name()
    alpha: FloatProperty(
        name="Alpha",
        description="Weight of diffuse reflection per steradian; 0.318 reflects all of the diffuse colour",
        default=0.0,
        min=0.0,
        max=4.0 / math.pi,
        soft_max=1.0 / math.pi,
        precision=3,
    )
    beta: FloatProperty(
        name="Beta",
        description="Height of the specular lobe per steradian; smooth surfaces need much, as their lobe is narrow",
        default=2.8,
        min=0.0,
        max=1000.0,
        soft_max=50.0,
    )
    beta_mirror: FloatProperty(
        name="Beta Mirror",
        description="Weight beta' of perfect mirror reflection; 1 reflects as a polished metal does",
        default=0.0,
        min=0.0,
        max=4.0,
        soft_max=1.0,
    )
    gamma_rad: FloatProperty(
        name="Gamma",
        description="Angle of a facet to the surface at which the lobe has half its height",
        default=math.radians(8.0),
        min=math.radians(0.1),
        max=math.pi / 4,  # beckmann.WIDEST_GAMMA_RAD, which would bring numpy to Blender's start
        subtype="ANGLE",
        unit="ROTATION",
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be an object that carries materials."""
        thing = context.object
        if thing is None or not hasattr(thing.data, "materials"):
            cls.poll_message_set("Select an object that can have a material first")
            return False
        if thing.library or thing.data.library:
            cls.poll_message_set("The object is linked from another file. Make it local first")
            return False
        return True

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Put the material into the active slot, or into a first one."""
        from .bridge.torrance_sparrow import torrance_sparrow_material

        material = torrance_sparrow_material(
            "Torrance-Sparrow",
            metal=self.metal,
            alpha=self.alpha,
            beta=self.beta,
            beta_mirror=self.beta_mirror,
            gamma_rad=self.gamma_rad,
        )
        if context.object.material_slots:
            context.object.active_material = material
        else:
            context.object.data.materials.append(material)
        return FINISHED

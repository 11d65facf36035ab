"""Add the objects of the paper: the gold pedestal, the silver ball, the copper ball."""

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.props import BoolProperty, EnumProperty, FloatProperty

from .base import FINISHED, OperatorResult, ReportsErrors
from .polls import in_object_mode
from .viewport import look_through_camera


class SPECTRAL_PROBE_OT_add_object(ReportsErrors, bpy.types.Operator):
    """Add an object of measured metal at the 3D cursor"""

    bl_idname = "spectral_probe.add_object"
    bl_label = "Add Metal Object"

    kind: EnumProperty(
        name="Object",
        description="Object to add",
        items=(
            ("GOLD_PEDESTAL", "Gold Pedestal", "A pedestal of gold, to stand the balls on"),
            ("SILVER_BALL", "Silver Ball", "A small ball of silver"),
            ("COPPER_BALL", "Copper Ball", "A large ball of copper"),
            ("GROUP", "All Three", "The pedestal with the silver ball on it, and the copper ball beside it"),
        ),
    )
    size: FloatProperty(
        name="Size",
        description="Size of the object, as a multiple: at 1 the pedestal is 0.5 m high and the copper ball 0.34 m wide. "
        "On a matched photograph the copper ball is as large as the mirrored ball was, unless this is given",
        default=1.0,
        min=0.001,
        soft_min=0.05,
        soft_max=10.0,
        options={"SKIP_SAVE"},
    )

    replace_startup: BoolProperty(
        name="Replace Start-Up Scene",
        description="With all three: remove the cube and the lamp of Blender's start-up scene, and aim its camera at the "
        "objects, as far as nobody has touched them",
        default=True,
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Objects are added in object mode."""
        return in_object_mode(cls, context)

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Add it and make it the active object."""
        from .bridge import objects

        if context.scene.spectral_probe.backplate.matched and not self.properties.is_property_set("size"):
            self.size = _size_beside_ball(context.scene)
        add = {
            "GOLD_PEDESTAL": lambda *where: [objects.add_gold_pedestal(*where)],
            "SILVER_BALL": lambda *where: [objects.add_silver_ball(*where)],
            "COPPER_BALL": lambda *where: [objects.add_copper_ball(*where)],
            "GROUP": lambda collection, at, size: objects.add_metals(collection, at, scale=size),
        }[self.kind]
        added = add(context.collection, context.scene.cursor.location, self.size)
        for selected in context.selected_objects:
            selected.select_set(False)
        for thing in added:
            thing.select_set(True)
        context.view_layer.objects.active = added[0]
        if self.kind == "GROUP" and self.replace_startup:
            self._replace_startup(context)
        return FINISHED

    def _replace_startup(self, context: bpy.types.Context) -> None:
        """The start-up cube would hide the objects, its lamp add to the light that was photographed."""
        from .bridge.objects import aim_at_metals
        from .bridge.startup_scene import startup_camera, startup_cube_and_lamp

        old, camera = startup_cube_and_lamp(context.scene), startup_camera(context.scene)
        names = ", ".join(thing.name for thing in old)
        for thing in old:
            bpy.data.objects.remove(thing)
        if names:
            self.report({"INFO"}, rpt_("Removed from the start-up scene: {names}").format(names=names))
        if camera is not None:
            aim_at_metals(camera, context.scene.cursor.location, scale=self.size)
            look_through_camera(context)


def _size_beside_ball(scene: bpy.types.Scene) -> float:
    """The size at which the copper ball is as large as the mirrored ball of the scene's plate."""
    from .bridge.backplate import scene_backplate
    from .bridge.objects import scale_beside_ball

    found = scene_backplate(scene)  # None where the camera was moved since
    if found is None:
        return scale_beside_ball(scene.spectral_probe.ball_radius)
    return scale_beside_ball(found.ball_radius_m / scene.unit_settings.scale_length)

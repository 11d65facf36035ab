"""Make a material or a lamp an entry of the library."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ..spectral_probe.errors import SpectralDataError
from .base import FINISHED, OperatorResult, ReportsErrors

type Owner = bpy.types.Material | bpy.types.Light


class SPECTRAL_PROBE_OT_choose_spectrum(ReportsErrors, bpy.types.Operator):
    """Make the active material or lamp a metal, a glass, a measured surface or a lamp of the library"""

    bl_idname = "spectral_probe.choose_spectrum"
    bl_label = "Choose Spectrum"

    kind: EnumProperty(
        name="Kind",
        description="What is chosen",
        items=(
            (
                "METAL",
                "Metal",
                "A metal, by its symbol, its English name or its page of refractiveindex.info",
            ),
            ("REFLECTANCE", "Reflectance", "A measured surface"),
            ("GLASS", "Coloured Glass", "A stained glass"),
            ("DISPERSIVE", "Dispersive Glass", "A clear material"),
            ("LAMP", "Lamp", "The light of a lamp, or what a material emits"),
        ),
    )
    entry: StringProperty(name="Name", description="Name in the library", default="Au")
    set_look: BoolProperty(
        name="Set Look Too",
        description="Also set colours of the shaders for the viewport and RGB renders, as they are under D65. What is linked "
        "stays, and nothing is deleted",
        default=True,
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a material or a lamp of this file, or an object that can have a material."""
        owner = _owner(context)
        if owner is not None and not owner.is_editable:
            cls.poll_message_set("It is linked from another file. Make it local first")
            return False
        if owner is None and not _can_have_material(context):
            cls.poll_message_set("Select an object that can have a material, or a lamp, first")
            return False
        return True

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Set it, and say what of its look was left."""
        from .bridge.choosing import check_entry, choose

        check_entry(self.kind, self.entry)
        owner = _owner(context)
        if self.kind != "LAMP" and isinstance(owner, bpy.types.Light):
            raise SpectralDataError(
                "The active object is a lamp. Choose a lamp for it, or select what has a surface."
            )
        if owner is None:
            owner = _new_material(context.object, self.entry)
        for left in choose(owner, self.kind, self.entry, look=self.set_look):
            self.report({"INFO"}, left)
        return FINISHED


def _owner(context: bpy.types.Context) -> Owner | None:
    """The material or lamp of the properties editor, or of the active object."""
    shown = getattr(context, "material", None) or getattr(context, "light", None)
    if shown is not None or context.object is None:
        return shown
    data = context.object.data
    return data if isinstance(data, bpy.types.Light) else context.object.active_material


def _can_have_material(context: bpy.types.Context) -> bool:
    thing = context.object
    return thing is not None and hasattr(thing.data, "materials") and thing.data.is_editable


def _new_material(thing: bpy.types.Object, name: str) -> bpy.types.Material:
    material = bpy.data.materials.new(name.rpartition(": ")[2])
    if thing.material_slots:
        thing.active_material = material
    else:
        thing.data.materials.append(material)
    return material

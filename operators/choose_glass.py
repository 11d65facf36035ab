"""Choose a glass or a lamp from a list that can be searched, and put it into the region at once."""

from __future__ import annotations

from functools import lru_cache

import bpy
from bpy.props import EnumProperty

from .base import CANCELLED, FINISHED, OperatorResult, ReportsErrors
from .polls import has_probe, has_region

type Items = list[tuple[str, str, str]]


@lru_cache(maxsize=1)
def _glasses() -> Items:
    """Blender keeps no reference to the texts of a list that a function makes: they are kept here."""
    from ..spectral_probe.spectra.glass import GLASSES

    return [(name, name, "") for name in GLASSES]


@lru_cache(maxsize=1)
def _lamps() -> Items:
    from ..spectral_probe.spectra.catalogue import catalogue

    return [(entry.name, f"{entry.name} ({entry.family})", "") for entry in catalogue("lamp")]


def _glass_items(_operator: bpy.types.Operator, _context: bpy.types.Context | None) -> Items:
    return _glasses()


def _lamp_items(_operator: bpy.types.Operator, _context: bpy.types.Context | None) -> Items:
    return _lamps()


class ChoosesFromList(ReportsErrors):
    """Mixin: an operator with a list to search; `run` is called with what was chosen."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a probe and a region."""
        return has_probe(cls, context) and has_region(cls, context)

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        """Open the list."""
        context.window_manager.invoke_search_popup(self)
        return {"RUNNING_MODAL"}

    def put(self, verb: str) -> OperatorResult:
        """Start the operator that puts it into the region."""
        how = "EXEC_DEFAULT" if bpy.app.background else "INVOKE_DEFAULT"
        try:
            getattr(bpy.ops.spectral_probe, verb)(how, True)
        except RuntimeError as problem:  # what that operator reported
            self.report({"ERROR"}, str(problem).strip().removeprefix("Error: "))
            return CANCELLED
        return FINISHED


class SPECTRAL_PROBE_OT_choose_glass(ChoosesFromList, bpy.types.Operator):
    """Search the stained glasses and put one before the region"""

    bl_idname = "spectral_probe.choose_glass"
    bl_label = "Choose Glass"
    bl_property = "glass"

    glass: EnumProperty(name="Glass", description="Stained glass put before the region", items=_glass_items)

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Put it there as Add Glass does."""
        region = context.scene.spectral_probe.region
        region.glass, region.glass_path = self.glass, ""
        return self.put("add_glass")


class SPECTRAL_PROBE_OT_choose_lamp(ChoosesFromList, bpy.types.Operator):
    """Search the lamps of the library and give the region's light the spectrum of one"""

    bl_idname = "spectral_probe.choose_lamp"
    bl_label = "Choose Lamp"
    bl_property = "lamp"

    lamp: EnumProperty(
        name="Lamp", description="Lamp whose light takes the place of the region's", items=_lamp_items
    )

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Put it there as Replace Lamp does."""
        region = context.scene.spectral_probe.region
        region.lamp, region.lamp_path = self.lamp, ""
        return self.put("replace_lamp")

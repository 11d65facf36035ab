"""Put the library of spectral materials into Blender's asset browser, and take it out."""

from __future__ import annotations

from typing import ClassVar

import bpy

from ..preferences import addon_preferences
from .base import FINISHED, OperatorResult, ReportsErrors
from .bridge.asset_library import add_entry, entries, remove_entries


class SPECTRAL_PROBE_OT_add_asset_library(ReportsErrors, bpy.types.Operator):
    """Add the spectral metals, glasses and measured surfaces to the asset libraries of Blender's preferences"""

    bl_idname = "spectral_probe.add_asset_library"
    bl_label = "Add Asset Library"
    bl_options: ClassVar[set[str]] = {"REGISTER"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """It must not be there."""
        if entries():
            cls.poll_message_set(
                "The asset library is there. Open the Asset Browser and choose Spectral Probe"
            )
            return False
        return True

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Add it, and remember that it is wanted."""
        add_entry()
        _remember(context, wanted=True)
        return FINISHED


class SPECTRAL_PROBE_OT_remove_asset_library(ReportsErrors, bpy.types.Operator):
    """Take the spectral materials out of the asset libraries of Blender's preferences. Materials in use stay"""

    bl_idname = "spectral_probe.remove_asset_library"
    bl_label = "Remove Asset Library"
    bl_options: ClassVar[set[str]] = {"REGISTER"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """It must be there."""
        if not entries():
            cls.poll_message_set("The asset library is not in the preferences")
            return False
        return True

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Remove it, and remember that it is not wanted."""
        remove_entries()
        _remember(context, wanted=False)
        return FINISHED


def _remember(context: bpy.types.Context, *, wanted: bool) -> None:
    chosen = addon_preferences()
    if chosen is not None:
        chosen.asset_library = wanted
    context.preferences.is_dirty = True  # saved with the preferences, on exit as a rule


def register() -> None:
    """Put the library into the preferences where it is wanted."""
    chosen = addon_preferences()
    if chosen is not None and chosen.asset_library:
        add_entry()


def unregister() -> None:
    """Leave no entry behind that leads nowhere."""
    remove_entries()

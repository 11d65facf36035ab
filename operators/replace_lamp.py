"""Put another lamp into a region of the light."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from .region import ChangesRegion

if TYPE_CHECKING:
    from ..spectral_probe.editing import Change


class SPECTRAL_PROBE_OT_replace_lamp(ChangesRegion, bpy.types.Operator):
    """Give the region's light the spectrum of another lamp; it can be taken back at any time"""

    bl_idname = "spectral_probe.replace_lamp"
    bl_label = "Replace Lamp"

    def change(self, settings: bpy.types.PropertyGroup) -> Change:
        """The lamp of the panel."""
        from ..spectral_probe.editing import Change

        path = bpy.path.abspath(settings.lamp_path)
        return Change("lamp", path or settings.lamp, settings.keeps, settings.was or None)

"""Put a stained glass before a region of the light."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from .region import ChangesRegion

if TYPE_CHECKING:
    from ..spectral_probe.editing import Change


class SPECTRAL_PROBE_OT_add_glass(ChangesRegion, bpy.types.Operator):
    """Put a stained glass before the region; it can be taken back at any time"""

    bl_idname = "spectral_probe.add_glass"
    bl_label = "Add Glass"

    def change(self, settings: bpy.types.PropertyGroup) -> Change:
        """The glass of the panel."""
        from ..spectral_probe.editing import Change

        path = bpy.path.abspath(settings.glass_path)
        return Change("glass", path or settings.glass)

"""Mark the region of the panel as one whose light can be exchanged after rendering, or take the mark away."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from ..spectral_probe.errors import RenderError
from .base import FINISHED, OperatorResult, ReportsErrors
from .polls import has_region
from .region import region_from

if TYPE_CHECKING:
    from collections.abc import Callable

    from ..spectral_probe.model import BoolArray, SpectralPanorama

_REGION = ("kind", "azimuth", "elevation", "polygon", "mask")


def marked_regions(settings: bpy.types.PropertyGroup) -> dict[str, Callable[[SpectralPanorama], BoolArray]]:
    """What finds each of the marked regions in a panorama, by name; it touches no Blender data.

    Raises
    ------
    SpectralProbeError
        If two have one name, or a region cannot be used.
    """
    regions: dict[str, Callable[[SpectralPanorama], BoolArray]] = {}
    for item in settings.swap.items:
        if item.name in regions:
            raise RenderError(f'Two swappable regions are called "{item.name}". Give each a name of its own.')
        _, regions[item.name] = region_from(item)
    return regions


def marked_masks(settings: bpy.types.PropertyGroup, panorama: SpectralPanorama) -> dict[str, BoolArray]:
    """The marked regions as masks (H, W) of a panorama by name, for the render of a scene with these settings."""
    return {name: find(panorama) for name, find in marked_regions(settings).items()}


class SPECTRAL_PROBE_OT_add_swappable(ReportsErrors, bpy.types.Operator):
    """Give the region's light layers of its own, so that its lamp or glass can be exchanged after rendering"""

    bl_idname = "spectral_probe.add_swappable"
    bl_label = "Make Region Swappable"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """The region of the panel must be given."""
        return has_region(cls, context)

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Keep a copy of the region."""
        settings = context.scene.spectral_probe
        region_from(settings.region)  # refuses what is no region
        taken = {item.name for item in settings.swap.items}
        item = settings.swap.items.add()
        item.name = next(name for number in range(1, 1000) if (name := f"light {number}") not in taken)
        for name in _REGION:
            setattr(item, name, getattr(settings.region, name))
        settings.swap.active_item = len(settings.swap.items) - 1
        return FINISHED


class SPECTRAL_PROBE_OT_remove_swappable(ReportsErrors, bpy.types.Operator):
    """Take the mark from the region: its light is rendered with all other light again"""

    bl_idname = "spectral_probe.remove_swappable"
    bl_label = "Not Swappable"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a marked region."""
        swap = context.scene.spectral_probe.swap
        if swap.active_item < len(swap.items):
            return True
        cls.poll_message_set("Make a region swappable first")
        return False

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Remove the active one."""
        swap = context.scene.spectral_probe.swap
        swap.items.remove(swap.active_item)
        swap.active_item = max(0, min(swap.active_item, len(swap.items) - 1))
        return FINISHED

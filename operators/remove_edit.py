"""Take a glass or a lamp back."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty

from .polls import has_edits, has_probe
from .region import EditsLight

if TYPE_CHECKING:
    from ..spectral_probe.model import SpectralPanorama


class SPECTRAL_PROBE_OT_remove_edit(EditsLight, bpy.types.Operator):
    """Take the active glass or lamp back; the light under it is restored exactly"""

    bl_idname = "spectral_probe.remove_edit"
    bl_label = "Remove"

    everything: BoolProperty(name="All", description="Take all glasses and lamps back", options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be something to take back."""
        return has_probe(cls, context) and has_edits(cls, context)

    def edit(self, context: bpy.types.Context) -> "Callable[[SpectralPanorama], SpectralPanorama]":
        """Take the active edit back, or all."""
        from ..spectral_probe.spectra.edits import remove_all_edits, remove_edit

        if self.everything:
            return remove_all_edits
        edits = context.scene.spectral_probe.edits
        number = min(edits.active_edit, len(edits.items) - 1)
        return lambda panorama: remove_edit(panorama, number)

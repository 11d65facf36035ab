"""A mask to paint on: the panorama's preview, transparent."""

from pathlib import Path

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from .base import FINISHED, OperatorResult, ReportsErrors
from .polls import has_probe
from .settings import probe_folder


class SPECTRAL_PROBE_OT_add_mask(ReportsErrors, bpy.types.Operator):
    """Make a mask to paint on: the panorama, transparent. Paint white in the Image Editor, with its channels set to Colour"""

    bl_idname = "spectral_probe.add_mask"
    bl_label = "New Mask"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a probe."""
        return has_probe(cls, context)

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Make the image and choose it as the mask."""
        from .bridge.images import transparent_copy

        settings = context.scene.spectral_probe
        image = transparent_copy(Path(probe_folder(settings)) / "preview.png", "Spectral Probe Mask")
        settings.region.kind, settings.region.mask = "MASK", image
        self.report({"INFO"}, rpt_("Paint white on {image} in the Image Editor").format(image=image.name))
        return FINISHED

"""Light the scene with the probe."""

from pathlib import Path

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.props import BoolProperty, FloatProperty

from .base import FINISHED, OperatorResult, ReportsErrors
from .polls import has_probe
from .settings import probe_folder
from .viewport import show_world

WORLD_NAME = "world.exr"
"""The panorama in ordinary colour, among the files of a probe."""


class SPECTRAL_PROBE_OT_light_world(ReportsErrors, bpy.types.Operator):
    """Light the scene's world with the probe, as ordinary colour; spectral renders use its spectra"""

    bl_idname = "spectral_probe.light_world"
    bl_label = "Light World"

    normalise: BoolProperty(
        name="Normalise",
        description="Scale the light to a mean of 1, which suits a camera at exposure 0. A probe's own unit is "
        "that of the photographs",
        default=True,
    )
    strength: FloatProperty(
        name="Strength", description="Factor on the light", default=1.0, min=0.0, soft_max=10.0
    )
    rotation: FloatProperty(
        name="Rotation", description="Turn of the light, counter-clockwise seen from above", subtype="ANGLE"
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a probe."""
        return has_probe(cls, context)

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Give the scene a world with the probe's panorama."""
        from .bridge.world import light_world

        path = probe_folder(context.scene.spectral_probe) / WORLD_NAME
        strength = self.strength / mean_luminance(path) if self.normalise else self.strength
        light_world(context.scene, path, rotation_rad=self.rotation, strength=strength)
        show_world(context)
        self.report({"INFO"}, rpt_("{world} lights the scene").format(world=context.scene.world.name))
        return FINISHED


def mean_luminance(path: Path) -> float:
    """Mean luminance over all directions of a panorama in linear Rec.709; 1 for a black one."""
    import numpy as np

    from ..spectral_probe.files.image_exr import read_rgb
    from ..spectral_probe.geometry.frames import panorama_solid_angles
    from ..spectral_probe.spectra.colorimetry import rec709_to_xyz

    luminance = rec709_to_xyz(read_rgb(path))[..., 1]
    weights = panorama_solid_angles(*luminance.shape)
    mean = float(np.average(luminance, weights=np.broadcast_to(weights, luminance.shape)))
    return mean if mean > 0 else 1.0

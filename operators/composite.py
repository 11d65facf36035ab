"""Put the spectral render into its photograph."""

from pathlib import Path
from typing import Any

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..spectral_probe.model import Job
from .job import JobOperator
from .pictures import show
from .polls import has_probe, has_render_files
from .results import kept_path
from .settings import folder_of, probe_folder

type Numbers = dict[str, Any]

FOLDER = "composite"
"""Within the folder of the render."""


class SPECTRAL_PROBE_OT_composite(JobOperator, bpy.types.Operator):
    """Put the spectral render into its photograph, with its shadows, in the colours of the photograph's camera"""

    bl_idname = "spectral_probe.composite"
    bl_label = "Composite"

    in_thread = True
    needs = ("..spectral_probe.composite.composite",)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a render, and the probe where it is the background."""
        panorama = context.scene.spectral_probe.composite.background == "PROBE"
        return has_render_files(cls, context, "xyz.exr", "Render the scene spectrally first") and (
            not panorama or has_probe(cls, context)
        )

    def job(self, context: bpy.types.Context) -> Job[Numbers]:
        """Read the settings and start."""
        from ..spectral_probe.composite.composite import CompositeSettings, composite
        from ..spectral_probe.composite.plate_photo import SRGB, PlateSettings

        scene_settings = context.scene.spectral_probe
        settings = scene_settings.composite
        rendered = folder_of(scene_settings.render_directory, "render")
        plate = Path(bpy.path.abspath(settings.plate)) if settings.plate else None
        if settings.background == "PROBE":
            plate = probe_folder(scene_settings) / "probe.exr"
        known = PlateSettings(
            response=SRGB if settings.srgb else None,
            camera=settings.camera.strip() or None,
            exposure_s=settings.exposure_s or None,
        )
        return composite(
            rendered, plate, rendered / FOLDER, CompositeSettings(known, denoised=settings.denoised)
        )

    def done(self, context: bpy.types.Context, result: Numbers) -> None:
        """Keep the numbers in the scene, show the picture, and say what is less than right."""
        settings = context.scene.spectral_probe.composite
        settings.directory = kept_path(result["written"], context.scene.spectral_probe.render_directory)
        settings.changed_fraction = result["changed_fraction"]
        settings.remarks = "\n".join(result["remarks"])
        pictures = [Path(result["written"]) / f"{name}.png" for name in (settings.show, "composite")]
        show(next(path for path in pictures if path.is_file()), "Composite")
        told = rpt_("{share:.1%} of the photograph was changed")
        self.tell("INFO", told.format(share=settings.changed_fraction))
        for remark in result["remarks"]:
            self.tell("WARNING", remark)

"""Render the scene spectrally in the light of the probe."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import bpy

from ..spectral_probe.model import Job
from .job import JobOperator
from .pictures import show
from .polls import has_probe, uses_cycles
from .results import keep_render
from .settings import folder_of, probe_folder

if TYPE_CHECKING:
    from .bridge.cycles import SpectralRender


class SPECTRAL_PROBE_OT_render_spectral(JobOperator, bpy.types.Operator):
    """Render the scene in Cycles at several wavelengths and put the passes together into one image"""

    bl_idname = "spectral_probe.render_spectral"
    bl_label = "Render Spectral"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a probe, and Cycles."""
        return has_probe(cls, context) and uses_cycles(cls, context)

    def job(self, context: bpy.types.Context) -> Job[SpectralRender]:
        """Read the settings and start."""
        from ..spectral_probe.files.probe_exr import read_probe
        from .bridge.cycles import spectral_render

        settings = context.scene.spectral_probe
        directory = folder_of(settings.render_directory, "render")
        probe = read_probe(probe_folder(settings) / "probe.exr")
        return spectral_render(
            context.scene,
            probe,
            None,
            directory,
            samples=settings.samples,
            passes={"AUTOMATIC": None, "NUMBER": settings.passes, "REFERENCE": "all"}[settings.plan],
            rgb_twin=settings.rgb_twin,
        )

    def done(self, context: bpy.types.Context, result: SpectralRender) -> None:
        """Keep the report's numbers in the scene."""
        settings = context.scene.spectral_probe
        keep_render(settings, result)
        show(write_preview(result.xyz), "Render")
        self.report({"INFO"}, f"{settings.render.passes} passes in {settings.render.seconds:.1f} s")
        for warning in result.warnings:
            self.report({"WARNING"}, warning)


def write_preview(xyz_path: Path) -> Path:
    """Write preview.png beside the tristimulus values, exposed for them: they are in the unit of the photographs."""
    import numpy as np

    from ..spectral_probe.figures.display import exposure_for_white, tone_map, write_png
    from ..spectral_probe.files.image_exr import read_rgb
    from ..spectral_probe.render.compare import WHITE_PERCENTILE

    xyz = read_rgb(xyz_path, ("X", "Y", "Z"))
    white = float(np.percentile(xyz[..., 1], WHITE_PERCENTILE))
    path = xyz_path.with_name("preview.png")
    write_png(path, tone_map(xyz, exposure_for_white(white) if white > 0 else 1.0))
    return path

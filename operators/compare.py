"""Compare the spectral render with the RGB render of the same scene."""

from pathlib import Path
from typing import Any

import bpy

from ..spectral_probe.model import Job
from .job import JobOperator
from .pictures import show
from .polls import has_render
from .results import keep_comparison

type Numbers = dict[str, Any]


class SPECTRAL_PROBE_OT_compare(JobOperator, bpy.types.Operator):
    """Measure how far the RGB render is from the spectral one, and show both with a map of the differences"""

    bl_idname = "spectral_probe.compare"
    bl_label = "Compare"

    in_thread = True

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be both renders."""
        return has_render(cls, context)

    def job(self, context: bpy.types.Context) -> Job[Numbers]:
        """Compare the two files of the render folder."""
        from ..spectral_probe.compare_command import CompareSettings, compare

        settings = context.scene.spectral_probe
        rendered = Path(bpy.path.abspath(settings.render_directory))
        return compare(
            rendered / "xyz.exr",
            rendered / "rgb.exr",
            rendered / "comparison",
            CompareSettings(settings.comparison_blur_px),
        )

    def done(self, context: bpy.types.Context, result: Numbers) -> None:
        """Keep the numbers in the scene and show the sheet."""
        settings = context.scene.spectral_probe
        keep_comparison(settings, result)
        show(Path(result["written"]) / "sheet.png", "Comparison")
        self.report(
            {"INFO"}, f"RGB differs from spectral by ΔE {settings.comparison.mean_de2000:.2f} on average"
        )

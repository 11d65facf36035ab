"""Compare the spectral render with the RGB render of the same scene."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..spectral_probe.model import Job
from .job import JobOperator
from .pictures import show
from .polls import has_probe, has_render
from .results import keep_comparison
from .settings import probe_folder

if TYPE_CHECKING:
    from ..spectral_probe.compare_command import CompareSettings

type Numbers = dict[str, Any]


def compare_settings_from(settings: bpy.types.PropertyGroup) -> CompareSettings:
    """What the panel asks for."""
    from ..spectral_probe.compare_command import CompareSettings

    chosen = settings.compare
    light, at = "", None
    if chosen.light == "LAMP":
        light = bpy.path.abspath(chosen.lamp_path) or chosen.lamp
    elif chosen.light != "RENDER":
        light = str(probe_folder(settings) / "probe.exr")
    if chosen.light == "DIRECTION":
        at = (math.degrees(chosen.azimuth) % 360, math.degrees(chosen.elevation))
    metals = tuple(name.strip() for name in chosen.metals.split(",") if name.strip())
    return CompareSettings(settings.comparison_blur_px, light, at, None, metals, chosen.split)


class SPECTRAL_PROBE_OT_compare(JobOperator, bpy.types.Operator):
    """Measure how far the RGB render is from the spectral one, and show both with a map of the differences"""

    bl_idname = "spectral_probe.compare"
    bl_label = "Compare"

    in_thread = True
    needs = ("..spectral_probe.compare_command",)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be both renders, and the probe where its light is asked for."""
        if not has_render(cls, context):
            return False
        of_probe = context.scene.spectral_probe.compare.light in {"PROBE", "DIRECTION"}
        return not of_probe or has_probe(
            cls, context, "Build the probe first, or choose another light to compare in"
        )

    def job(self, context: bpy.types.Context) -> Job[Numbers]:
        """Compare the two files of the render folder."""
        from ..spectral_probe.compare_command import compare

        settings = context.scene.spectral_probe
        rendered = Path(bpy.path.abspath(settings.render_directory))
        return compare(
            rendered / "xyz.exr",
            rendered / "rgb.exr",
            rendered / "comparison",
            compare_settings_from(settings),
        )

    def done(self, context: bpy.types.Context, result: Numbers) -> None:
        """Keep the numbers in the scene and show the sheet."""
        keep_compared(self, context, result)


def keep_compared(operator: JobOperator, context: bpy.types.Context, result: Numbers) -> None:
    """Keep the numbers of a comparison in the scene, show its sheet, and tell the mean."""
    settings = context.scene.spectral_probe
    keep_comparison(settings, result)
    show(Path(result["written"]) / "sheet.png", "Comparison")
    operator.tell(
        "INFO",
        rpt_("RGB differs from spectral by ΔE {mean:.2f} on average").format(
            mean=settings.comparison.mean_de2000
        ),
    )

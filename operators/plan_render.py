"""Say what a spectral render would take before it is started."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from ..spectral_probe.model import Job, Progress
from .add_swappable import marked_masks
from .job import JobOperator
from .polls import has_probe, uses_cycles
from .results import keep_plan
from .settings import probe_folder

if TYPE_CHECKING:
    from ..spectral_probe.render_model import PassPlan


class SPECTRAL_PROBE_OT_plan_render(JobOperator, bpy.types.Operator):
    """Choose the passes for this scene and its light without rendering: their wavelengths, predicted error and cost"""

    bl_idname = "spectral_probe.plan_render"
    bl_label = "Plan"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a probe, and Cycles."""
        return has_probe(cls, context) and uses_cycles(cls, context)

    def job(self, context: bpy.types.Context) -> Job[PassPlan]:
        """Make the plan that the render would make."""
        from ..spectral_probe.files.probe_exr import read_probe
        from .bridge.cycles import scene_plan

        settings = context.scene.spectral_probe
        yield Progress(0.0, "Reading the probe")
        probe = read_probe(probe_folder(settings) / "probe.exr")
        yield Progress(0.3, "Planning the passes")
        return scene_plan(
            context.scene,
            probe,
            {"AUTOMATIC": None, "NUMBER": settings.passes, "REFERENCE": "all"}[settings.plan],
            samples=settings.samples,
            max_de2000=settings.max_de2000,
            full_samples=settings.full_samples,
            swappable=marked_masks(settings, probe),
        )

    def done(self, context: bpy.types.Context, result: PassPlan) -> None:
        """Keep the prediction in the scene."""
        settings = context.scene.spectral_probe
        keep_plan(settings, result)
        self.report({"INFO"}, f"{result.passes} passes, {settings.planned.cost:.2f} RGB renders")

"""Say what a spectral render would take before it is started."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..spectral_probe.model import Job, Progress
from ..spectral_probe.work import worked
from .job import JobOperator
from .polls import has_light, uses_cycles
from .render_spectral import planner_from
from .results import keep_plan

if TYPE_CHECKING:
    from ..spectral_probe.render_model import PassPlan


class SPECTRAL_PROBE_OT_plan_render(JobOperator, bpy.types.Operator):
    """Choose the passes for this scene and its light without rendering: their wavelengths, predicted error and cost"""

    bl_idname = "spectral_probe.plan_render"
    bl_label = "Plan"

    needs = (".bridge.cycles",)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be light, and Cycles."""
        return has_light(cls, context) and uses_cycles(cls, context)

    def job(self, context: bpy.types.Context) -> Job[PassPlan]:
        """Make the plan that the render would make."""
        from .bridge.cycles import making_plan

        scene = context.scene
        planner = yield from worked(Progress(0.0, "Reading the light"), planner_from(scene.spectral_probe))
        return (yield from making_plan(scene, planner))

    def done(self, context: bpy.types.Context, result: PassPlan) -> None:
        """Keep the prediction in the scene."""
        settings = context.scene.spectral_probe
        keep_plan(settings, result)
        told = rpt_("{passes} passes, as long as {cost:.2f} RGB renders")
        self.tell("INFO", told.format(passes=result.passes, cost=settings.planned.cost))

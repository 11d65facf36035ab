"""Render the scene spectrally and in RGB, and compare both, in one job."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy

from ..spectral_probe.model import Job, part
from ..spectral_probe.work import all_worked
from .base import OperatorResult
from .compare import compare_settings_from, keep_compared
from .polls import has_light
from .render_folder import render_folder
from .render_spectral import RendersSpectrally, passes_told, planner_from, render_scene

if TYPE_CHECKING:
    from ..spectral_probe.compare_command import CompareSettings
    from .bridge.cycles import SpectralRender
    from .bridge.planning import Planner

_RENDER = 0.9
"""About the share of the work that rendering takes."""


@dataclass(frozen=True)
class Compared:
    """The render and the numbers of its comparison."""

    render: SpectralRender
    comparison: dict[str, Any]


def render_and_compare(
    scene: bpy.types.Scene,
    make_planner: Callable[[], Planner],
    directory: Path,
    words: Mapping[str, Any],
    settings: CompareSettings,
) -> Job[Compared]:
    """Render a scene spectrally and in RGB into a folder, and compare both."""
    from ..spectral_probe.compare_command import compare

    render = yield from part(render_scene(scene, make_planner, directory, words), 0.0, _RENDER)
    comparison = compare(render.xyz, directory / "rgb.exr", directory / "comparison", settings)
    numbers = yield from part(all_worked(comparison), _RENDER, 1.0)
    return Compared(render, numbers)


class SPECTRAL_PROBE_OT_render_and_compare(RendersSpectrally, bpy.types.Operator):
    """Render the scene in Cycles, spectrally and in RGB, and show where the colours differ"""

    bl_idname = "spectral_probe.render_and_compare"
    bl_label = "Render and Compare"

    needs = (*RendersSpectrally.needs, "..spectral_probe.compare_command")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be light."""
        return has_light(cls, context)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        """Start, or ask first."""
        context.scene.render.engine = "CYCLES"  # before passes there are compared with the scene
        return super().invoke(context, event)

    def job(self, context: bpy.types.Context) -> Job[Compared]:
        """Read the settings and start."""
        context.scene.render.engine = "CYCLES"
        settings = context.scene.spectral_probe
        directory = render_folder(context.scene, replace=self.on_change == "RESTART")
        words = {**self.words(context), "rgb_twin": True}
        return render_and_compare(
            context.scene, planner_from(settings), directory, words, compare_settings_from(settings)
        )

    def done(self, context: bpy.types.Context, result: Compared) -> None:
        """Keep the numbers of both, and show the sheet."""
        render = result.render
        self.finish_with(context, render, passes_told(render))
        keep_compared(self, context, result.comparison)

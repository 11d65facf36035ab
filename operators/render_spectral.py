"""Render the scene spectrally in the light of the probe: one frame, or an animation."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
from bpy.app.translations import pgettext_iface as iface_
from bpy.app.translations import pgettext_n as n_
from bpy.app.translations import pgettext_rpt as rpt_

from ..spectral_probe.model import Job, Progress
from ..spectral_probe.work import worked
from .add_swappable import marked_regions
from .base import FINISHED, OperatorResult
from .job import JobOperator
from .pictures import show_render
from .polls import has_light, uses_cycles
from .render_folder import render_folder
from .results import keep_render
from .settings import probe_folder
from .swap_light import keep_lights

if TYPE_CHECKING:
    from .bridge.cycles import SpectralRender
    from .bridge.planning import Planner

_DIALOG_WIDTH = 420
_ON_CHANGE = {"ASK": "refuse", "RESTART": "restart", "RESUME": "resume"}


def passes_told(result: SpectralRender) -> str:
    """How many passes a render took, and how long."""
    told = rpt_("{passes} passes in {seconds:.1f} s")
    return str(told.format(passes=result.plan.passes, seconds=result.seconds_spectral))


class RendersSpectrally(JobOperator):
    """Mixin of the two operators: asks what to do with passes of an unfinished render of something else."""

    needs = (".bridge.frames", ".settings_output", "..spectral_probe.swapping")
    on_change: bpy.props.EnumProperty(
        name="Unfinished Passes",
        description="What to do with passes of an unfinished render, where the scene has changed since then",
        items=(
            ("ASK", "Ask", "Ask; a script gets an error"),
            ("RESTART", "Render Anew", "Remove them and begin again"),
            ("RESUME", "Use Them", "Go on with them as they are, with their plan and samples"),
        ),
        options={"SKIP_SAVE"},
    )

    after_stop = n_("The finished passes are kept: press the button again to go on")

    _changed: tuple[str, ...] = ()

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be light, and Cycles."""
        return has_light(cls, context) and uses_cycles(cls, context)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        """Start, or ask first."""
        if bpy.app.background or self.on_change != "ASK":
            return super().invoke(context, event)
        return self.reporting(lambda: self._ask_or_start(context, event))

    def _ask_or_start(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        settings = context.scene.spectral_probe
        folder = self.first_folder(context, render_folder(context.scene))
        if (folder / "passes").is_dir() and not (folder / "report.json").is_file():
            from .bridge.resuming import unfinished_changes

            self._changed = unfinished_changes(context.scene, planner_from(settings)(), folder)
        if not self._changed:
            return super().invoke(context, event)
        self.on_change = "RESTART"
        window_manager: Any = context.window_manager
        answer: OperatorResult = window_manager.invoke_props_dialog(
            self, width=_DIALOG_WIDTH, title="Unfinished Render", confirm_text="Render"
        )
        return answer

    def draw(self, _context: bpy.types.Context) -> None:
        """The question."""
        column = self.layout.column()
        column.label(text="The folder has passes of an unfinished render.", icon="ERROR")
        changed = iface_("Since then this has changed: {names}.").format(names=", ".join(self._changed))
        column.label(text=changed, icon="BLANK1", translate=False)
        column.prop_enum(self, "on_change", "RESTART")
        column.prop_enum(self, "on_change", "RESUME")

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        """Render: at once in a script; as a job in the window once the question was answered."""
        if self._changed:
            name = type(self).bl_idname.split(".")[1]
            getattr(bpy.ops.spectral_probe, name)("INVOKE_DEFAULT", on_change=self.on_change)
            return FINISHED
        return super().execute(context)

    def first_folder(self, _context: bpy.types.Context, folder: Path) -> Path:
        """The folder that may hold an unfinished render."""
        return folder

    def words(self, context: bpy.types.Context) -> dict[str, Any]:
        """What both renders are told."""
        from .settings_output import output_settings_from

        settings = context.scene.spectral_probe
        return {
            "rgb_twin": settings.rgb_twin,
            "outputs": output_settings_from(settings.output),
            "on_change": _ON_CHANGE[self.on_change],
        }

    def finish_with(self, context: bpy.types.Context, result: SpectralRender, told: str) -> None:
        """Keep and show a result."""
        keep_render(context.scene.spectral_probe, result)
        keep_lights(context.scene.spectral_probe, result.xyz.parent)
        show_render(result.image)
        self.tell("INFO", told)
        for warning in result.warnings:
            self.tell("WARNING", warning)


class SPECTRAL_PROBE_OT_render_spectral(RendersSpectrally, bpy.types.Operator):
    """Render the scene in Cycles at several wavelengths and put the passes together into one image"""

    bl_idname = "spectral_probe.render_spectral"
    bl_label = "Render Spectral"

    def job(self, context: bpy.types.Context) -> Job[SpectralRender]:
        """Read the settings and start."""
        directory = render_folder(context.scene, replace=self.on_change == "RESTART")
        planner = planner_from(context.scene.spectral_probe)
        return render_scene(context.scene, planner, directory, self.words(context))

    def done(self, context: bpy.types.Context, result: SpectralRender) -> None:
        """Keep the report's numbers in the scene."""
        self.finish_with(context, result, passes_told(result))


class SPECTRAL_PROBE_OT_render_animation(RendersSpectrally, bpy.types.Operator):
    """Render the scene's frames spectrally, from its first to its last, each into a folder of its own"""

    bl_idname = "spectral_probe.render_animation"
    bl_label = "Render Spectral Animation"

    def job(self, context: bpy.types.Context) -> Job[tuple[SpectralRender, ...]]:
        """Read the settings and start."""
        directory = render_folder(context.scene, replace=self.on_change == "RESTART")
        planner, frames = planner_from(context.scene.spectral_probe), frames_of(context.scene)
        return _render_frames(context.scene, planner, directory, frames, self.words(context))

    def first_folder(self, context: bpy.types.Context, folder: Path) -> Path:
        """The frame shown now: of the others only the render itself can tell."""
        from ..spectral_probe.render.share import frame_folder

        return frame_folder(folder, context.scene.frame_current)

    def done(self, context: bpy.types.Context, result: tuple[SpectralRender, ...]) -> None:
        """Keep the last frame's numbers in the scene."""
        seconds = sum(frame.seconds_spectral for frame in result)
        told = rpt_("{frames} frames in {seconds:.0f} s")
        self.finish_with(context, result[-1], told.format(frames=len(result), seconds=seconds))


def frames_of(scene: bpy.types.Scene) -> range:
    """The frames that Blender renders of an animation."""
    return range(scene.frame_start, scene.frame_end + 1, scene.frame_step)


def planner_from(settings: bpy.types.PropertyGroup) -> Callable[[], Planner]:
    """What the scene's settings ask of a plan: read now, and made by the function returned, which touches no Blender data.

    It raises a SpectralProbeError if the probe cannot be read.
    """
    probe_exr = probe_folder(settings) / "probe.exr" if settings.light == "PROBE" else None
    regions = {} if probe_exr is None else marked_regions(settings)
    passes = {"AUTOMATIC": None, "NUMBER": settings.passes, "REFERENCE": "all"}[settings.plan]
    max_de2000, full_samples = settings.max_de2000, settings.full_samples
    lamps, samples = settings.swap.lamps, settings.samples

    def make() -> Planner:
        from ..spectral_probe.files.probe_exr import read_probe
        from .bridge.planning import Planner, PlanRequest

        probe = None if probe_exr is None else read_probe(probe_exr)
        masks = {} if probe is None else {name: find(probe) for name, find in regions.items()}
        return Planner(probe, PlanRequest(passes, max_de2000, full_samples, masks, lamps), samples)

    return make


def render_scene(
    scene: bpy.types.Scene, make_planner: Callable[[], Planner], directory: Path, words: Mapping[str, Any]
) -> Job[SpectralRender]:
    """Render a scene spectrally, and write a preview beside its files."""
    from .bridge.cycles import spectral_render

    planner = yield from worked(Progress(0.0, "Reading the light"), make_planner)
    result = yield from spectral_render(
        scene, planner.probe, None, directory, samples=planner.samples, planner=planner, **words
    )
    yield from worked(Progress(1.0, "Writing a preview"), partial(write_preview, result.xyz))
    return result


def _render_frames(
    scene: bpy.types.Scene,
    make_planner: Callable[[], Planner],
    directory: Path,
    frames: Sequence[int],
    words: Mapping[str, Any],
) -> Job[tuple[SpectralRender, ...]]:
    """Render frames of a scene spectrally, and write a preview of the last one."""
    from .bridge.frames import render_frames

    planner = yield from worked(Progress(0.0, "Reading the light"), make_planner)
    results = yield from render_frames(scene, planner, directory, frames, **words)
    yield from worked(Progress(1.0, "Writing a preview"), partial(write_preview, results[-1].xyz))
    return results


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

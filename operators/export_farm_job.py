"""Write the scene's frames as a job for a render farm."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..spectral_probe.errors import RenderError
from ..spectral_probe.model import Job, Progress
from ..spectral_probe.work import worked
from .asking_for_folder import AsksForFolder
from .polls import has_light, uses_cycles
from .render_folder import render_folder
from .render_spectral import frames_of, planner_from
from .settings import probe_folder

if TYPE_CHECKING:
    from ..spectral_probe.farm.bundle import BundleFormat
    from ..spectral_probe.farm.job import FarmJob
    from .bridge.farm import SceneNeeds
    from .bridge.planning import Planner

_DENOISE = {"SCENE": (), "ON": ("--denoise",), "OFF": ("--no-denoise",)}


class SPECTRAL_PROBE_OT_export_farm_job(AsksForFolder, bpy.types.Operator):
    """Write the scene's frames as a job for a render farm: each pass of each frame is a task of its own"""

    bl_idname = "spectral_probe.export_farm_job"
    bl_label = "Export Farm Job"

    needs = (".bridge.farm", "..spectral_probe.farm.bundle")

    directory: bpy.props.StringProperty(
        name="Folder",
        description="Folder of the job, empty or with an earlier job",
        subtype="DIR_PATH",
        options={"SKIP_SAVE"},
    )
    format: bpy.props.EnumProperty(
        name="Format",
        description="What the scheduler of the farm takes",
        items=(
            ("OPENJD", "Open Job Description", "A job bundle, as AWS Deadline Cloud and others take it"),
            ("COMMANDS", "List of Commands", "A shell command a line, for Flamenco, OpenCue and others"),
        ),
    )
    blender: bpy.props.StringProperty(
        name="Blender",
        description="Program on the farm's machines, with this extension enabled",
        default="blender",
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be light, Cycles, and a file that other machines can open."""
        if not bpy.data.filepath:
            cls.poll_message_set("Save the .blend first: the farm's machines open it")
            return False
        return has_light(cls, context) and uses_cycles(cls, context)

    def job(self, context: bpy.types.Context) -> Job[FarmJob]:
        """Read the settings, and start to plan."""
        from ..spectral_probe.farm.bundle import check_bundle_folder

        scene = context.scene
        if not self.directory:
            raise RenderError("Choose a folder for the job.")
        directory = Path(bpy.path.abspath(self.directory))
        check_bundle_folder(directory)
        if bpy.data.is_dirty:
            self.tell("WARNING", rpt_("The file has unsaved changes: the farm renders what was saved"))
        probe = shared_probe(scene.spectral_probe)
        job = job_of(scene, probe, self.blender, render_folder(scene))
        planner = planner_from(scene.spectral_probe)
        return written_job(
            scene, planner, job, directory, "commands" if self.format == "COMMANDS" else "openjd", self.warn
        )

    def warn(self, needs: SceneNeeds) -> None:
        """Tell what to mind."""
        for text in needs.warnings:
            self.tell("WARNING", text)

    def done(self, _context: bpy.types.Context, result: FarmJob) -> None:
        """Say how much it is."""
        told = rpt_("{frames} frames, {tasks} tasks")
        self.tell("INFO", told.format(frames=len(result.frames), tasks=result.tasks))


def shared_probe(settings: bpy.types.PropertyGroup) -> Path | None:
    """probe.exr of the scene's light, where other machines can find it; None where the scene's own world is the light.

    Raises
    ------
    RenderError
        If it lies in this program's temporary folder, or light is to be exchanged afterwards by regions that are in no file.
    """
    if settings.swap.items:
        raise RenderError(
            "Swappable regions are in no file that the farm's machines could read. Remove them, or save each as a region and use "
            "the command line's --swappable."
        )
    if settings.light != "PROBE":
        return None
    probe = probe_folder(settings) / "probe.exr"
    if probe.is_relative_to(bpy.app.tempdir):
        raise RenderError(
            "The probe is packed into the .blend, and the farm's machines need it as a file. Unpack it first (Files > Unpack)."
        )
    return probe.resolve()


def job_of(scene: bpy.types.Scene, probe: Path | None, blender: str, output: Path) -> FarmJob:
    """The job that a scene's settings ask for; what the scene needs and the number of passes follow."""
    from ..spectral_probe.farm.job import FarmJob

    settings = scene.spectral_probe
    return FarmJob(
        scene=Path(bpy.data.filepath).resolve(),
        probe=probe,
        frames=tuple(frames_of(scene)),
        shares=1,
        output=output.resolve(),
        samples=settings.samples,
        max_de2000=round(settings.max_de2000, 6),
        words=_words(settings),
        rgb_twin=settings.rgb_twin,
        blender=blender,
    )


def _words(settings: bpy.types.PropertyGroup) -> tuple[str, ...]:
    """The settings as words of the command line."""
    output = settings.output
    passes = {"AUTOMATIC": (), "NUMBER": ("--passes", str(settings.passes)), "REFERENCE": ("--passes", "all")}
    return (
        *passes[settings.plan],
        *(("--full-samples",) if settings.full_samples else ()),
        *(("--swappable-lamps",) if settings.swap.lamps else ()),
        *(() if settings.rgb_twin else ("--no-rgb",)),
        *(("--spectral",) if output.spectral else ()),
        *(("--white", output.white) if output.adapt else ()),
        *_DENOISE[output.denoise],
    )


def written_job(
    scene: bpy.types.Scene,
    make_planner: Callable[[], Planner],
    job: FarmJob,
    directory: Path,
    kind: BundleFormat,
    warn: Callable[[SceneNeeds], Any],
) -> Job[FarmJob]:
    """Plan the first frame, and write the job; the scene comes back as it was."""
    from ..spectral_probe.farm.bundle import write_bundle
    from .bridge.farm import first_frame, scene_needs

    planner = yield from worked(Progress(0.0, "Reading the light"), make_planner)
    _, steps = yield from first_frame(scene, planner, min(job.frames), rgb_twin=job.rgb_twin)
    needs = scene_needs(scene)
    warn(needs)
    whole = replace(job, shares=len(steps), memory_mib=needs.memory_mib, gpu=needs.gpu, files=needs.files)
    yield from worked(Progress(0.9, "Writing the job"), partial(write_bundle, whole, directory, kind))
    return whole

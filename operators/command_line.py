"""The command line inside Blender: `blender --command spectral_probe VERB ...`, as `spectral-probe VERB ...`.

The core's command line knows every verb; here are the jobs of those that need Blender.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy

from ..spectral_probe.errors import RenderError
from ..spectral_probe.model import Job, Progress, SpectralPanorama
from .terminal import blender_silenced

if TYPE_CHECKING:
    from .bridge.planning import Planner

type Numbers = dict[str, Any]

_commands: list[object] = []  # what Blender gave for each registered command, to take it back with


def run(argv: list[str]) -> int:
    """Run one verb and return the exit status."""
    from ..spectral_probe.cli import main

    try:
        return main(
            argv,
            {
                "render": render,
                "render-pass": render_pass,
                "combine": combine,
                "demo": demo,
                "farm": farm,
                "backplate": backplate,
            },
        )
    except SystemExit as stop:  # argparse, after --help or a word it does not know
        return stop.code if isinstance(stop.code, int) else int(stop.code is not None)


def render(arguments: argparse.Namespace) -> Job[Numbers]:
    """Open a scene and render it spectrally in the light of a probe or of its own world."""
    from ..spectral_probe.files.atomic import check_folder
    from ..spectral_probe.files.probe_exr import read_probe

    probe = None if arguments.world else read_probe(arguments.probe)
    check_folder(arguments.output)
    with blender_silenced():
        yield Progress(0.0, f"Opening {arguments.scene.name}")
        scene = open_scene(arguments.scene)
        return (yield from render_scene(scene, probe, arguments))


def render_scene(
    scene: bpy.types.Scene, probe: SpectralPanorama | None, arguments: argparse.Namespace
) -> Job[Numbers]:
    """Render an open scene as the command line asks; returns the numbers of its report.json."""
    from ..spectral_probe.cli_output import output_settings_of
    from ..spectral_probe.cli_render import render_words
    from .bridge.cycles import spectral_render
    from .bridge.file_digest import opened_files_digest
    from .bridge.frames import render_frames

    if arguments.frame is not None:
        scene.frame_set(arguments.frame)
    directory = arguments.output.resolve()
    planner = planner_of(scene, probe, arguments)
    samples = planner.samples
    if arguments.plan_only:
        return _planned(scene, planner)
    words: dict[str, Any] = {
        "rgb_twin": not arguments.no_rgb,
        "outputs": output_settings_of(arguments),
        "on_change": "restart" if arguments.restart else "resume" if arguments.resume else "refuse",
        "words": tuple(render_words(arguments)),
        "files": opened_files_digest(),
    }
    if arguments.frames:
        results = yield from render_frames(scene, planner, directory, arguments.frames, **words)
        return {
            "frames": len(results),
            "seconds": sum(result.seconds_spectral for result in results),
            "warnings": list(dict.fromkeys(text for result in results for text in result.warnings)),
            "written": str(directory),
        }
    yield from spectral_render(scene, probe, None, directory, samples=samples, planner=planner, **words)
    return {**json.loads((directory / "report.json").read_text("utf-8")), "written": str(directory)}


def planner_of(
    scene: bpy.types.Scene, probe: SpectralPanorama | None, arguments: argparse.Namespace
) -> Planner:
    """What makes the plans that the words ask for."""
    from ..spectral_probe.cli_swap import swappable_masks
    from ..spectral_probe.render.plan_file import load_plan
    from .bridge.planning import Planner, PlanRequest

    masks = swappable_masks(arguments, probe)
    request = PlanRequest(
        arguments.passes, arguments.max_de, arguments.full_samples, masks, arguments.swappable_lamps
    )
    plan = None if arguments.plan is None else load_plan(arguments.plan)
    return Planner(probe, request, arguments.samples or scene.cycles.samples, plan)


def _planned(scene: bpy.types.Scene, planner: Planner) -> Numbers:
    """What the plan of a scene is and costs."""
    from ..spectral_probe.render.plan import describe
    from .bridge.cycles import planned

    plan = planned(scene, planner)
    return {
        "plan": describe(plan),
        "kind": plan.kind,
        "passes": plan.passes,
        "wavelengths_nm": sorted(set(plan.wavelengths_nm.ravel().tolist())),
        "samples": planner.samples,
        "predicted_de2000": plan.predicted_de2000,
        "predicted_cost": plan.predicted_cost,
    }


def open_scene(path: Path) -> bpy.types.Scene:
    """Open a .blend, scripts in it off, and return its scene.

    Raises
    ------
    RenderError
        If there is no such file, or it is none of Blender's.
    """
    if not path.is_file():
        raise RenderError(f"There is no scene at {path}. Check the path.")
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path.resolve()), load_ui=False, use_scripts=False)
    except RuntimeError:
        raise RenderError(
            f"{path.name} cannot be opened. Give a .blend file that Blender 5.2 opens."
        ) from None
    return bpy.context.scene


def render_pass(arguments: argparse.Namespace) -> Job[Numbers]:
    """One pass of a frame, or a share of them."""
    from .command_frames import render_pass as pass_job

    with blender_silenced():
        return (yield from pass_job(arguments))


def combine(arguments: argparse.Namespace) -> Job[Numbers]:
    """Finished passes put together."""
    from .command_frames import combine as combine_job

    with blender_silenced():
        return (yield from combine_job(arguments))


def demo(arguments: argparse.Namespace) -> Job[Numbers]:
    """The main job on the bundled sample."""
    from .demo import demo as demo_job

    with blender_silenced():
        return (yield from demo_job(arguments.output.resolve()))


def farm(arguments: argparse.Namespace) -> Job[Numbers]:
    """A shot as a job for a render farm."""
    from .command_farm import farm as farm_job

    with blender_silenced():
        return (yield from farm_job(arguments))


def backplate(arguments: argparse.Namespace) -> Job[Numbers]:
    """A photograph as the background of a scene."""
    from .command_backplate import backplate as backplate_job

    with blender_silenced():
        return (yield from backplate_job(arguments))


def register() -> None:
    """Let `blender --command spectral_probe` find us."""
    _commands.append(bpy.utils.register_cli_command("spectral_probe", run))


def unregister() -> None:
    """Take the command back."""
    while _commands:
        bpy.utils.unregister_cli_command(_commands.pop())

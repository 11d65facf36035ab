"""The Cycles renders that steps of a frame ask for: any of them, in any order, each a file with its manifest.

A step that is finished and undamaged is not rendered again; one that another process renders at the time is waited for.
"""

import time
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial

import numpy as np

from ...spectral_probe.model import Job, Progress
from ...spectral_probe.render.frame_steps import FrameStep
from ...spectral_probe.render.light_file import LIGHT_FOLDER, load_light_sets
from ...spectral_probe.render.pace import Pace, step_message
from ...spectral_probe.render.pass_folder import matte_steps, render_steps, sequence_samples
from ...spectral_probe.render_model import WORLD
from ...spectral_probe.work import worked
from .beginning import PLANNING, translated
from .catchers import as_ordinary_surfaces
from .light import LayerLight, Show, WavelengthLight, light_level, panorama_rec709, shown
from .locks import waited_lock
from .materials import SpectralMaterials, rgb_materials, working_to_rec709
from .parts import Frame, Part
from .pass_output import RenderTo, pass_output
from .pass_settings import PassSettings, pass_settings
from .render_report import device_name
from .same_scene import check_same, contents
from .world import temporary_light

_LONGEST_WAIT_S = 7 * 24 * 3600.0
"""A step that another process renders is waited for as long as that lives: its lock ends with it."""

type Light = LayerLight | WavelengthLight


@dataclass(frozen=True)
class _Task:
    """What all steps that are rendered need; `told` are sentences on what was left out, and grow, as does the pace."""

    frame: Frame
    settings: PassSettings
    render_to: RenderTo
    pace: Pace
    told: list[str]


def render_frame_steps(frame: Frame, wanted: Sequence[FrameStep]) -> Job[tuple[FrameStep, ...]]:
    """Render those of some steps of a frame that are not finished yet; returns them.

    The others are noted among those that their parts kept.
    """
    pace = Pace(max(1, sum(_samples(frame, step) for step in wanted)))
    missing = []
    for step in wanted:
        if frame.part_of(step).folder.holds(step.name):
            _keep(frame, step, pace)
        else:
            missing.append(step)
    if not missing:
        return ()
    rendered: list[FrameStep] = []
    with ExitStack() as stack:
        settings = stack.enter_context(pass_settings(frame.scene))
        render_to = stack.enter_context(pass_output(frame.scene, settings.layers))
        stack.enter_context(as_ordinary_surfaces(frame.scene, frame.found))
        task = _Task(frame, settings, render_to, pace, [])
        if passes := [step for step in missing if step.step is not None]:
            rendered += yield from _passes(task, passes)
        if twins := [step for step in missing if step.step is None]:
            rendered += yield from _twins(task, twins)
    return tuple(rendered)


def _samples(frame: Frame, step: FrameStep) -> int:
    return frame.samples if step.step is None else step.step.samples


def _keep(frame: Frame, step: FrameStep, pace: Pace) -> None:
    """Note that a step need not be rendered."""
    pace.skip(_samples(frame, step))
    if step.step is not None:
        frame.part_of(step).kept.append(step.name)


# ---------------------------------------------------------------- passes


def _passes(task: _Task, wanted: Sequence[FrameStep]) -> Job[list[FrameStep]]:
    """Render passes of the plan, those of a part after those of another."""
    frame, rendered = task.frame, list[FrameStep]()
    plan, probe = frame.plan, frame.planner.probe
    progress = task.pace.progress(PLANNING)
    of_layers = plan.kind == "light-basis"
    level = plan.level  # the passes of a wavelength plan that there are were divided by it
    if of_layers:
        level = yield from worked(progress, partial(light_level, probe))
    with translated(frame.scene, probe, of_layers, level) as (materials, world):
        light: Light
        if of_layers:
            find = partial(load_light_sets, frame.directory.parent / LIGHT_FOLDER, frame.record.light)
            sets = (yield from worked(progress, find)) if frame.record.light else None
            sets = sets or (yield from worked(progress, partial(frame.planner.sets, materials, world)))
            light = LayerLight(sets, materials.emission, world)
            light.checked(plan)
        else:
            light = WavelengthLight(probe, level, task.told, world)
        task.told.extend([*(world.warnings if world else ()), *materials.warnings])
        with shown(frame.scene, light) as show:
            for part in frame.parts:
                own = [step for step in wanted if step.part == part.name]
                with part.shown():
                    rendered += yield from _passes_of(task, part, own, materials, show)
    return rendered


def _passes_of(
    task: _Task, part: Part, wanted: Sequence[FrameStep], materials: SpectralMaterials, show: Show
) -> Job[list[FrameStep]]:
    """Render passes of a part, which the scene shows."""
    frame, plan, samples = task.frame, task.frame.plan, task.frame.samples
    steps, rendered = render_steps(plan, samples), list[FrameStep]()
    groups, seen = [WORLD, *(group.name for group in plan.emission)], contents(frame.scene)
    for one in wanted:
        step = one.step
        if step is None:
            continue
        progress = task.pace.progress(step_message(plan, steps, steps.index(step), samples) + part.told)
        yield progress
        with ExitStack() as stack:
            if not (yield from _taken(stack, task, progress, one)):
                continue
            start = time.perf_counter()
            first_set = plan.light_sets[step.pass_number] == 0
            check_same(frame.scene, seen)
            yield from show(progress, plan, step.pass_number)
            check_same(frame.scene, seen)
            materials.shine(first_set)
            materials.set_wavelengths(plan.wavelengths_nm[step.pass_number])
            task.settings.set_samples(sequence_samples(plan, samples, step), step.first_sample, step.samples)
            mattes = part is frame.parts[0] and step in matte_steps(plan, steps)
            wanted_groups = groups if first_set else [WORLD]
            path = part.folder.path(one.name)
            yield from task.render_to(progress, path, wanted_groups, step.guide, mattes=mattes)
            _note(task, one, time.perf_counter() - start, task.told)
        rendered.append(one)
    return rendered


# ---------------------------------------------------------------- the RGB twin


def _twins(task: _Task, wanted: Sequence[FrameStep]) -> Job[list[FrameStep]]:
    """Render the RGB twins of parts, with the samples of a full pass."""
    frame, rendered = task.frame, list[FrameStep]()
    progress, world = task.pace.progress("Rendering in RGB"), None
    if frame.planner.probe is not None:
        world = yield from worked(progress, partial(panorama_rec709, frame.planner.probe))
    yield progress
    with rgb_materials(frame.scene), ExitStack() as lit:
        if world is not None:
            set_light = lit.enter_context(temporary_light(frame.scene, *world.shape[:2]))
            set_light(world @ np.linalg.inv(working_to_rec709()).T / (frame.record.twin_level or 1.0))
        seen = contents(frame.scene)
        for number, one in enumerate(wanted):
            part = frame.part_of(one)
            if number:
                progress = task.pace.progress(f"Rendering in RGB{part.told}")
                yield progress
            with ExitStack() as stack:
                if not (yield from _taken(stack, task, progress, one)):
                    continue
                start = time.perf_counter()
                check_same(frame.scene, seen)
                with part.shown():
                    task.settings.set_samples(frame.samples, 0, frame.samples)
                    # In the working space and at the level of the passes.
                    yield from task.render_to(progress, part.folder.path(one.name), [WORLD], False)
                _note(task, one, time.perf_counter() - start, ())
            rendered.append(one)
    return rendered


# ---------------------------------------------------------------- one step


def _taken(stack: ExitStack, task: _Task, progress: Progress, step: FrameStep) -> Job[bool]:
    """Take a step's lock, and say whether it is still to be rendered: another process may have done so meanwhile."""
    folder = task.frame.part_of(step).folder
    yield from waited_lock(stack, progress, folder.directory, name=step.name, wait_s=_LONGEST_WAIT_S)
    if not folder.holds(step.name):
        return True
    _keep(task.frame, step, task.pace)
    return False


def _note(task: _Task, step: FrameStep, seconds: float, told: Sequence[str]) -> None:
    """Write the manifest of a step that was rendered."""
    samples = _samples(task.frame, step)
    folder = task.frame.part_of(step).folder
    folder.note(step.name, seconds, samples, device_name(task.frame.scene), tuple(dict.fromkeys(told)))
    task.pace.add(samples, seconds)

"""The spectral render: the Cycles renders that a plan's steps ask for, with the scene as it was afterwards.

Every finished step is a file (`render.pass_folder`): a render that was stopped or killed goes on where it was, as long as
the scene, the light and the settings are those it began with (`fingerprint`).
"""

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...spectral_probe.composite_model import OBJECTS_NAME
from ...spectral_probe.errors import RenderError
from ...spectral_probe.light_choice import mean_light
from ...spectral_probe.model import Job, Progress, SpectralPanorama, finish
from ...spectral_probe.render.outputs import OutputSettings
from ...spectral_probe.render.pace import Pace, step_message
from ...spectral_probe.render.pass_folder import matte_steps, read_pass, render_steps, sequence_samples
from ...spectral_probe.render.plan import load_plan, reference_plan, save_plan
from ...spectral_probe.render_model import WORLD, PassPlan, RenderStep
from ...spectral_probe.work import worked
from .assembling import TWIN_STEP, write_objects_of, write_pictures, write_twin
from .backplate import write_backplate
from .catchers import Surfaces, as_ordinary_surfaces, surfaces
from .light import LayerLight, Show, WavelengthLight, light_level, panorama_rec709, shown
from .materials import SpectralMaterials, rgb_materials, spectral_materials, working_to_rec709
from .missing_files import check_textures
from .own_world import OwnWorld, own_world_light
from .parts import Part, parts_of
from .pass_output import RenderTo, pass_output
from .pass_settings import PassSettings, pass_settings
from .planning import DEFAULT_MAX_DE2000, Passes, Planner, PlanRequest
from .render_report import SpectralRender, device_name, write_report
from .resuming import PLAN_NAME, OnChange, render_fingerprint
from .same_scene import check_same, contents
from .world import temporary_light, volume_left_out

type Array = np.ndarray[Any, Any]
_PLANNING = "Planning the passes"

type Light = LayerLight | WavelengthLight


@dataclass(frozen=True)
class _Task:
    """What all steps of a render need; the lists and the pace grow.

    The first of the parts is the one with all objects. `emitters` is what shines besides the world.
    """

    scene: bpy.types.Scene
    probe: SpectralPanorama | None
    parts: tuple[Part, ...]
    surfaces: Surfaces
    samples: int
    settings: PassSettings
    render_to: RenderTo
    pace: Pace
    warnings: list[str]
    emitters: list[str] = field(default_factory=list)


def spectral_render(
    scene: bpy.types.Scene,
    probe: SpectralPanorama | None,
    plan: PassPlan | None,
    directory: Path,
    *,
    samples: int,
    passes: Passes = None,
    max_de2000: float = DEFAULT_MAX_DE2000,
    full_samples: bool = False,
    swappable: Mapping[str, Array] | None = None,
    lamps_swappable: bool = False,
    rgb_twin: bool = True,
    outputs: OutputSettings | None = None,
    on_change: OnChange = "refuse",
    planner: Planner | None = None,
) -> Job[SpectralRender]:
    """Render a scene in the spectral light of a panorama, or of its own world.

    Parameters
    ----------
    scene
        A Cycles scene with a camera. It comes back exactly as it was, whatever happens.
    probe
        The light. A world made by "Light the World" turns and scales it; without one it is used as it is. None lights
        the scene with its own world.
    plan
        The passes; None makes a plan for this scene and this light. A light-basis plan must have been made for the
        layers of this light.
    directory
        Where to write passes/, the files of `render.outputs`, rgb.exr, objects.exr, plan.json and report.json, and in without/
        the same of the scene without its virtual objects, where it has shadow catchers. Finished passes of a stopped render of
        the same scene in the same light are kept, and not rendered again.
    samples
        Samples per pixel of a full pass.
    passes
        Where `plan` is None: the number of light-basis passes, "all" for the 61-wavelength reference, or None (or 0) for
        what keeps the error bound: wavelengths fitted to the scene, or light layers where light is to be exchanged.
    max_de2000
        The bound on the largest colour error that the plan may predict.
    full_samples
        Give all passes the same samples: none is estimated as a ratio of another.
    swappable
        Masks (H, W) of the panorama's regions whose light is to be exchanged after rendering, by name.
    lamps_swappable
        The scene's measured lamps are to be exchanged after rendering, too.
    rgb_twin
        Also render the scene in plain RGB, lit by the same panorama in Rec.709.
    outputs
        What is written besides xyz.exr, image.exr and render.exr, and how pictures are finished.
    on_change
        What to do with passes of an unfinished render of something else: "refuse" raises, "restart" renders anew,
        "resume" takes them as they are, with their plan and samples.
    planner
        Makes the plan; frames of an animation share one. None makes one of the words above.

    Yields
    ------
    Progress
        Before every Cycles render.

    Returns
    -------
    SpectralRender

    Raises
    ------
    RenderError
        If the scene cannot be rendered as asked; a `resuming.SceneChangedError` if `on_change` has to be decided.
    """
    check_scene(scene, samples, own_world=probe is None)
    directory = Path(directory)
    request = PlanRequest(passes, max_de2000, full_samples, swappable or {}, lamps_swappable)
    planner = planner or Planner(probe, request, samples)
    planner = replace(planner, given=plan or planner.given)
    plan = planner.given
    outputs = outputs or OutputSettings()
    found = surfaces(scene)
    parts = parts_of(scene, directory, render_fingerprint(scene, planner), found, on_change)
    if parts[0].folder.finished:
        plan, samples = load_plan(directory / PLAN_NAME), int(parts[0].folder.fingerprint["samples"])
    with ExitStack() as stack:
        settings = stack.enter_context(pass_settings(scene))
        render_to = stack.enter_context(pass_output(scene, settings.layers))
        stack.enter_context(as_ordinary_surfaces(scene, found))
        warnings = [
            *settings.warnings,
            *(volume_left_out(scene.world) if probe is not None else ()),
            *found.warnings,
        ]
        task = _Task(scene, probe, parts, found, samples, settings, render_to, Pace(1), warnings)
        yield task.pace.progress(_PLANNING)
        plan, light = yield from _spectral_passes(task, plan, planner, rgb_twin)
        if rgb_twin:
            yield from _rgb_twins(task, outputs)
    return (yield from _written(task, plan, light, outputs, rgb_twin))


def planned(scene: bpy.types.Scene, planner: Planner) -> PassPlan:
    """The plan that `spectral_render` makes with a planner for a scene, at once."""
    return finish(making_plan(scene, planner))


def making_plan(scene: bpy.types.Scene, planner: Planner) -> Job[PassPlan]:
    """Make the plan that `spectral_render` makes with a planner for a scene, which comes back as it was."""
    check_scene(scene, planner.samples, own_world=planner.probe is None)
    if planner.given is not None:
        return planner.given
    if planner.request.passes == "all":
        return reference_plan()
    progress = Progress(0.3, _PLANNING)
    level = yield from worked(progress, partial(light_level, planner.probe))
    with _translated(scene, planner.probe, True, level) as (materials, world):
        return (yield from worked(progress, partial(planner.plan, materials, world)))


def check_scene(scene: bpy.types.Scene, samples: int, *, own_world: bool = False) -> None:
    """Refuse a scene that cannot be rendered spectrally; `own_world` says that its world is the light.

    Raises
    ------
    RenderError
        If it is not rendered by Cycles, has no camera, or lacks the files of its textures.
    """
    if scene.render.engine != "CYCLES":
        raise RenderError(
            f'Scene "{scene.name}" does not render with Cycles. Set Render Engine to Cycles: no other engine knows '
            "the refractive index of metals."
        )
    if scene.camera is None:
        raise RenderError(f'Scene "{scene.name}" has no camera. Add one and make it the active camera.')
    if samples < 1:
        raise RenderError(f"{samples} samples were asked for; give at least 1.")
    check_textures(scene, own_world=own_world)


# ---------------------------------------------------------------- passes


@contextmanager
def _translated(
    scene: bpy.types.Scene, probe: SpectralPanorama | None, one_wavelength: bool, level: float
) -> Iterator[tuple[SpectralMaterials, OwnWorld | None]]:
    """Materials and lamps that can be set to wavelengths, and the scene's own world where no probe lights it."""
    with spectral_materials(scene, one_wavelength=one_wavelength, level=level) as materials:
        if probe is not None:
            yield materials, None
            return
        lamps = bool(materials.emitters)
        with own_world_light(scene, one_wavelength=one_wavelength, level=level, may_be_dark=lamps) as world:
            yield materials, world


def _spectral_passes(
    task: _Task, plan: PassPlan | None, planner: Planner, rgb_twin: bool
) -> Job[tuple[PassPlan, Light]]:
    """Plan, and render all steps that are not finished."""
    progress = task.pace.progress(_PLANNING)
    kept = bool(task.parts[0].folder.finished)
    level = yield from worked(progress, partial(light_level, task.probe))
    wavelength = plan.kind == "wavelength" if plan else planner.request.passes == "all"
    light: Light
    if not wavelength:
        with _translated(task.scene, task.probe, True, level) as (materials, world):
            seen = contents(task.scene)
            if plan is None:
                plan = yield from worked(progress, partial(planner.plan, materials, world))
            if plan.kind == "light-basis":
                sets = yield from worked(progress, partial(planner.sets, materials, world))
                light = LayerLight(sets, materials.emission, world)
                plan = light.checked(plan)
                task.warnings.extend(world.warnings if world else ())
                check_same(task.scene, seen)
                yield from _render_steps(task, plan, light, materials, rgb_twin)
                return plan, light
    plan = plan or reference_plan()
    if kept:  # the passes there are were divided by it
        level = plan.level
    with _translated(task.scene, task.probe, False, level) as (materials, world):
        light = WavelengthLight(task.probe, level, task.warnings, world)
        plan = light.checked(plan)
        task.warnings.extend(world.warnings if world else ())
        yield from _render_steps(task, plan, light, materials, rgb_twin)
        return plan, light


def _render_steps(
    task: _Task, plan: PassPlan, light: Light, materials: SpectralMaterials, rgb_twin: bool
) -> Job[None]:
    """Render the steps that are not finished yet, of all parts."""
    task.warnings.extend([*materials.warnings, *_beyond(plan)])
    task.emitters.extend(materials.emitters)
    steps = render_steps(plan, task.samples)
    task.pace.total = len(task.parts) * (sum(step.samples for step in steps) + rgb_twin * task.samples)
    for part in task.parts:
        if not part.folder.finished:
            save_plan(plan, part.directory / PLAN_NAME)
        held = [step for step in steps if part.folder.holds(step.name)]
        part.kept.extend(step.name for step in held)
        task.pace.skip(sum(step.samples for step in held))
    if any(len(part.kept) < len(steps) for part in task.parts):
        with shown(task.scene, light) as show:
            for part in task.parts:
                with part.shown():
                    yield from _render_part(task, plan, part, steps, materials, show)


def _render_part(
    task: _Task,
    plan: PassPlan,
    part: Part,
    steps: Sequence[RenderStep],
    materials: SpectralMaterials,
    show: Show,
) -> Job[None]:
    """Render the steps of a part that are not finished yet."""
    groups, seen = [WORLD, *(group.name for group in plan.emission)], contents(task.scene)
    for number, step in enumerate(steps):
        if step.name in part.kept:
            continue
        progress = task.pace.progress(step_message(plan, steps, number, task.samples) + part.told)
        yield progress
        start = time.perf_counter()
        first_set = plan.light_sets[step.pass_number] == 0
        check_same(task.scene, seen)
        yield from show(progress, plan, step.pass_number)
        check_same(task.scene, seen)
        materials.shine(first_set)
        materials.set_wavelengths(plan.wavelengths_nm[step.pass_number])
        task.settings.set_samples(sequence_samples(plan, task.samples, step), step.first_sample, step.samples)
        mattes = part is task.parts[0] and step in matte_steps(plan, steps)
        wanted = groups if first_set else [WORLD]
        yield from task.render_to(progress, part.folder.path(step.name), wanted, step.guide, mattes=mattes)
        seconds = time.perf_counter() - start
        part.folder.record(step.name, seconds, step.samples)
        task.pace.add(step.samples, seconds)


def _beyond(plan: PassPlan) -> list[str]:
    """The plan's own sentences that warn."""
    return [note for note in plan.notes if "not reached" in note]


def _rgb_twins(task: _Task, outputs: OutputSettings) -> Job[None]:
    """Render the RGB twin of every part with the same samples, and write its rgb.exr in the unit of image.exr."""
    level, progress = 1.0, task.pace.progress("Rendering in RGB")
    world = None
    if task.probe is not None:
        world = yield from worked(progress, partial(panorama_rec709, task.probe))
    if world is not None and not task.emitters:  # lamps shine as the user set them
        level = float(world.mean())
    missing = [part for part in task.parts if not part.folder.holds(TWIN_STEP)]
    if missing:
        yield progress
        with rgb_materials(task.scene), ExitStack() as stack:
            start = time.perf_counter()
            if world is not None:
                set_light = stack.enter_context(temporary_light(task.scene, *world.shape[:2]))
                set_light(world @ np.linalg.inv(working_to_rec709()).T / level)
            seen = contents(task.scene)
            for part in missing:
                if part is not missing[0]:
                    progress = task.pace.progress(f"Rendering in RGB{part.told}")
                    yield progress
                    check_same(task.scene, seen)
                    start = time.perf_counter()
                with part.shown():
                    task.settings.set_samples(task.samples, 0, task.samples)
                    # In the working space and at the level of the passes.
                    yield from task.render_to(progress, part.folder.path(TWIN_STEP), [WORLD], False)
                seconds = time.perf_counter() - start
                part.folder.record(TWIN_STEP, seconds, task.samples)
                task.pace.add(task.samples, seconds)
    for part in task.parts:
        yield from write_twin(progress, part.folder, level, outputs, part.directory)


# ---------------------------------------------------------------- results


def _written(
    task: _Task, plan: PassPlan, light: Light, outputs: OutputSettings, rgb_twin: bool
) -> Job[SpectralRender]:
    """Write the files of all parts, that of all objects last, and its report as the last of all."""
    progress = task.pace.progress("Putting the passes together")
    yield progress
    steps = render_steps(plan, task.samples)
    mean = None if task.probe is None else (yield from worked(progress, partial(mean_light, task.probe)))
    alone: SpectralRender | None = None
    for part in reversed(task.parts):
        whole = part is task.parts[0]
        finished = replace(outputs, denoise=outputs.denoise if whole else False)  # no one looks at the other
        start = time.perf_counter()
        yield from write_pictures(progress, task.scene, part.folder, plan, steps, finished, part.directory)
        first = yield from worked(progress, partial(read_pass, part.folder.path(steps[0].name)))
        height, width = first.groups[WORLD].shape[:2]
        if whole:
            mattes = matte_steps(plan, steps)
            yield from write_objects_of(progress, part.folder, mattes, task.surfaces, part.directory)
            write_backplate(task.scene, (width, height), part.directory)
        result = _result(task, part, plan, light, rgb_twin, time.perf_counter() - start)
        if whole:
            result = replace(
                result,
                objects=part.directory / OBJECTS_NAME,
                without=alone,
                catchers=tuple(thing.name for thing in task.surfaces.catchers),
                virtual=tuple(thing.name for thing in task.surfaces.virtual),
            )
        write_report(result, task.scene, (width, height), mean)
        alone = result
    return result


def _result(
    task: _Task, part: Part, plan: PassPlan, light: Light, rgb_twin: bool, seconds_assembly: float
) -> SpectralRender:
    folder, directory = part.folder, part.directory
    steps = render_steps(plan, task.samples)
    return SpectralRender(
        xyz=directory / "xyz.exr",
        image=directory / "image.exr",
        rgb=directory / "rgb.exr" if rgb_twin else None,
        layers=folder.view_layers,
        passes=tuple(folder.path(step.name) for step in steps),
        plan=plan,
        samples=task.samples,
        seconds_spectral=sum(folder.finished[step.name].seconds for step in steps),
        seconds_rgb=folder.finished[TWIN_STEP].seconds if rgb_twin else None,
        seconds_assembly=seconds_assembly,
        steps_kept=len(part.kept),
        device=device_name(task.scene),
        warnings=tuple(dict.fromkeys(task.warnings)),
        light_residual=light.residual,
    )

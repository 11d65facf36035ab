"""The spectral render: the Cycles renders that a plan's steps ask for, with the scene as it was afterwards.

Every finished step is a file (`render.pass_folder`): a render that was stopped or killed goes on where it was, as long as
the scene, the light and the settings are those it began with (`fingerprint`).
"""

import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import bpy
import numpy as np

from ...spectral_probe.errors import RenderError
from ...spectral_probe.files.image_exr import write_channels
from ...spectral_probe.model import Job, SpectralPanorama
from ...spectral_probe.render.combine import combine_xyz
from ...spectral_probe.render.pace import Pace, step_message
from ...spectral_probe.render.pass_folder import (
    PassFolder,
    new_pass_folder,
    open_pass_folder,
    read_pass,
    render_steps,
    sequence_samples,
)
from ...spectral_probe.render.plan import load_plan, reference_plan, save_plan
from ...spectral_probe.render_model import WORLD, PassImage, PassPlan, RenderStep
from ...spectral_probe.spectra.colorimetry import xyz_to_rec709
from .fingerprint import light_fingerprint, scene_fingerprint
from .light import LayerLight, WavelengthLight, panorama_rec709
from .materials import SpectralMaterials, rgb_materials, spectral_materials, working_to_rec709
from .missing_files import check_textures
from .pass_output import RenderTo, pass_output
from .pass_settings import PassSettings, enabled_layers, pass_settings
from .render_report import REPORT_NAME, SpectralRender, device_name, write_report
from .restore import in_scene, refuse_linked, stand_in
from .world import temporary_light

type Array = np.ndarray[Any, Any]
type Passes = int | Literal["all"] | None
type OnChange = Literal["refuse", "restart", "resume"]

XYZ_NOTE = (
    "CIE 1931 2 degree tristimulus values: spectral radiance times colour-matching functions, summed over nm"
)
RGB_NOTE = "scene-linear Rec.709 (D65), from XYZ as in xyz.exr without normalisation"
TWIN_STEP = "rgb"


class SceneChangedError(RenderError):
    """An unfinished render in the folder was made from something else."""


@dataclass(frozen=True)
class _Task:
    """What all parts of a render need; `warnings` and the pace grow."""

    scene: bpy.types.Scene
    probe: SpectralPanorama
    directory: Path
    samples: int
    settings: PassSettings
    render_to: RenderTo
    folder: PassFolder
    pace: Pace
    warnings: list[str]


def spectral_render(
    scene: bpy.types.Scene,
    probe: SpectralPanorama,
    plan: PassPlan | None,
    directory: Path,
    *,
    samples: int,
    passes: Passes = None,
    rgb_twin: bool = True,
    on_change: OnChange = "refuse",
) -> Job[SpectralRender]:
    """Render a scene in the spectral light of a panorama.

    Parameters
    ----------
    scene
        A Cycles scene with a camera. It comes back exactly as it was, whatever happens.
    probe
        The light. A world made by "Light the World" turns and scales it; without one it is used as it is.
    plan
        The passes; None makes a plan for this scene and this light. A light-basis plan must have been made for the
        layers of this panorama.
    directory
        Where to write passes/, xyz.exr, image.exr, rgb.exr, plan.json and report.json. Finished passes of an interrupted
        render of the same scene in the same light are kept, and not rendered again.
    samples
        Samples per pixel of a full pass.
    passes
        Where `plan` is None: the number of light-basis passes, "all" for the 61-wavelength reference, or None (or 0) for
        as few as predict a small colour error.
    rgb_twin
        Also render the scene in plain RGB, lit by the same panorama in Rec.709.
    on_change
        What to do with passes of an unfinished render of something else: "refuse" raises, "restart" renders anew,
        "resume" takes them as they are, with their plan and samples.

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
        If the scene cannot be rendered as asked; a `SceneChangedError` if `on_change` has to be decided.
    """
    check_scene(scene, samples)
    directory = Path(directory)
    request = repr(passes or None) if plan is None else "given"
    fingerprint = _fingerprint(scene, probe, samples, request)
    folder = _open(directory, fingerprint, scene, on_change)
    if folder.finished:
        plan, samples = load_plan(directory / "plan.json"), int(folder.fingerprint["samples"])
    for name in (REPORT_NAME, "xyz.exr", "image.exr", "rgb.exr"):
        (directory / name).unlink(missing_ok=True)
    with ExitStack() as stack:
        settings = stack.enter_context(pass_settings(scene))
        warnings = list(settings.warnings)
        render_to = stack.enter_context(pass_output(scene, settings.layers))
        pace = Pace(1)
        task = _Task(scene, probe, directory, samples, settings, render_to, folder, pace, warnings)
        spectral = yield from _spectral_passes(task, plan, passes, rgb_twin)
        seconds_rgb = None
        if rgb_twin:
            seconds_rgb = yield from _rgb_twin(task)
    result = replace(
        spectral,
        rgb=directory / "rgb.exr" if rgb_twin else None,
        seconds_rgb=seconds_rgb,
        warnings=tuple(dict.fromkeys(warnings)),
    )
    write_report(result, scene, read_pass(result.passes[0]).groups[WORLD].shape[1::-1])
    return result


def unfinished(
    scene: bpy.types.Scene, probe: SpectralPanorama, directory: Path, *, samples: int, passes: Passes
) -> str:
    """Why passes of an unfinished render in a folder cannot simply be gone on with; empty where they can, or are none."""
    try:
        _open(
            directory, _fingerprint(scene, probe, samples, repr(passes or None)), scene, "refuse", make=False
        )
    except SceneChangedError as error:
        return str(error)
    return ""


def scene_plan(scene: bpy.types.Scene, probe: SpectralPanorama, passes: Passes = None) -> PassPlan:
    """The plan that `spectral_render` makes for a scene and its light; see there for `passes`."""
    if passes == "all":
        return reference_plan()
    with spectral_materials(scene, one_wavelength=True) as materials:
        return LayerLight(probe, []).plan(_stacked(materials.spectra), passes)


def check_scene(scene: bpy.types.Scene, samples: int) -> None:
    """Refuse a scene that cannot be rendered spectrally.

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
    check_textures(scene)


# ---------------------------------------------------------------- what an earlier render left


def _fingerprint(
    scene: bpy.types.Scene, probe: SpectralPanorama, samples: int, request: str
) -> dict[str, str]:
    return {
        "scene": scene_fingerprint(scene),
        "light": light_fingerprint(probe),
        "samples": str(samples),
        "passes": request,
        "blender": bpy.app.version_string,
    }


def _open(
    directory: Path,
    fingerprint: dict[str, str],
    scene: bpy.types.Scene,
    on_change: OnChange,
    make: bool = True,
) -> PassFolder:
    """The folder of the passes: as an interrupted render left it, or a new one."""
    layers = [layer.name for layer in enabled_layers(scene)]
    earlier = open_pass_folder(directory / "passes")
    if earlier is not None and earlier.finished and on_change != "restart":
        changes = earlier.changes(fingerprint)
        if on_change == "resume" or not changes:
            if (directory / "plan.json").is_file():
                return earlier
        elif not (directory / REPORT_NAME).is_file():
            named = " and ".join(", ".join(changes).rsplit(", ", 1))
            raise SceneChangedError(
                f"{directory} has {len(earlier.finished)} passes of an unfinished render, and since then its {named} "
                "changed. Render anew (--restart), or use them as they are (--resume)."
            )
    return new_pass_folder(directory / "passes", fingerprint, layers) if make else PassFolder(directory, {})


# ---------------------------------------------------------------- passes


def _spectral_passes(
    task: _Task, plan: PassPlan | None, passes: Passes, rgb_twin: bool
) -> Job[SpectralRender]:
    """Render all steps and put them together."""
    scene, directory, kept = task.scene, task.directory, bool(task.folder.finished)
    kind = plan.kind if plan else "wavelength" if passes == "all" else "light-basis"
    with ExitStack() as stack:
        materials = stack.enter_context(spectral_materials(scene, one_wavelength=kind == "light-basis"))
        task.warnings.extend(materials.warnings)
        yield task.pace.progress("Planning the passes")
        light = (LayerLight if kind == "light-basis" else WavelengthLight)(task.probe, task.warnings)
        if plan is None:
            plan = light.plan(_stacked(materials.spectra), passes)
        if not kept:
            plan = light.checked(plan)
            save_plan(plan, directory / "plan.json")
        steps = render_steps(plan, task.samples)
        task.pace.total = sum(step.samples for step in steps) + rgb_twin * task.samples
        steps_kept = yield from _render_steps(task, plan, steps, light, materials)
    start = time.perf_counter()
    _write_images(task, plan, steps)
    return SpectralRender(
        xyz=directory / "xyz.exr",
        image=directory / "image.exr",
        rgb=None,
        layers=task.folder.view_layers,
        passes=tuple(task.folder.path(step.name) for step in steps),
        plan=plan,
        samples=task.samples,
        seconds_spectral=sum(task.folder.finished[step.name].seconds for step in steps),
        seconds_rgb=None,
        seconds_assembly=time.perf_counter() - start,
        steps_kept=steps_kept,
        device=device_name(scene),
        warnings=(),
        light_residual=light.residual,
    )


def _render_steps(
    task: _Task,
    plan: PassPlan,
    steps: tuple[RenderStep, ...],
    light: LayerLight | WavelengthLight,
    materials: SpectralMaterials,
) -> Job[int]:
    """Render the steps that are not finished yet; returns how many were."""
    missing = [step for step in steps if not task.folder.holds(step.name)]
    task.pace.skip(sum(step.samples for step in steps if step not in missing))
    if not missing:
        return len(steps)
    lit: object = None
    with temporary_light(task.scene, *task.probe.weights.shape[:2]) as set_light:
        for number, step in enumerate(steps):
            if step not in missing:
                continue
            yield task.pace.progress(step_message(plan, steps, number, task.samples))
            start = time.perf_counter()
            wavelengths = plan.wavelengths_nm[step.pass_number]
            wanted = step.pass_number if plan.kind == "wavelength" else plan.light_sets[step.pass_number]
            if wanted != lit:
                set_light(light.pixels(wavelengths))
                lit = wanted
            materials.set_wavelengths(wavelengths)
            task.settings.set_samples(
                sequence_samples(plan, task.samples, step), step.first_sample, step.samples
            )
            task.render_to(task.folder.path(step.name), [WORLD], step.guide)
            seconds = time.perf_counter() - start
            task.folder.record(step.name, seconds, step.samples)
            task.pace.add(step.samples, seconds)
    return len(steps) - len(missing)


def _rgb_twin(task: _Task) -> Job[float]:
    """Render the RGB twin with the same samples, write rgb.exr in the unit of image.exr, and return the seconds."""
    to_rec709 = working_to_rec709()
    world = panorama_rec709(task.probe)
    level = float(world.mean())
    folder = task.folder
    path = folder.path(TWIN_STEP)  # in the working space and at the level of the passes
    if not folder.holds(TWIN_STEP):
        yield task.pace.progress("Rendering in RGB")
        with rgb_materials(task.scene), temporary_light(task.scene, *world.shape[:2]) as set_light:
            start = time.perf_counter()
            set_light(world @ np.linalg.inv(to_rec709).T / level)
            task.settings.set_samples(task.samples, 0, task.samples)
            task.render_to(path, [WORLD], False)
            folder.record(TWIN_STEP, time.perf_counter() - start, task.samples)
    note = "scene-linear Rec.709 (D65), rendered in RGB, in the unit of image.exr"
    for number, suffix in enumerate(_layer_suffixes(folder.view_layers)):
        image = read_pass(path, number)
        rgb = image.groups[WORLD] @ to_rec709.T.astype(np.float32) * level
        write_channels(
            task.directory / f"rgb{suffix}.exr", _rgb_channels(rgb) | _alpha(image), {"comments": note}
        )
    return folder.finished[TWIN_STEP].seconds


# ---------------------------------------------------------------- results


def _write_images(task: _Task, plan: PassPlan, steps: tuple[RenderStep, ...]) -> None:
    """Put the steps of every view layer together."""
    folder = task.folder
    for number, suffix in enumerate(_layer_suffixes(folder.view_layers)):
        images = (read_pass(folder.path(step.name), number) for step in steps)
        first = read_pass(folder.path(steps[0].name), number)
        xyz = combine_xyz(plan, (image.groups[WORLD] for image in images))
        write_channels(
            task.directory / f"xyz{suffix}.exr",
            dict(zip("XYZ", np.moveaxis(xyz, -1, 0), strict=True)),
            {"comments": XYZ_NOTE},
        )
        write_channels(
            task.directory / f"image{suffix}.exr",
            _rgb_channels(xyz_to_rec709(xyz)) | _alpha(first),
            {"comments": RGB_NOTE},
        )


def _layer_suffixes(names: tuple[str, ...]) -> list[str]:
    """What tells the files of the view layers apart: nothing for the first, the layer's name for the others."""
    cleaned = [bpy.path.clean_name(name) for name in names]
    return ["", *(f"_{name}" if cleaned.count(name) == 1 else f"_{name}_{number}"
                  for number, name in enumerate(cleaned[1:], start=2))]  # fmt: skip


def _stacked(spectra: list[Array]) -> Array:
    return np.concatenate(spectra) if spectra else np.ones((1, 61))


def _rgb_channels(rgb: Array) -> dict[str, Array]:
    return dict(zip("RGB", np.moveaxis(rgb, -1, 0), strict=True))


def _alpha(image: PassImage) -> dict[str, Array]:
    """The alpha channel of a pass, if it has one (transparent film)."""
    return {} if image.alpha is None else {"A": image.alpha}

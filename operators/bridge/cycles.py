"""The spectral render: one Cycles render per pass of a plan, with the scene as it was afterwards.

What Cycles would add to or take from the light is off in the passes and in the RGB twin alike: clamping, filtered glossy
rays, adaptive sampling and denoising bias a pass, each in its own way, and passes must add up. Lamps and emitting materials are
not spectral yet: they are left out of both and named in `warnings`. Compositing and the sequencer are bypassed, and only the
first enabled view layer is rendered.
"""

import json
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import bpy
import numpy as np

from ...spectral_probe.errors import RenderError
from ...spectral_probe.files.atomic import written_whole
from ...spectral_probe.files.image_exr import read_channels, read_rgb, write_channels
from ...spectral_probe.model import Job, Progress, SpectralPanorama
from ...spectral_probe.render.combine import combine_xyz
from ...spectral_probe.render.plan import reference_plan, save_plan
from ...spectral_probe.render_model import PassPlan
from ...spectral_probe.spectra.colorimetry import xyz_to_rec709
from .images import exr_renders
from .light import LayerLight, WavelengthLight, panorama_rec709
from .materials import rgb_materials, spectral_materials, working_to_rec709
from .restore import changed, in_scene, refuse_linked, stand_in
from .world import temporary_light

type Array = np.ndarray[Any, Any]

XYZ_NOTE = (
    "CIE 1931 2 degree tristimulus values: spectral radiance times colour-matching functions, summed over nm"
)
RGB_NOTE = "scene-linear Rec.709 (D65), from XYZ as in xyz.exr without normalisation"


@dataclass(frozen=True)
class SpectralRender:
    """What a spectral render left in its folder.

    `seconds_rgb` and `rgb` are None without the RGB twin. `light_residual` is the share of the panorama's energy that three
    light layers do not hold (0 in a wavelength plan).
    """

    xyz: Path
    image: Path
    rgb: Path | None
    passes: tuple[Path, ...]
    plan: PassPlan
    samples: int
    seconds_spectral: float
    seconds_rgb: float | None
    device: str
    warnings: tuple[str, ...]
    light_residual: float


@dataclass(frozen=True)
class _Task:
    """What all steps of a render need; `warnings` grows."""

    scene: bpy.types.Scene
    probe: SpectralPanorama
    directory: Path
    samples: int
    rgb_twin: bool
    render_to: Callable[[Path], None]
    warnings: list[str]


def spectral_render(
    scene: bpy.types.Scene,
    probe: SpectralPanorama,
    plan: PassPlan | None,
    directory: Path,
    *,
    samples: int,
    passes: int | Literal["all"] | None = None,
    rgb_twin: bool = True,
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
        Where to write passes/, xyz.exr, image.exr, rgb.exr, plan.json and report.json.
    samples
        Samples per pixel of a full pass.
    passes
        Where `plan` is None: the number of light-basis passes, "all" for the 61-wavelength reference, or None (or 0) for
        as few as predict a small colour error.
    rgb_twin
        Also render the scene in plain RGB, lit by the same panorama in Rec.709.

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
        If the scene cannot be rendered as asked.
    """
    _check(scene, samples)
    directory = Path(directory)
    with ExitStack() as stack:
        warnings = _layer_warnings(scene)
        render_to = stack.enter_context(_settings(scene))
        warnings += stack.enter_context(_without_lamps(scene))
        task = _Task(scene, probe, directory, samples, rgb_twin, render_to, warnings)
        spectral = yield from _spectral_passes(task, plan, passes)
        seconds_rgb = None
        if rgb_twin:
            yield Progress(spectral.plan.passes / (spectral.plan.passes + 1), "Rendering in RGB")
            seconds_rgb = _rgb_twin(task)
    result = replace(
        spectral,
        rgb=directory / "rgb.exr" if rgb_twin else None,
        seconds_rgb=seconds_rgb,
        warnings=tuple(dict.fromkeys(warnings)),
    )
    _write_report(result, scene, directory)
    return result


def scene_plan(
    scene: bpy.types.Scene, probe: SpectralPanorama, passes: int | Literal["all"] | None = None
) -> PassPlan:
    """The plan that `spectral_render` makes for a scene and its light; see there for `passes`."""
    if passes == "all":
        return reference_plan()
    with spectral_materials(scene, one_wavelength=True) as materials:
        return LayerLight(probe, []).plan(_stacked(materials.spectra), passes)


def _check(scene: bpy.types.Scene, samples: int) -> None:
    if scene.render.engine != "CYCLES":
        raise RenderError(
            f'Scene "{scene.name}" does not render with Cycles. Set Render Engine to Cycles: no other engine knows '
            "the refractive index of metals."
        )
    if scene.camera is None:
        raise RenderError(f'Scene "{scene.name}" has no camera. Add one and make it the active camera.')
    if samples < 1:
        raise RenderError(f"{samples} samples were asked for; give at least 1.")


# ---------------------------------------------------------------- the scene while it renders


@contextmanager
def _settings(scene: bpy.types.Scene) -> Iterator[Callable[[Path], None]]:
    """Render settings of the passes: nothing that biases, one layer; yields the function that renders to a file."""
    with ExitStack() as stack:
        stack.enter_context(
            changed(
                scene.cycles,
                sample_clamp_direct=0.0,
                sample_clamp_indirect=0.0,
                blur_glossy=0.0,
                use_adaptive_sampling=False,
                use_denoising=False,
                use_fast_gi=False,
                use_sample_subset=False,
                time_limit=0.0,
                film_exposure=1.0,
                samples=scene.cycles.samples,
            )
        )
        stack.enter_context(
            changed(scene.render, use_persistent_data=True, use_multiview=False, use_stamp=False)
        )
        layer = _view_layer(scene)
        stack.enter_context(changed(layer, samples=0, world_override=None))
        yield stack.enter_context(exr_renders(scene, layer))


@contextmanager
def _without_lamps(scene: bpy.types.Scene) -> Iterator[list[str]]:
    """The scene with dark lamps; yields warnings that name them."""
    warnings: list[str] = []
    with ExitStack() as stack:
        lamps = in_scene(scene, bpy.data.lights)
        for lamp in lamps:
            dark = bpy.data.lights.new("Spectral Probe Dark", "POINT")
            dark.energy = 0.0
            stack.enter_context(stand_in(lamp, dark))
            warnings.append(
                f'Lamp "{lamp.name}" is not spectral yet and was left out, of the RGB render too.'
            )
        refuse_linked(scene, lamps, "Lamp")
        yield warnings


def _view_layer(scene: bpy.types.Scene) -> bpy.types.ViewLayer:
    return next((layer for layer in scene.view_layers if layer.use), scene.view_layers[0])


def _layer_warnings(scene: bpy.types.Scene) -> list[str]:
    rendered = _view_layer(scene)
    return [
        f'View layer "{layer.name}" was not rendered: a spectral render takes the first enabled layer only.'
        for layer in scene.view_layers
        if layer.use and layer != rendered
    ]


# ---------------------------------------------------------------- passes


def _spectral_passes(
    task: _Task, plan: PassPlan | None, passes: int | Literal["all"] | None
) -> Job[SpectralRender]:
    """Render all passes and put them together."""
    scene, directory = task.scene, task.directory
    kind = plan.kind if plan else "wavelength" if passes == "all" else "light-basis"
    with ExitStack() as stack:
        materials = stack.enter_context(spectral_materials(scene, one_wavelength=kind == "light-basis"))
        task.warnings.extend(materials.warnings)
        materials.shine(False)
        task.warnings.extend(
            f"{label} emits light. Emission is not spectral yet and was left out."
            for label in materials.emitters
        )
        yield Progress(0.0, "Planning the passes")
        light = (LayerLight if kind == "light-basis" else WavelengthLight)(task.probe, task.warnings)
        if plan is None:
            plan = light.plan(_stacked(materials.spectra), passes)
        plan = light.checked(plan)
        save_plan(plan, directory / "plan.json")
        set_light = stack.enter_context(temporary_light(scene, *task.probe.weights.shape[:2]))
        paths = _pass_paths(directory, plan)
        seconds = 0.0
        for number, path in enumerate(paths):
            wavelengths = plan.wavelengths_nm[number]
            named = ", ".join(f"{nm:g}" for nm in dict.fromkeys(wavelengths))
            message = f"Pass {number + 1} of {plan.passes}: {named} nm"
            yield Progress(number / (plan.passes + task.rgb_twin), message)
            start = time.perf_counter()
            if number == 0 or kind == "wavelength":
                set_light(light.pixels(wavelengths))
            materials.set_wavelengths(wavelengths)
            scene.cycles.samples = max(1, round(task.samples * float(plan.sample_shares[number])))
            task.render_to(path)
            seconds += time.perf_counter() - start

    xyz = combine_xyz(plan, (read_rgb(path) for path in paths))
    _write_image(directory / "xyz.exr", dict(zip("XYZ", np.moveaxis(xyz, -1, 0), strict=True)), XYZ_NOTE)
    _write_image(directory / "image.exr", _rgb_channels(xyz_to_rec709(xyz)) | _alpha(paths[0]), RGB_NOTE)
    return SpectralRender(
        xyz=directory / "xyz.exr",
        image=directory / "image.exr",
        rgb=None,
        passes=paths,
        plan=plan,
        samples=task.samples,
        seconds_spectral=seconds,
        seconds_rgb=None,
        device=_device(scene),
        warnings=(),
        light_residual=light.residual,
    )


def _pass_paths(directory: Path, plan: PassPlan) -> tuple[Path, ...]:
    """Files of the passes; those of an earlier render are removed first, lest the two be mixed."""
    for stale in (directory / "passes").glob("pass_*.exr"):
        stale.unlink()
    for name in ("report.json", "xyz.exr", "image.exr", "rgb.exr"):
        (directory / name).unlink(missing_ok=True)
    return tuple(directory / "passes" / f"pass_{number:02d}.exr" for number in range(plan.passes))


def _rgb_twin(task: _Task) -> float:
    """Render the RGB twin, write rgb.exr in the unit of image.exr, and return the seconds."""
    to_rec709 = working_to_rec709()
    world = panorama_rec709(task.probe)
    level = float(world.mean())
    path = task.directory / "passes" / "rgb.exr"  # in the working space and at the level of the passes
    with rgb_materials(task.scene), temporary_light(task.scene, *world.shape[:2]) as set_light:
        start = time.perf_counter()
        set_light(world @ np.linalg.inv(to_rec709).T / level)
        task.scene.cycles.samples = task.samples
        task.render_to(path)
        seconds = time.perf_counter() - start
    rgb = read_rgb(path) @ to_rec709.T.astype(np.float32) * level
    note = "scene-linear Rec.709 (D65), rendered in RGB, in the unit of image.exr"
    _write_image(task.directory / "rgb.exr", _rgb_channels(rgb) | _alpha(path), note)
    path.unlink()
    return seconds


# ---------------------------------------------------------------- results


def _stacked(spectra: list[Array]) -> Array:
    return np.concatenate(spectra) if spectra else np.ones((1, 61))


def _rgb_channels(rgb: Array) -> dict[str, Array]:
    return dict(zip("RGB", np.moveaxis(rgb, -1, 0), strict=True))


def _alpha(path: Path) -> dict[str, Array]:
    """The alpha channel of a pass, if it has one (transparent film)."""
    channels, _ = read_channels(path)
    return {"A": channels["A"]} if "A" in channels else {}


def _write_image(path: Path, channels: dict[str, Array], note: str) -> None:
    write_channels(path, channels, {"comments": note})


def _device(scene: bpy.types.Scene) -> str:
    if scene.cycles.device == "CPU":
        return "CPU"
    cycles = bpy.context.preferences.addons["cycles"].preferences
    names = [device.name for device in cycles.devices if device.use]
    return f"{cycles.compute_device_type}: {', '.join(names)}" if names else "CPU"


def _write_report(result: SpectralRender, scene: bpy.types.Scene, directory: Path) -> None:
    """Write report.json, last of all files: where it is, the render is complete."""
    render = scene.render
    report = {
        "seconds": {"spectral": result.seconds_spectral, "rgb": result.seconds_rgb},
        "kind": result.plan.kind,
        "passes": result.plan.passes,
        "wavelengths_nm": result.plan.wavelengths_nm.tolist(),
        "predicted_de2000": result.plan.predicted_de2000,
        "light_residual": result.light_residual,
        "samples": result.samples,
        "resolution": [render.resolution_x * render.resolution_percentage // 100,
                       render.resolution_y * render.resolution_percentage // 100],
        "frame": scene.frame_current,
        "scene": scene.name,
        "device": result.device,
        "blender": bpy.app.version_string,
        "warnings": list(result.warnings),
    }  # fmt: skip
    with written_whole(directory / "report.json") as temporary:
        temporary.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")

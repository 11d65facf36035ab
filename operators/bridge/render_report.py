"""What a spectral render leaves in its folder beside its pictures: plan.json and report.json."""

import json
import os
from dataclasses import dataclass
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

import bpy

from ...spectral_probe.files.atomic import written_whole
from ...spectral_probe.render.frame_record import FrameRecord
from ...spectral_probe.render_model import PassPlan

REPORT_NAME = "report.json"


@dataclass(frozen=True)
class SpectralRender:
    """What a spectral render left in its folder.

    `xyz`, `image` and `rgb` are those of the first view layer; `layers` names the view layers rendered, and the files of
    the others have their names after an underscore. `seconds_rgb` and `rgb` are None without the RGB twin.
    `light_residual` is the share of the panorama's energy that the light layers do not hold (0 in a wavelength plan).
    `steps_kept` of the `passes` (one file a step) were there from an interrupted render of the same scene.
    `objects` says which pixels show which of the `virtual` objects; `without` is the same render with the `catchers` alone,
    where there are any.
    """

    xyz: Path
    image: Path
    rgb: Path | None
    layers: tuple[str, ...]
    passes: tuple[Path, ...]
    plan: PassPlan
    samples: int
    seconds_spectral: float
    seconds_rgb: float | None
    seconds_assembly: float
    steps_kept: int
    device: str
    warnings: tuple[str, ...]
    light_residual: float
    objects: Path | None = None
    without: "SpectralRender | None" = None
    catchers: tuple[str, ...] = ()
    virtual: tuple[str, ...] = ()


def write_report(
    result: SpectralRender, record: FrameRecord, size_px: tuple[int, int], directory: Path
) -> None:
    """Write report.json into a folder, last of all files: where it is, the render is complete."""
    without = result.without
    report = {
        "seconds": {
            "spectral": result.seconds_spectral,
            "rgb": result.seconds_rgb,
            "assembly": result.seconds_assembly,
        },
        "kind": result.plan.kind,
        "passes": result.plan.passes,
        "steps": len(result.passes),
        "steps_kept": result.steps_kept,
        "wavelengths_nm": result.plan.wavelengths_nm.tolist(),
        "predicted_de2000": result.plan.predicted_de2000,
        "predicted_cost": result.plan.predicted_cost,
        "light_residual": result.light_residual,
        "mean_light": None if record.mean_light is None else record.mean_light.tolist(),
        "samples": result.samples,
        "resolution": list(size_px),
        "view_layers": list(result.layers),
        "objects": list(result.virtual),
        "shadow_catchers": list(result.catchers),
        "without": None if without is None else _of_the_other(without),
        "frame": record.frame,
        "scene": record.scene,
        "blend": record.blend,
        "device": result.device,
        "blender": record.blender,
        "warnings": list(result.warnings),
    }
    with written_whole(directory / REPORT_NAME) as temporary:
        temporary.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")


def blend_of_part(blend: str | None, directory: Path, part: Path) -> str | None:
    """Where the .blend lies from the folder of a part, by where it lies from that of its frame."""
    absolute = blend is None or PurePosixPath(blend).is_absolute() or PureWindowsPath(blend).is_absolute()
    if absolute or part == directory:
        return blend
    return "/".join([*(".." for _ in part.relative_to(directory).parts), str(blend)])


def blend_from(folder: Path) -> str | None:
    """Where the .blend lies, from the folder of its render, so that both can be moved; None where it was never saved."""
    if not bpy.data.filepath:
        return None
    try:
        return Path(os.path.relpath(bpy.data.filepath, folder)).as_posix()
    except ValueError:  # on another drive
        return bpy.data.filepath


def _of_the_other(without: SpectralRender) -> dict[str, Any]:
    """Where the render without the objects is, and what it took."""
    return {
        "folder": without.xyz.parent.name,
        "seconds": {"spectral": without.seconds_spectral, "rgb": without.seconds_rgb},
        "steps_kept": without.steps_kept,
    }


def device_name(scene: bpy.types.Scene) -> str:
    """What Cycles renders on."""
    if scene.cycles.device == "CPU":
        return "CPU"
    cycles = bpy.context.preferences.addons["cycles"].preferences
    names = [device.name for device in cycles.devices if device.use]
    return f"{cycles.compute_device_type}: {', '.join(names)}" if names else "CPU"

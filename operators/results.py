"""What the jobs gave, kept in the scene so that panels can show it and the .blend saves it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy

from .settings import built_folder

if TYPE_CHECKING:
    from ..spectral_probe.editing import EditedLight
    from ..spectral_probe.render_model import PassPlan
    from .bridge.cycles import SpectralRender


def keep_probe(settings: bpy.types.PropertyGroup, report: Mapping[str, Any]) -> None:
    """Keep the numbers of a probe's report (report.json); a new probe has no edits."""
    settings.property_unset("edits")
    settings.packed.outdated = bool(settings.packed.files)
    kept = settings.probe
    kept.directory = settings.probe_directory
    kept.width_px, kept.height_px = report["width"], report["width"] // 2
    kept.blind_fraction = report["blind_fraction"]
    kept.seconds = sum(report["seconds"].values())
    kept.warnings = "\n".join(report["warnings"])
    for view, row in zip(settings.views, report["views"], strict=True):
        view.has_probe = True
        view.probe_azimuth = math.radians(row["azimuth_deg"])
        view.probe_rms_px = row["outline_rms_px"]
        view.clipped_fraction = row["clipped_fraction"]


def kept_path(written: str | Path, directory: str) -> str:
    """A path within a folder of the settings, relative to the .blend where the folder is; any other as it is."""
    folder = Path(bpy.path.abspath(directory))
    if not directory.startswith("//") or not Path(written).is_relative_to(folder):
        return str(written)
    return f"{directory.rstrip('/')}/{Path(written).relative_to(folder).as_posix()}"


def keep_edits(settings: bpy.types.PropertyGroup, light: EditedLight) -> None:
    """Keep the list of a probe's edits, and which folder holds its light now."""
    kept = settings.edits
    kept.items.clear()
    for number in light.edits:
        item = kept.items.add()
        item.name, item.kind, item.region = number["name"], number["kind"], number["region"]
        item.solid_angle_sr = number["solid_angle_sr"]
    settings.packed.outdated = bool(settings.packed.files)
    kept.active_edit = max(0, len(kept.items) - 1)
    kept.probe_directory = settings.probe_directory
    as_built = light.directory == built_folder(settings)
    kept.state = "" if as_built else light.directory.name


def keep_render(settings: bpy.types.PropertyGroup, result: SpectralRender) -> None:
    """Keep the numbers of a spectral render."""
    kept = settings.render
    kept.directory = settings.render_directory
    kept.passes, kept.samples = result.plan.passes, result.samples
    kept.predicted_de2000 = (result.plan.predicted_de2000 or (0.0, 0.0))[0]
    kept.seconds = result.seconds_spectral
    kept.has_rgb = result.seconds_rgb is not None
    kept.rgb_seconds = result.seconds_rgb or 0.0
    kept.warnings = "\n".join(result.warnings)


def keep_plan(settings: bpy.types.PropertyGroup, plan: PassPlan) -> None:
    """Keep what a plan predicts, before anything is rendered."""
    from ..spectral_probe.render.plan import describe

    kept = settings.planned
    kept.kind = {"light-basis": "Light layers", "wavelength": "Wavelengths"}[plan.kind]
    kept.passes = plan.passes
    kept.mean_de2000, kept.max_de2000 = plan.predicted_de2000 or (0.0, 0.0)
    kept.cost = plan.predicted_cost or 0.0
    kept.text = "\n".join(describe(plan))


def keep_comparison(settings: bpy.types.PropertyGroup, report: Mapping[str, Any]) -> None:
    """Keep the numbers of a comparison (compare.json), over the whole image and by object."""
    kept, image = settings.comparison, report["image"]
    differences = image["blurred"] or image["raw"]
    kept.directory = kept_path(report["written"], settings.render_directory)
    kept.mean_de2000 = differences["mean"]
    kept.p95_de2000 = differences["p95"]
    kept.max_de2000 = differences["max"]
    kept.xy_shift = image["xy_shift"]
    kept.warnings = "\n".join(report["remarks"])
    settings.compare.objects.clear()
    for number in report["objects"]:
        row = settings.compare.objects.add()
        differences = number["blurred"] or number["raw"]
        row.name, row.xy_shift = number["name"], number["xy_shift"]
        row.mean_de2000, row.p95_de2000 = differences["mean"], differences["p95"]


def keep_spectrum(settings: bpy.types.PropertyGroup, numbers: Mapping[str, Any]) -> None:
    """Keep the numbers of a direction's spectrum; 0 where one is not defined."""
    kept = settings.spectrum
    kept.has_numbers, kept.has_comparison = True, "gfc" in numbers
    for name in ("confidence", "cct_kelvin", "duv", "ra", "rf", "gfc", "relative_rmse", "de2000_light"):
        setattr(kept, name, numbers.get(name) or 0.0)

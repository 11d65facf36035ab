"""What the jobs gave, kept in the scene so that panels can show it and the .blend saves it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy

if TYPE_CHECKING:
    from ..spectral_probe.render.compare import Comparison


def keep_probe(settings: bpy.types.PropertyGroup, report: Mapping[str, Any]) -> None:
    """Keep the numbers of a probe's report (report.json)."""
    kept = settings.probe
    kept.directory = settings.probe_directory
    kept.width_px, kept.height_px = report["width"], report["width"] // 2
    kept.blind_fraction = report["blind_fraction"]
    kept.seconds = sum(report["seconds"].values())
    for view, row in zip(settings.views, report["views"], strict=True):
        view.has_probe = True
        view.probe_azimuth = math.radians(row["azimuth_deg"])
        view.probe_rms_px = row["outline_rms_px"]
        view.clipped_fraction = row["clipped_fraction"]


def keep_render(settings: bpy.types.PropertyGroup, report: Mapping[str, Any]) -> None:
    """Keep the numbers of a spectral render's report (report.json)."""
    kept = settings.render
    kept.directory = settings.render_directory
    kept.passes, kept.samples = report["passes"], report["samples"]
    kept.seconds = report["spectral_seconds"]
    kept.has_rgb = report.get("rgb_seconds") is not None
    kept.rgb_seconds = report.get("rgb_seconds") or 0.0


def keep_comparison(settings: bpy.types.PropertyGroup, comparison: Comparison, directory: Path) -> None:
    """Keep the numbers of a comparison over the whole image."""
    kept, image = settings.comparison, comparison.image
    kept.directory = str(directory)
    kept.mean_de2000 = image.differences.mean
    kept.p95_de2000 = image.differences.p95
    kept.max_de2000 = image.differences.max
    kept.xy_shift = image.xy_shift

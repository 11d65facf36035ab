"""Compare the spectral render with the RGB render of the same scene."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import bpy

from ..spectral_probe.model import Job, Progress
from .job import JobOperator
from .pictures import show
from .polls import has_render
from .results import keep_comparison

if TYPE_CHECKING:
    from ..spectral_probe.render.compare import Comparison


SHEET = "comparison.png"


def compare_renders(directory: Path) -> Job[Comparison]:
    """Compare xyz.exr with rgb.exr in a render folder; writes compare.json and the sheet beside them."""
    from ..spectral_probe.figures.sheet import SheetContent, comparison_sheet
    from ..spectral_probe.figures.style import save_figure
    from ..spectral_probe.files.image_exr import read_rgb
    from ..spectral_probe.render.compare import compare_images, write_comparison
    from ..spectral_probe.spectra.colorimetry import rec709_to_xyz

    yield Progress(0.0, "Reading the renders")
    xyz_spectral = read_rgb(directory / "xyz.exr", ("X", "Y", "Z"))
    xyz_rgb = rec709_to_xyz(read_rgb(directory / "rgb.exr"))
    yield Progress(0.2, "Measuring the differences")
    comparison = compare_images(xyz_spectral, xyz_rgb)
    write_comparison(directory / "compare.json", comparison)
    yield Progress(0.6, "Drawing the sheet")
    save_figure(comparison_sheet(SheetContent(comparison, xyz_spectral, xyz_rgb)), directory / SHEET)
    return comparison


class SPECTRAL_PROBE_OT_compare(JobOperator, bpy.types.Operator):
    """Measure how far the RGB render is from the spectral one, and show both with a map of the differences"""

    bl_idname = "spectral_probe.compare"
    bl_label = "Compare"

    in_thread = True

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be both renders."""
        return has_render(cls, context)

    def job(self, context: bpy.types.Context) -> Job[Comparison]:
        """Compare the two files of the render folder."""
        return compare_renders(_directory(context))

    def done(self, context: bpy.types.Context, result: Comparison) -> None:
        """Keep the numbers in the scene and show the sheet."""
        directory = _directory(context)
        keep_comparison(context.scene.spectral_probe, result, directory)
        show(context, directory / SHEET, "Comparison")
        self.report(
            {"INFO"}, f"RGB differs from spectral by ΔE {result.image.differences.mean:.2f} on average"
        )


def _directory(context: bpy.types.Context) -> Path:
    return Path(bpy.path.abspath(context.scene.spectral_probe.render_directory))

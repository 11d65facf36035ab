"""Show how sure the recovered spectra are."""

from pathlib import Path

import bpy

from ..spectral_probe.model import Job, Progress
from .job import JobOperator
from .pictures import show
from .polls import has_probe
from .settings import probe_folder


def confidence_picture(probe_path: Path) -> Job[Path]:
    """Draw the confidence of a probe beside it."""
    from ..spectral_probe.figures.confidence import confidence_preview
    from ..spectral_probe.figures.display import write_png
    from ..spectral_probe.files.probe_exr import read_probe

    yield Progress(0.0, "Reading the probe")
    panorama = read_probe(probe_path)
    yield Progress(0.6, "Drawing its confidence")
    picture = probe_path.with_name("confidence.png")
    write_png(picture, confidence_preview(panorama))
    return picture


class SPECTRAL_PROBE_OT_show_confidence(JobOperator, bpy.types.Operator):
    """Show in false colours how sure the spectrum of every direction is"""

    bl_idname = "spectral_probe.show_confidence"
    bl_label = "Show Confidence"

    in_thread = True

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a probe."""
        return has_probe(cls, context)

    def job(self, context: bpy.types.Context) -> Job[Path]:
        """Draw the probe's confidence anew: edits change it."""
        settings = context.scene.spectral_probe
        return confidence_picture(probe_folder(settings) / "probe.exr")

    def done(self, _context: bpy.types.Context, result: Path) -> None:
        """Show it."""
        show(result, "Confidence")

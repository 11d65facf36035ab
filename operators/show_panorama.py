"""Show the probe's panorama in the Image Editor: its light, how sure it is, or which kinds of light there are."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.props import EnumProperty

from ..spectral_probe.model import Job, Progress
from .bridge.opened_probe import MEMORY
from .bridge.panorama_image import PICTURES, load_picture
from .job import JobOperator
from .pictures import show_image
from .polls import has_probe
from .settings import probe_folder

PICTURE_ITEMS = (
    ("LIGHT", "Light", "The light as the eye would see it"),
    ("CONFIDENCE", "Confidence", "In false colours how sure the spectrum of every direction is"),
    ("KINDS", "Kinds of Light", "The likeliest kind of light of every direction, a colour for each"),
)


def panorama_picture(folder: Path, kind: str) -> Job[Path]:
    """Draw a picture of the probe in a folder, beside it; the light's is there since the probe was built.

    Raises
    ------
    SpectralProbeError
        If the probe cannot be read, or does not tell the kinds of its light, or its folder cannot be written to.
    """
    yield Progress(0.0, "Reading the probe")
    panorama = MEMORY.read(folder / "probe.exr").panorama
    picture = folder / PICTURES[kind]
    if kind != "LIGHT" or not picture.is_file():
        from ..spectral_probe.figures.confidence import confidence_preview
        from ..spectral_probe.figures.kinds import kinds_preview
        from ..spectral_probe.figures.panorama import panorama_preview, write_png
        from ..spectral_probe.files.atomic import check_folder

        yield Progress(0.6, "Drawing the panorama")
        check_folder(folder)
        draw = {"LIGHT": panorama_preview, "CONFIDENCE": confidence_preview, "KINDS": kinds_preview}[kind]
        write_png(picture, draw(panorama))
    return folder


class SPECTRAL_PROBE_OT_show_panorama(JobOperator, bpy.types.Operator):
    """Show the panorama of the probe in the Image Editor, to point at directions and draw regions in it"""

    bl_idname = "spectral_probe.show_panorama"
    bl_label = "Show Panorama"

    in_thread = True

    picture: EnumProperty(
        name="Picture",
        description="What the picture shows",
        items=PICTURE_ITEMS,
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a probe."""
        return has_probe(cls, context)

    def job(self, context: bpy.types.Context) -> Job[Path]:
        """Read the probe, and draw the picture where it is not there."""
        return panorama_picture(probe_folder(context.scene.spectral_probe), self.picture)

    def done(self, _context: bpy.types.Context, result: Path) -> None:
        """Show it."""
        show_image(load_picture(result, self.picture))

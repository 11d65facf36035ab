"""From the photographs to a lit scene, in one job."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import mkdtemp
from typing import TYPE_CHECKING

import bpy

from ..spectral_probe.model import Capture, Job, Photograph
from .build_probe import build_and_write, keep_built
from .detect_ball import FoundOutline, keep_found, views_with_balls, with_picture
from .job import JobOperator
from .light_world import WORLD_NAME, mean_luminance
from .polls import has_photographs
from .settings import capture_from, folder_of
from .view_outline import described
from .viewport import show_world

if TYPE_CHECKING:
    from ..spectral_probe.geometry.outline import FoundBall
    from ..spectral_probe.probe import Probe


@dataclass(frozen=True)
class Lit:
    """The outlines, the probe, and the mean luminance of its panorama `world_exr`."""

    outlines: list[FoundOutline]
    probe: Probe
    world_exr: Path
    luminance: float


def light_from(
    capture: Capture, width_px: int | None, directory: Path, pictures: Path, exposure_ev: float
) -> Job[Lit]:
    """Find the ball in every view, build the probe into a folder, and measure how bright its panorama is."""
    outlines: dict[int, FoundOutline] = {}
    wanted = views_with_balls(capture)

    def seen(number: int, photographs: Sequence[Photograph], found: FoundBall) -> None:
        if number in wanted:
            outline = described(found, photographs[0], capture)
            outlines[number] = with_picture(number, outline, photographs, pictures, exposure_ev)

    probe = yield from build_and_write(capture, width_px, directory, seen)
    world_exr = directory / WORLD_NAME
    return Lit([outlines[number] for number in wanted], probe, world_exr, mean_luminance(world_exr))


class SPECTRAL_PROBE_OT_light_from_photographs(JobOperator, bpy.types.Operator):
    """Find the ball in the photographs, recover the light around it, and light the scene with it"""

    bl_idname = "spectral_probe.light_from_photographs"
    bl_label = "Photographs to Light"

    in_thread = True
    needs = ("..spectral_probe.geometry.outline", "..spectral_probe.probe", ".view_outline", ".bridge.world")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be photographs."""
        return has_photographs(cls, context)

    def job(self, context: bpy.types.Context) -> Job[Lit]:
        """Read the settings and start."""
        settings = context.scene.spectral_probe
        directory = folder_of(settings.probe_directory, "probe")
        pictures = Path(mkdtemp(prefix="outlines_", dir=bpy.app.tempdir))
        width_px, exposure_ev = settings.probe_width or None, settings.overlay.exposure_ev
        return light_from(capture_from(settings), width_px, directory, pictures, exposure_ev)

    def done(self, context: bpy.types.Context, result: Lit) -> None:
        """Keep outlines and probe, and give the scene a world of its light, whose mean is 1."""
        from .bridge.world import light_world

        keep_found(self, context, result.outlines, in_new_window=False)
        keep_built(self, context, result.probe)
        light_world(context.scene, result.world_exr, strength=1.0 / result.luminance)
        show_world(context)

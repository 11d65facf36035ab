"""Turn the photographs into the spectral light probe."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..spectral_probe.errors import CaptureError
from ..spectral_probe.model import Capture, Job, part
from .job import JobOperator
from .polls import has_photographs
from .results import keep_probe
from .settings import capture_from, folder_of

if TYPE_CHECKING:
    from ..spectral_probe.probe import Probe, ViewSeen


def build_and_write(
    capture: Capture, width_px: int | None, directory: Path, seen: ViewSeen | None = None
) -> Job[Probe]:
    """Build the probe, as fine as the photographs where no width is given, and write its files.

    `seen` is told of every ball found.
    """
    from ..spectral_probe.files.lock import folder_lock
    from ..spectral_probe.probe import build_probe, write_outputs

    with folder_lock(directory):
        probe = yield from part(build_probe(capture, width_px, seen), 0.0, 0.8)
        yield from part(write_outputs(probe, directory), 0.8, 1.0)
    return probe


class SPECTRAL_PROBE_OT_build_probe(JobOperator, bpy.types.Operator):
    """Recover the spectrum of the light from every direction and write it to the probe folder"""

    bl_idname = "spectral_probe.build_probe"
    bl_label = "Build Probe"

    in_thread = True
    needs = ("..spectral_probe.probe",)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be photographs."""
        return has_photographs(cls, context)

    def job(self, context: bpy.types.Context) -> Job[Probe]:
        """Read the settings and start."""
        settings = context.scene.spectral_probe
        directory = folder_of(settings.probe_directory, "probe")
        return build_and_write(capture_from(settings), settings.probe_width or None, directory)

    def done(self, context: bpy.types.Context, result: Probe) -> None:
        """Keep the report's numbers in the scene."""
        keep_built(self, context, result)


def keep_built(operator: JobOperator, context: bpy.types.Context, result: Probe) -> None:
    """Keep the numbers of a probe's report in the scene, and tell them."""
    settings = context.scene.spectral_probe
    if len(settings.views) != len(result.report["views"]):
        raise CaptureError(rpt_("Views were added or removed meanwhile. Build the probe again."))
    keep_probe(settings, result.report)
    text = rpt_("Probe built: {blind:.1%} blind, {seconds:.1f} s")
    operator.tell("INFO", text.format(blind=settings.probe.blind_fraction, seconds=settings.probe.seconds))
    for warning in result.report["warnings"]:  # last, because the status bar shows the last report
        operator.tell("WARNING", warning)

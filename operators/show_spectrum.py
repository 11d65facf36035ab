"""Show the spectrum of the light from one direction."""

import math
from pathlib import Path
from typing import Any

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..spectral_probe.model import Job
from .job import JobOperator
from .pictures import show
from .polls import has_probe
from .results import keep_spectrum
from .settings import path_of, probe_folder

type Numbers = dict[str, Any]


def spectrum_job(settings: bpy.types.PropertyGroup, *, basis: bool = False) -> Job[Numbers]:
    """The job that writes the spectrum of the direction in the settings into the probe's folder."""
    from ..spectral_probe.spectrum_command import spectrum

    chosen = settings.spectrum
    probe = probe_folder(settings) / "probe.exr"
    # Four decimals: the settings are single precision, and file names are made of these numbers.
    at = (round(math.degrees(chosen.azimuth), 4) % 360.0, round(math.degrees(chosen.elevation), 4))
    return spectrum(probe, at, path_of(chosen.measured), None, math.degrees(chosen.radius), basis=basis)


class SPECTRAL_PROBE_OT_show_spectrum(JobOperator, bpy.types.Operator):
    """Plot the spectrum of the light from this direction with its 95 % band, as picture and table in the probe folder"""

    bl_idname = "spectral_probe.show_spectrum"
    bl_label = "Show Spectrum"

    in_thread = True

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a probe."""
        return has_probe(cls, context)

    def job(self, context: bpy.types.Context) -> Job[Numbers]:
        """Read the direction and start."""
        return spectrum_job(context.scene.spectral_probe)

    def done(self, context: bpy.types.Context, result: Numbers) -> None:
        """Keep the numbers and show the plot."""
        keep_spectrum(context.scene.spectral_probe, result)
        show(Path(result["plot"]), "Spectrum")
        self.tell("INFO", rpt_("Spectrum written to {file}").format(file=Path(result["csv"]).name))

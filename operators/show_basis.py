"""Show the basis functions that the spectra of one direction are made of."""

from pathlib import Path
from typing import Any

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..spectral_probe.model import Job
from .job import JobOperator
from .pictures import show
from .polls import has_probe
from .show_spectrum import spectrum_job

type Numbers = dict[str, Any]


class SPECTRAL_PROBE_OT_show_basis(JobOperator, bpy.types.Operator):
    """Plot the basis functions that the spectrum of this direction is made of"""

    bl_idname = "spectral_probe.show_basis"
    bl_label = "Show Basis"

    in_thread = True

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a probe."""
        return has_probe(cls, context)

    def job(self, context: bpy.types.Context) -> Job[Numbers]:
        """Read the direction and start."""
        return spectrum_job(context.scene.spectral_probe, basis=True)

    def done(self, _context: bpy.types.Context, result: Numbers) -> None:
        """Show the plot."""
        show(Path(result["basis_plot"]), "Basis")
        self.tell("INFO", rpt_("Basis written to {file}").format(file=Path(result["basis_plot"]).name))

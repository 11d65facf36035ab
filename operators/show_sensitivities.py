"""Show the spectral sensitivities of the camera."""

from pathlib import Path
from tempfile import mkdtemp

import bpy

from .base import FINISHED, OperatorResult, ReportsErrors
from .pictures import show
from .settings import path_of


class SPECTRAL_PROBE_OT_show_sensitivities(ReportsErrors, bpy.types.Operator):
    """Plot how the camera's channels answer to every wavelength"""

    bl_idname = "spectral_probe.show_sensitivities"
    bl_label = "Show Sensitivities"

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Draw the curves of the camera in the settings."""
        from ..spectral_probe.spectra.camera import REC709, camera_sensitivities
        from ..spectral_probe.spectrum_command import write_sensitivities

        camera = context.scene.spectral_probe.camera
        file = path_of(camera.sensitivities)
        name = file.name if file else camera.model or REC709
        curves = camera_sensitivities(camera.model or None, file)
        folder = Path(mkdtemp(prefix="sensitivities_", dir=bpy.app.tempdir))
        show(
            Path(write_sensitivities(folder / "sensitivities", curves, f"Spectral sensitivities: {name}")),
            "Sensitivities",
        )
        return FINISHED

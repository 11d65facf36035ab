"""Between the output settings of a scene and those that the core works with."""

from __future__ import annotations

import bpy

from ..spectral_probe.render.outputs import OutputSettings, output_settings


def output_settings_from(output: bpy.types.PropertyGroup) -> OutputSettings:
    """The settings of `Scene.spectral_probe.output`.

    Raises
    ------
    SpectralDataError
        If the white is not known.
    """
    return output_settings(
        spectral=output.spectral,
        white=output.white if output.adapt else "",
        denoise={"SCENE": None, "ON": True, "OFF": False}[output.denoise],
    )

"""What a spectral render writes: `Scene.spectral_probe.output`."""

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty


class SPECTRAL_PROBE_PG_output(bpy.types.PropertyGroup):
    """What a spectral render writes besides its tristimulus values, and how its picture is finished."""

    spectral: BoolProperty(
        name="All Wavelengths",
        description="Also write spectral.exr: radiance at 61 wavelengths, 400 to 700 nm, one channel each",
    )
    adapt: BoolProperty(
        name="Adapt White",
        description="Adapt the picture from a white of the scene to the display's, D65 (CAT16). "
        "Tristimulus values and spectra are never adapted",
    )
    white: StringProperty(
        name="White",
        description="An illuminant such as A or D50, a colour temperature such as 5000 K, or a chromaticity x,y",
        default="5000 K",
    )
    denoise: EnumProperty(
        name="Denoise",
        description="Whether the assembled picture is denoised, once for all wavelengths (Open Image Denoise)",
        items=(
            ("SCENE", "As the Scene", "Follow Render Properties > Sampling > Render > Denoise"),
            ("ON", "On", "Denoise the picture"),
            ("OFF", "Off", "Leave the noise in"),
        ),
    )

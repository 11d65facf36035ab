"""What materials and lamps are in spectral passes: `Material.spectral_probe` and `Light.spectral_probe`."""

from typing import Any

import bpy
from bpy.props import EnumProperty, StringProperty

from .library_pickers import lamp_names, metal_names, reflectance_names


def _light(of_what: str) -> Any:
    """Where the spectrum of light comes from."""
    return EnumProperty(
        name="Light",
        description=f"The spectrum of the light of {of_what}",
        items=(
            (
                "RGB",
                "From Colour",
                "Made from its colour, so that it looks as in RGB; that of a black body from its temperature",
            ),
            (
                "LAMP",
                "Measured Lamp",
                "The measured spectrum of a lamp; colour and strength say how bright it is",
            ),
        ),
    )


def _lamp() -> Any:
    """The lamp."""
    return StringProperty(
        name="Lamp",
        description='A lamp of the library such as "FL11", "Planck 3200 K" or "Daylight 6500 K", or a file with the columns '
        "wavelength_nm,power, covering 400-700 nm",
        default="A",
        subtype="FILE_PATH",
        options={"PATH_SUPPORTS_BLEND_RELATIVE"},
        search=lamp_names,
        search_options={"SUGGESTION"},
    )


class SPECTRAL_PROBE_PG_light(bpy.types.PropertyGroup):
    """What a lamp is in spectral passes."""

    light: _light("this lamp")
    lamp: _lamp()


class SPECTRAL_PROBE_PG_material(bpy.types.PropertyGroup):
    """What a material is in spectral passes."""

    kind: EnumProperty(
        name="Spectrum",
        description="How this material behaves at every wavelength",
        items=(
            ("RGB", "From Colours", "Spectra are made from the colours of the material's nodes"),
            ("METAL", "Metal", "Measured complex refractive index of a metal"),
            ("REFLECTANCE", "Reflectance", "Measured diffuse reflectance from a file"),
        ),
    )
    metal: StringProperty(
        name="Metal",
        description="Metal (Au, Ag, Cu, Al, ...) or a page of refractiveindex.info as shelf/book/page",
        default="Au",
        search=metal_names,
        search_options={"SUGGESTION"},
    )
    reflectance_path: StringProperty(
        name="Reflectance",
        description="A measured surface of the library, or a file with the columns wavelength_nm,reflectance, "
        "covering 400-700 nm",
        subtype="FILE_PATH",
        options={"PATH_SUPPORTS_BLEND_RELATIVE"},
        search=reflectance_names,
        search_options={"SUGGESTION"},
    )
    light: _light("what this material emits")
    lamp: _lamp()

"""What a material is in spectral passes: `Material.spectral_probe`."""

import bpy
from bpy.props import EnumProperty, StringProperty

from .library_pickers import metal_names, reflectance_names


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

"""What materials and lamps are in spectral passes: `Material.spectral_probe` and `Light.spectral_probe`."""

from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, StringProperty

from . import swatches
from .library_pickers import clear_material_names, glass_names, lamp_names, metal_names, reflectance_names


def _name_or_file(name: str, description: str, search: Any, default: str = "") -> Any:
    """A name of the library, or a file."""
    return StringProperty(
        name=name,
        description=description,
        default=default,
        subtype="FILE_PATH",
        options={"PATH_SUPPORTS_BLEND_RELATIVE"},
        search=search,
        search_options={"SUGGESTION"},
    )


def metal_name() -> Any:
    """The metal."""
    return StringProperty(
        name="Metal",
        description="Metal (Au, Ag, Cu, Al, ...), a page of refractiveindex.info as shelf/book/page, or a CSV file with the "
        "columns wavelength_nm,n,k",
        default="Au",
        search=metal_names,
        search_options={"SUGGESTION"},
    )


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
    return _name_or_file(
        "Lamp",
        'A lamp of the library such as "FL11", "Planck 3200 K" or "Daylight 6500 K", or a file with the columns '
        "wavelength_nm,power, covering 400-700 nm",
        lamp_names,
        "A",
    )


class SPECTRAL_PROBE_PG_light(bpy.types.PropertyGroup):
    """What a lamp is in spectral passes."""

    light: _light("this lamp")
    lamp: _lamp()
    chosen_lamp: swatches.chosen_lamp()


class SPECTRAL_PROBE_PG_material(bpy.types.PropertyGroup):
    """What a material is in spectral passes."""

    kind: EnumProperty(
        name="Spectrum",
        description="How this material behaves at every wavelength",
        items=(
            ("RGB", "From Colours", "Spectra are made from the colours of the material's nodes"),
            ("METAL", "Metal", "Measured complex refractive index of a metal"),
            ("REFLECTANCE", "Reflectance", "Measured diffuse reflectance, of the library or from a file"),
            ("GLASS", "Coloured Glass", "Measured transmittance of a pane, as a thin filter or as a body"),
            ("DISPERSIVE", "Dispersive Glass", "Clear glass that refracts each wavelength differently"),
        ),
    )
    metal: metal_name()
    reflectance_path: _name_or_file(
        "Reflectance",
        "A measured surface of the library, or a file with the columns wavelength_nm,reflectance, covering 400-700 nm",
        reflectance_names,
    )
    glass: _name_or_file(
        "Glass",
        "A stained glass of the library, or a file with the columns wavelength_nm,transmittance",
        glass_names,
        "red",
    )
    glass_as: EnumProperty(
        name="Use As",
        description="Where the glass takes its light",
        items=(
            (
                "FILTER",
                "Thin Filter",
                "At the surface, once each time it is passed: for a pane that is a single surface",
            ),
            ("BODY", "Body", "On the way through a closed body: the thicker, the darker"),
        ),
    )
    glass_thickness: FloatProperty(
        name="Thickness",
        description="Thickness of the pane whose transmittance was measured; what is thicker absorbs more",
        default=0.003,
        min=1e-6,
        soft_max=0.1,
        precision=4,
        unit="LENGTH",
    )
    glass_with_surfaces: BoolProperty(
        name="Measured With Surfaces",
        description="The transmittance includes the reflections of the pane's two surfaces, which the render has already: take "
        "them out. So it is with the glasses of the library",
        default=True,
    )
    index_from: EnumProperty(
        name="Index From",
        description="Where the refractive index over wavelength comes from",
        items=(
            ("PAGE", "Library", "A clear material, or a page of refractiveindex.info"),
            ("CAUCHY", "Cauchy", "n = A + B / um^2 + C / um^4"),
            ("SELLMEIER", "Sellmeier", "n^2 = 1 + sum of B um^2 / (um^2 - C)"),
        ),
    )
    clear_material: StringProperty(
        name="Material",
        description="A clear material (BK7, SF11, diamond, ...) or a page of refractiveindex.info as shelf/book/page",
        default="BK7",
        search=clear_material_names,
        search_options={"SUGGESTION"},
    )
    cauchy: FloatVectorProperty(
        name="Cauchy",
        description="A, B in square micrometres, C in micrometres to the fourth",
        size=3,
        default=(1.5046, 0.0042, 0.0),
        precision=5,
    )
    sellmeier_b: FloatVectorProperty(
        name="B",
        description="Strengths of the three resonances",
        size=3,
        default=(1.03961212, 0.231792344, 1.01046945),
        precision=6,
    )
    sellmeier_c: FloatVectorProperty(
        name="C",
        description="Squares of the wavelengths of the three resonances, in square micrometres",
        size=3,
        default=(0.00600069867, 0.0200179144, 103.560653),
        precision=6,
    )
    light: _light("what this material emits")
    lamp: _lamp()
    chosen_surface: swatches.chosen_surface()
    chosen_lamp: swatches.chosen_lamp()

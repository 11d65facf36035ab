"""Settings of what is known of the light: own lamps, regions with a light of their own, the known light to calibrate by."""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from .library_pickers import glass_names, lamp_names

# Mirrors the lamp families of spectral_probe/spectra/library.py, which is too heavy to import when Blender
# starts; a test compares the two.
FAMILIES = (
    ("incandescent", "Incandescent", "Filament and halogen lamps: smooth spectra, red-heavy"),
    ("daylight", "Daylight", "Sun and sky, through windows or outdoors"),
    ("fluorescent-halophosphate", "Fluorescent, Halophosphate", "Older tubes: broad bands and mercury lines"),
    ("fluorescent-broadband", "Fluorescent, Broadband", "High colour rendering tubes"),
    ("fluorescent-triband", "Fluorescent, Triband", "Modern tubes and compact lamps: three narrow bands"),
    ("led-phosphor", "LED, Phosphor", "White LEDs: a blue peak and a broad yellow band"),
    ("led-rgb", "LED, RGB", "White mixed from red, green and blue LEDs"),
    ("discharge", "Discharge", "Sodium, mercury and metal halide lamps"),
)

_SPECTRUM = "wavelength in nm and value, covering 400-700 nm"


def file_path(name: str, description: str) -> object:
    """Return a file path that may be relative to the .blend."""
    return StringProperty(
        name=name, description=description, subtype="FILE_PATH", options={"PATH_SUPPORTS_BLEND_RELATIVE"}
    )


def filter_file() -> object:
    """Return the filter of a view: a file, or the name of a glass."""
    return StringProperty(
        name="Filter",
        description="These photographs were taken through a filter: its transmittance as a CSV "
        f"({_SPECTRUM} 0 to 1), or the name of a glass. They belong to the view without a filter that has the same angles",
        subtype="FILE_PATH",
        options={"PATH_SUPPORTS_BLEND_RELATIVE"},
        search=glass_names,
        search_options={"SUGGESTION"},
    )


class SPECTRAL_PROBE_PG_own_light(bpy.types.PropertyGroup):
    """A measured lamp of the user's."""

    path: file_path("Spectrum", f"Measured spectrum of a lamp that may be present: CSV, {_SPECTRUM}")


class SPECTRAL_PROBE_PG_region_light(bpy.types.PropertyGroup):
    """A region of the panorama with a light of its own."""

    place: EnumProperty(
        name="Place",
        description="How the region is given",
        items=(
            ("SEED", "Point", "The window or lamp at one direction, as far as its light reaches"),
            ("POLYGON", "Polygon", "The smaller side of a polygon of directions"),
            ("MASK", "Mask", "An equirectangular picture, white inside"),
        ),
    )
    bearing: FloatProperty(
        name="Bearing",
        description="Compass bearing of a point in the window or lamp: 0 along +Y, clockwise seen from above",
        subtype="ANGLE",
    )
    elevation: FloatProperty(
        name="Elevation",
        description="Elevation of that point above the horizon",
        subtype="ANGLE",
        min=-1.5707964,
        max=1.5707964,
    )
    polygon_deg: StringProperty(
        name="Corners",
        description="Bearing and elevation of each corner in degrees, such as 10 5, 40 5, 25 30",
    )
    mask: file_path("Mask", "Equirectangular picture, white inside the region; its first row is up")
    light: EnumProperty(
        name="Light",
        description="What is known of the light in the region",
        items=(
            ("FAMILIES", "Lamp Families", "It is of one of these lamp families"),
            ("SPECTRUM", "Measured Spectrum", "Its spectrum was measured"),
        ),
    )
    families: EnumProperty(
        name="Lamps",
        description="Lamp families that may be present in the region",
        items=FAMILIES,
        options={"ENUM_FLAG"},
        default={"daylight"},
    )
    families_automatic: BoolProperty(
        name="Any Lamps", description="Any lamp family may be present in the region"
    )
    spectrum: file_path("Spectrum", f"Measured spectrum of the light in the region: CSV, {_SPECTRUM}")


class SPECTRAL_PROBE_PG_calibration(bpy.types.PropertyGroup):
    """One known light, and where it is seen."""

    source: EnumProperty(
        name="Known Light",
        description="A light of known spectrum gives the camera's channels their gains",
        items=(
            ("NONE", "None", "The sensitivities are taken as they are"),
            ("PATCH", "In a Photograph", "A card or lamp seen directly in the first photograph of a view"),
            ("BALL", "In the Ball", "A lamp or card that the ball mirrors"),
        ),
    )
    view: IntProperty(
        name="View", description="Number of the view whose first photograph shows it", default=1, min=1
    )
    patch_px: FloatVectorProperty(
        name="Patch",
        description="Left, upper, right and lower edge of the card or lamp, in pixels of the first photograph",
        size=4,
        min=0.0,
        precision=0,
    )
    bearing: FloatProperty(
        name="Bearing",
        description="Compass bearing of the lamp: 0 along +Y, clockwise seen from above",
        subtype="ANGLE",
    )
    elevation: FloatProperty(
        name="Elevation",
        description="Elevation of the lamp above the horizon",
        subtype="ANGLE",
        min=-1.5707964,
        max=1.5707964,
    )
    light: EnumProperty(
        name="Light",
        description="How its spectrum is known",
        items=(
            ("ILLUMINANT", "Illuminant", "A CIE illuminant or another light of the library"),
            ("SPECTRUM", "Measured Spectrum", "A spectrum measured there"),
        ),
    )
    illuminant: StringProperty(
        name="Illuminant",
        description="Name of the light, such as A, D65 or FL11",
        default="A",
        search=lamp_names,
        search_options={"SUGGESTION"},
    )
    spectrum: file_path("Spectrum", f"Measured spectrum of the light: CSV, {_SPECTRUM}")
    absolute: BoolProperty(
        name="Absolute",
        description="The spectrum is radiance in W m^-2 sr^-1 nm^-1, of the lamp itself or of a perfectly white card: the probe "
        "gets that unit",
    )
    reflectance: FloatProperty(
        name="Reflectance",
        description="How much of the light the card returns: 0.18 for a grey card, 1 for a lamp itself",
        default=1.0,
        min=1e-3,
        max=1.0,
        subtype="FACTOR",
    )
    reflectance_path: file_path(
        "Reflectance File",
        f"Measured reflectance of the card in place of a number: CSV, {_SPECTRUM} 0 to 1",
    )
    has_ball_patch: BoolProperty(
        name="Card in Ball",
        description="The ball mirrors the card too: this tells the ball's own reflectance",
    )
    ball_patch_px: FloatVectorProperty(
        name="Reflection",
        description="Left, upper, right and lower edge of the card's reflection in the ball, in pixels of the photograph",
        size=4,
        min=0.0,
        precision=0,
    )


class SPECTRAL_PROBE_PG_known_light(bpy.types.PropertyGroup):
    """What is known of the light beside the lamp families."""

    own_lights: CollectionProperty(type=SPECTRAL_PROBE_PG_own_light, name="Own Lights")
    active_own_light: IntProperty(name="Active Light", min=0)
    regions: CollectionProperty(type=SPECTRAL_PROBE_PG_region_light, name="Regions")
    active_region: IntProperty(name="Active Region", min=0)
    calibration: PointerProperty(type=SPECTRAL_PROBE_PG_calibration)


GROUPS = (
    SPECTRAL_PROBE_PG_own_light,
    SPECTRAL_PROBE_PG_region_light,
    SPECTRAL_PROBE_PG_calibration,
    SPECTRAL_PROBE_PG_known_light,
)
"""In the order in which Blender has to know them."""

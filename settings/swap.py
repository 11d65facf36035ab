"""Lights that can be exchanged after rendering, what takes their place, and the plan that says what it costs."""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    StringProperty,
)

from .library_pickers import glass_names, lamp_names
from .region import RegionPlace, table_file


def rendered_lights(settings: bpy.types.PropertyGroup, _context: bpy.types.Context, _edit: str) -> list[str]:
    """Names of the lights that the last render lets exchange, for the field that asks for one."""
    return [line.partition("\t")[0] for line in settings.lights.splitlines()]


class SPECTRAL_PROBE_PG_swappable(RegionPlace, bpy.types.PropertyGroup):
    """A region whose light has layers of its own, so that it can be exchanged; its name is that of the group."""


class SPECTRAL_PROBE_PG_swap(bpy.types.PropertyGroup):
    """The swappable regions, and the light to be exchanged in the finished render."""

    items: CollectionProperty(type=SPECTRAL_PROBE_PG_swappable, name="Swappable Regions")
    active_item: IntProperty(name="Active Region", min=0)
    lamps: BoolProperty(
        name="Lamps Too",
        description="Let the scene's lamps of a measured spectrum be exchanged after rendering, too: the light is then "
        "rendered in layers",
    )
    lights: StringProperty(
        name="Lights",
        description="Lights of the render that can be exchanged and what each is now, one a line, parted by a tab",
    )
    light: StringProperty(
        name="Light",
        description="Swappable region or lamp of the render whose light is exchanged",
        search=rendered_lights,
        search_options={"SUGGESTION"},
    )
    kind: EnumProperty(
        name="Becomes",
        description="What takes the place of the light",
        items=(
            ("LAMP", "Lamp", "Light of another lamp"),
            (
                "GLASS",
                "Glass",
                "The light behind another stained glass, without the one it was rendered with",
            ),
            ("ORIGINAL", "Original", "The light as it was rendered"),
        ),
    )
    lamp: StringProperty(
        name="Lamp",
        description="A light of the library, Planck 3200 K or Daylight 6500 K",
        default="LED-B3",
        search=lamp_names,
        search_options={"SUGGESTION"},
    )
    lamp_path: table_file("Spectrum", "CSV with wavelength_nm,power, in place of a lamp's name")
    glass: StringProperty(
        name="Glass",
        description="Stained glass before the light",
        default="red",
        search=glass_names,
        search_options={"SUGGESTION"},
    )
    glass_path: table_file(
        "Transmittance", "CSV with wavelength_nm,transmittance (0 to 1), in place of a glass's name"
    )
    keeps: EnumProperty(
        name="Keep",
        description="What of the light stays as it is under another lamp",
        items=(
            ("luminance", "Luminance", "As bright to the eye as before"),
            ("power", "Power", "As much radiant power from 400 to 700 nm as before"),
        ),
    )


class SPECTRAL_PROBE_PG_plan(bpy.types.PropertyGroup):
    """The plan last made: what the render would take, and how wrong it is predicted to be."""

    kind: StringProperty(name="Kind", description="Light layers, or wavelengths of light and material alike")
    passes: IntProperty(name="Passes", description="Cycles passes of the plan")
    mean_de2000: FloatProperty(
        name="Mean ΔE", description="Predicted mean colour error against all 61 wavelengths", precision=2
    )
    max_de2000: FloatProperty(
        name="ΔE of 99 %",
        description="Predicted colour error against all 61 wavelengths that 99 of 100 random pixels keep",
        precision=2,
    )
    cost: FloatProperty(
        name="Cost", description="Samples of all passes, in those of one RGB render", precision=2
    )
    text: StringProperty(name="Plan", description="The plan in words, one sentence a line")


CLASSES = (SPECTRAL_PROBE_PG_swappable, SPECTRAL_PROBE_PG_swap, SPECTRAL_PROBE_PG_plan)
"""To be registered before the scene's settings."""

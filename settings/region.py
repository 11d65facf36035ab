"""Where in the panorama, which glass or lamp, and the edits that a probe has: `Scene.spectral_probe.region` and `.edits`."""

import bpy
from bpy.props import (
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from .library_pickers import glass_names, lamp_names


def table_file(name: str, description: str) -> object:
    """A file with a spectrum, in place of a name."""
    return StringProperty(
        name=name, description=description, subtype="FILE_PATH", options={"PATH_SUPPORTS_BLEND_RELATIVE"}
    )


class RegionPlace:
    """Mixin: where in the panorama a region is."""

    kind: EnumProperty(
        name="Region",
        description="How the region is given",
        items=(
            ("SEED", "Point", "The window or lamp at one direction, as far as its light reaches"),
            ("POLYGON", "Polygon", "Corners joined by great circles"),
            ("MASK", "Mask", "A painted picture of the whole panorama, white inside"),
        ),
    )
    azimuth: FloatProperty(
        name="Bearing",
        description="Compass bearing of a point in the window or lamp: 0 along +Y, clockwise seen from above",
        subtype="ANGLE",
        precision=4,
    )
    elevation: FloatProperty(
        name="Elevation",
        description="Elevation of that point above the horizon",
        subtype="ANGLE",
        precision=4,
        min=-1.5707964,
        max=1.5707964,
    )
    polygon: StringProperty(
        name="Corners",
        description="Bearing and elevation of each corner in degrees, such as 10 0, 30 0, 30 20",
    )
    mask: PointerProperty(
        type=bpy.types.Image,
        name="Mask",
        description="Picture twice as wide as high, as the panorama: white is inside, black or transparent outside",
    )


class SPECTRAL_PROBE_PG_region(RegionPlace, bpy.types.PropertyGroup):
    """A region of the panorama, and the glass or lamp to put there."""

    glass: StringProperty(
        name="Glass",
        description="Stained glass put before the region",
        default="red",
        search=glass_names,
        search_options={"SUGGESTION"},
    )
    glass_path: table_file(
        "Transmittance", "CSV with wavelength_nm,transmittance (0 to 1), in place of a glass's name"
    )
    lamp: StringProperty(
        name="Lamp",
        description="Light that takes the place of the region's own: a name of the library, Planck 3200 K or Daylight 6500 K",
        default="LED-B3",
        search=lamp_names,
        search_options={"SUGGESTION"},
    )
    lamp_path: table_file("Spectrum", "CSV with wavelength_nm,power, in place of a lamp's name")
    keeps: EnumProperty(
        name="Keep",
        description="What of the region's light stays as it is under another lamp",
        items=(
            ("luminance", "Luminance", "As bright to the eye as before"),
            ("power", "Power", "As much radiant power from 400 to 700 nm as before"),
            (
                "surfaces",
                "Surfaces",
                "The colours of surfaces that the lamp lights, which must then be named",
            ),
        ),
    )
    was: StringProperty(
        name="Was",
        description="The lamp that the new one replaces: a name, or a CSV file",
        default="A",
        search=lamp_names,
        search_options={"SUGGESTION"},
    )


class SPECTRAL_PROBE_PG_edit(bpy.types.PropertyGroup):
    """One glass or lamp in the probe; its name is that of the group."""

    kind: EnumProperty(
        name="Kind",
        description="What was done to the light",
        items=(("glass", "Glass", "A stained glass"), ("lamp", "Lamp", "Another lamp")),
    )
    region: StringProperty(name="Region", description="Where the light was changed")
    solid_angle_sr: FloatProperty(
        name="Solid Angle", description="Size of the region in steradians", precision=4
    )


class SPECTRAL_PROBE_PG_edits(bpy.types.PropertyGroup):
    """The glasses and lamps in the probe's light, and which of its states lights the scene."""

    items: CollectionProperty(type=SPECTRAL_PROBE_PG_edit, name="Glasses and Lamps")
    active_edit: IntProperty(name="Active Edit", min=0)
    probe_directory: StringProperty(
        name="Probe",
        description="Folder of the probe that these edits belong to",
        subtype="DIR_PATH",
        options={"PATH_SUPPORTS_BLEND_RELATIVE"},
    )
    state: StringProperty(
        name="State",
        description="Folder with the edited light, within that of the probe. Empty: as it was built",
    )


CLASSES = (SPECTRAL_PROBE_PG_region, SPECTRAL_PROBE_PG_edit, SPECTRAL_PROBE_PG_edits)
"""To be registered before the scene's settings."""

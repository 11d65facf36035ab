"""What the panorama tools of the Image Editor show at this moment, on the window manager: nothing of it is saved."""

import math

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    FloatProperty,
    IntProperty,
    IntVectorProperty,
    PointerProperty,
    StringProperty,
)


class SPECTRAL_PROBE_PG_curve_point(bpy.types.PropertyGroup):
    """One wavelength of the spectrum shown."""

    wavelength_nm: FloatProperty(name="Wavelength", description="In nanometres")
    radiance: FloatProperty(name="Radiance", description="Spectral radiance per nm")
    lower: FloatProperty(name="Lower", description="Lower end of the 95 % band")
    upper: FloatProperty(name="Upper", description="Upper end of the 95 % band")


class SPECTRAL_PROBE_PG_panorama(bpy.types.PropertyGroup):
    """The spectrum of the direction last pointed at, and the polygon being drawn."""

    has_spectrum: BoolProperty(name="Shown", description="A direction was pointed at")
    following: BoolProperty(name="Following", description="The spectrum is shown beside the mouse")
    cursor_px: IntVectorProperty(
        name="Mouse", description="Where the mouse is in the window, in pixels", size=2
    )
    azimuth: FloatProperty(
        name="Bearing", description="Compass bearing of the direction pointed at", subtype="ANGLE"
    )
    elevation: FloatProperty(
        name="Elevation",
        description="Elevation of the direction pointed at",
        subtype="ANGLE",
        min=-math.pi / 2,
        max=math.pi / 2,
    )
    problem: StringProperty(name="Problem", description="Why there is no spectrum; empty where there is one")
    confidence: FloatProperty(name="Confidence", description="Confidence in the spectrum, 0 to 1")
    kinds: StringProperty(
        name="Kinds of Light",
        description="The likeliest kinds of light, each with its probability, one a line",
    )
    points: CollectionProperty(type=SPECTRAL_PROBE_PG_curve_point, name="Spectrum")
    polygon_of: StringProperty(name="Polygon", description="What the polygon being drawn or changed is for")
    is_open: BoolProperty(name="Open", description="The polygon being drawn is not closed yet")
    corner: IntProperty(
        name="Corner", description="Corner under the mouse; -1 where there is none", default=-1
    )


_register_classes, _unregister_classes = bpy.utils.register_classes_factory(
    (SPECTRAL_PROBE_PG_curve_point, SPECTRAL_PROBE_PG_panorama)
)


def register() -> None:
    """Attach it to the window manager."""
    _register_classes()
    bpy.types.WindowManager.spectral_probe_panorama = PointerProperty(
        type=SPECTRAL_PROBE_PG_panorama, options={"SKIP_SAVE"}
    )


def unregister() -> None:
    """Detach it."""
    del bpy.types.WindowManager.spectral_probe_panorama
    _unregister_classes()

"""The direction whose spectrum is shown, on `Scene.spectral_probe.spectrum`, and what it gave."""

import math
from typing import Any

import bpy
from bpy.props import BoolProperty, FloatProperty, StringProperty


def bearing() -> Any:
    """The field of a direction's compass bearing."""
    return FloatProperty(
        name="Bearing",
        description="Compass bearing of the direction: 0 along +Y, clockwise seen from above, 90 along +X",
        subtype="ANGLE",
        precision=2,
    )


def height() -> Any:
    """The field of a direction's elevation, its height above the horizon."""
    return FloatProperty(
        name="Elevation",
        description="Elevation of the direction above the horizon",
        subtype="ANGLE",
        precision=2,
        min=-math.pi / 2,
        max=math.pi / 2,
    )


class SPECTRAL_PROBE_PG_spectrum(bpy.types.PropertyGroup):
    """A direction of the probe, a measured spectrum to compare with, and the numbers last computed."""

    azimuth: bearing()
    elevation: height()
    radius: FloatProperty(
        name="Radius",
        description="Radius of the disc about the direction that the spectrum is averaged over",
        subtype="ANGLE",
        precision=2,
        default=math.radians(0.5),
        min=math.radians(0.01),
        max=math.pi / 2,
    )
    measured: StringProperty(
        name="Measured",
        description="File with a measured spectrum to compare with, such as CSV with the columns wavelength_nm,radiance",
        subtype="FILE_PATH",
        options={"PATH_SUPPORTS_BLEND_RELATIVE"},
    )
    has_numbers: BoolProperty(name="Shown", description="A spectrum was computed")
    has_comparison: BoolProperty(name="Compared", description="It was compared with a measured spectrum")
    confidence: FloatProperty(
        name="Confidence", description="Confidence in the spectrum, 0 to 1", precision=3
    )
    cct_kelvin: FloatProperty(
        name="CCT",
        description="Correlated colour temperature; 0 where none is defined",
        unit="COLOR_TEMPERATURE",
        precision=0,
    )
    duv: FloatProperty(name="Duv", description="Distance from the Planckian locus", precision=4)
    ra: FloatProperty(name="Ra", description="CIE general colour rendering index", precision=0)
    rf: FloatProperty(name="Rf", description="Fidelity index of ANSI/IES TM-30-18", precision=0)
    gfc: FloatProperty(
        name="GFC", description="Goodness-of-fit coefficient against the measured spectrum", precision=4
    )
    relative_rmse: FloatProperty(
        name="Relative RMSE",
        description="Root-mean-square difference from the measured spectrum, relative to it",
        subtype="FACTOR",
        precision=3,
    )
    de2000_light: FloatProperty(
        name="ΔE", description="Colour difference CIEDE2000 of the two lights at one luminance", precision=2
    )

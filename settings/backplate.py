"""The photograph behind a scene: `Scene.spectral_probe.backplate`."""

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    StringProperty,
)

from .known_light import file_path


class SPECTRAL_PROBE_PG_backplate(bpy.types.PropertyGroup):
    """Which photograph is the background, how it is matched to the probe, and the ground in it."""

    plate: file_path(
        "Plate",
        "Photograph to put objects into: of the same camera and lens as those of the ball, from the same place",
    )
    view: IntProperty(
        name="View", description="View of the probe that was taken from the plate's place", default=1, min=1
    )
    on_ground: BoolProperty(
        name="Ball on Ground",
        description="The ball stood on the ground. Off: it stood on something, and the ground lies lower",
        default=True,
    )
    ground_below: FloatProperty(
        name="Ground Below",
        description="How far the ground lies below the ball's centre",
        default=0.05,
        min=0.0,
        unit="LENGTH",
        precision=3,
    )
    reduce: BoolProperty(
        name="Reduce", description="Render at a smaller width than the photograph's", default=False
    )
    width_px: IntProperty(
        name="Width", description="Width to render at, in pixels", default=1500, min=16, subtype="PIXEL"
    )
    align: BoolProperty(
        name="Align",
        description="Correct what the camera turned between the photographs of the ball and the plate",
        default=True,
    )
    srgb: BoolProperty(
        name="Plain sRGB",
        description="Take a JPEG as plain sRGB, in place of the response curve measured from the photographs of the ball",
    )
    exposure_s: FloatProperty(
        name="Exposure",
        description="Exposure time of the plate. 0: as the photograph says",
        min=0.0,
        unit="TIME_ABSOLUTE",
        precision=5,
    )
    iso: FloatProperty(
        name="ISO", description="ISO speed of the plate, where its exposure is given", default=100.0, min=1.0
    )
    f_number: FloatProperty(
        name="F-Number",
        description="Aperture of the plate, where its exposure is given",
        default=1.0,
        min=0.1,
        precision=1,
    )
    ground_source: EnumProperty(
        name="Ground",
        description="What the ground reflects",
        items=(
            ("PLATE", "From Plate", "What makes the ground look as in the plate under the probe's light"),
            ("GIVEN", "Given", "One colour"),
        ),
    )
    reflectance: FloatVectorProperty(
        name="Reflectance",
        description="Reflectance of the ground",
        subtype="COLOR",
        size=3,
        min=0.0,
        max=1.0,
        default=(0.3, 0.3, 0.3),
    )
    ground_radius: FloatProperty(
        name="Radius",
        description="Radius of the ground that takes shadows and shows in metals. 0: ten times the ball's",
        min=0.0,
        unit="LENGTH",
        precision=2,
    )

    matched: StringProperty(name="Matched", description="The matched photograph, in JSON", options={"HIDDEN"})
    shift_px: FloatVectorProperty(
        name="Shift",
        description="How far the picture moved at the ball's place between the photograph of the ball and the plate, in pixels",
        size=2,
        precision=2,
    )
    aligned: BoolProperty(name="Aligned", description="The plate was aligned to the photographs of the ball")
    error_px: FloatProperty(
        name="Error",
        description="Standard error of the alignment at the ball's place, in pixels",
        precision=2,
    )
    gain: FloatVectorProperty(
        name="Gain",
        description="How many times brighter the plate is than the photographs of the ball, apart from exposure. 0: not measured",
        size=3,
        precision=3,
    )
    ground_mean: FloatVectorProperty(
        name="Mean Reflectance",
        description="Mean reflectance of the ground round the ball's place",
        size=3,
        precision=3,
    )
    remarks: StringProperty(name="Remarks", description="What matching remarked, a sentence a line")

"""What was photographed, and with what: photographs, views, the camera."""

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

from . import outline
from .known_light import file_path as _file
from .known_light import filter_file
from .library_pickers import camera_names


class SPECTRAL_PROBE_PG_photo(bpy.types.PropertyGroup):
    """One photograph of a bracket."""

    path: _file("Photograph", "Camera raw (DNG, ARW, NEF, ...), 16-bit TIFF or PNG, EXR, HDR, or JPEG")
    exposure_s: FloatProperty(
        name="Exposure",
        description="Exposure time. 0: read it from the photograph's EXIF",
        min=0.0,
        unit="TIME_ABSOLUTE",
        precision=5,
    )
    iso: FloatProperty(
        name="ISO", description="ISO speed. 0: read it from the photograph's EXIF", min=0.0, precision=0
    )
    f_number: FloatProperty(
        name="F-Number", description="Aperture. 0: read it from the photograph's EXIF", min=0.0, precision=1
    )
    shift_px: FloatVectorProperty(
        name="Shift",
        description="Where the ball lies from where it is in the first photograph of the view, in pixels",
        size=2,
        precision=2,
    )


class SPECTRAL_PROBE_PG_view(bpy.types.PropertyGroup):
    """One viewpoint: where the camera stood, the bracket it took, and what was found in it."""

    photos: CollectionProperty(type=SPECTRAL_PROBE_PG_photo, name="Photographs")
    active_photo: IntProperty(name="Active Photograph", min=0)
    azimuth: FloatProperty(
        name="Bearing",
        description="Compass bearing of the view: 0 along +Y, clockwise seen from above, 90 along +X",
        subtype="ANGLE",
    )
    elevation: FloatProperty(
        name="Elevation", description="Above 0 the camera was above the ball, looking down", subtype="ANGLE"
    )
    roll: FloatProperty(
        name="Roll",
        description="How far the camera was turned clockwise about its viewing direction",
        subtype="ANGLE",
    )
    refine: BoolProperty(
        name="Refine",
        description="Correct the angles so that what this view and the others saw falls on each other",
        default=True,
    )
    solve_exposures: BoolProperty(
        name="Correct Exposures",
        description="Where the exposures stated contradict the pixels, take what the pixels say",
        default=True,
    )
    filter: filter_file()
    outline_source: EnumProperty(
        name="Outline",
        description="Where the ball's outline in the photographs comes from",
        items=(
            ("AUTOMATIC", "Automatic", "Find the ball in the photographs", "NONE", 0),
            ("SNAP", "Near", "Find the ball's rim near the circle below", "NONE", 2),
            (
                "GIVEN",
                "Given",
                "Use the circle or ellipse below, in pixels of the first photograph",
                "NONE",
                1,
            ),
        ),
    )
    outline_px: FloatVectorProperty(
        name="Circle",
        description="Centre x, centre y (down from the top left corner) and radius of the ball, in pixels",
        size=3,
        min=0.0,
        precision=1,
    )
    outline_minor_px: FloatProperty(
        name="Second Axis",
        description="Second semi-axis of an ellipse, in pixels; the radius is then its first. 0: a circle",
        min=0.0,
        precision=1,
    )
    outline_angle: FloatProperty(
        name="Angle",
        description="Direction of the first semi-axis, clockwise from the horizontal",
        subtype="ANGLE",
    )
    has_ball_at: BoolProperty(
        name="Choose Ball", description="Where more than one ball is in the picture: take the one at a point"
    )
    ball_at_px: FloatVectorProperty(
        name="Ball At",
        description="A point on the ball: x and y (down from the top left corner) in pixels of the first photograph",
        size=2,
        min=0.0,
        precision=0,
    )
    has_outline: BoolProperty(name="Outline Found", description="The ball was found in this view")
    found_centre_px: FloatVectorProperty(
        name="Centre", description="Centre of the outline found, in pixels", size=2, precision=2
    )
    found_semi_axes_px: FloatVectorProperty(
        name="Semi-Axes", description="Semi-axes of the ellipse found, in pixels", size=2, precision=2
    )
    found_angle: FloatProperty(name="Angle", description="Direction of the major axis", subtype="ANGLE")
    found_rms_px: FloatProperty(
        name="RMS", description="How far the edge points lie from the ellipse, in pixels", precision=3
    )
    shown: PointerProperty(type=outline.SPECTRAL_PROBE_PG_shown_view)
    has_probe: BoolProperty(name="In Probe", description="This view is part of the probe last built")
    probe_azimuth: FloatProperty(
        name="Refined Bearing", description="Bearing that the probe was built with", subtype="ANGLE"
    )
    probe_rms_px: FloatProperty(name="Outline RMS", description="RMS of the outline, in pixels", precision=3)
    clipped_fraction: FloatProperty(
        name="Clipped",
        description="Share of the ball overexposed in every photograph; add shorter exposures if it is large",
        subtype="FACTOR",
        min=0.0,
        max=1.0,
    )


class SPECTRAL_PROBE_PG_camera(bpy.types.PropertyGroup):
    """The camera: how it sees colours, and its lens."""

    model: StringProperty(
        name="Camera",
        description="Camera whose spectral sensitivities are used: one that is known, or of your library folder. "
        "Empty: Rec.709, for JPEG, HDR and EXR",
        search=camera_names,
        search_options={"SUGGESTION"},
    )
    sensitivities: _file(
        "Sensitivities",
        "Spectral sensitivities in place of a camera's name: CSV (wavelength_nm,r,g,b) or AMPAS JSON",
    )
    half_size: BoolProperty(
        name="Half Size",
        description="Develop camera raw at half its size, without interpolation: faster. Lengths in pixels are then of that size",
    )
    focal_source: EnumProperty(
        name="Focal Length",
        description="Where the focal length comes from",
        items=(
            ("EXIF", "From Photographs", "From the EXIF data of the photographs"),
            ("MM", "Millimetres", "Focal length and width of the sensor"),
            ("PX", "Pixels", "Focal length in pixels"),
            ("CALIBRATION", "Calibration", "From a calibration file"),
        ),
    )
    focal_px: FloatVectorProperty(
        name="Focal Length", description="Focal lengths in x and y, in pixels", size=2, min=0.0, precision=1
    )
    focal_mm: FloatProperty(
        name="Focal Length", description="Focal length of the lens", default=50.0, min=0.1, unit="CAMERA"
    )
    sensor_width_mm: FloatProperty(
        name="Sensor Width",
        description="Width of the camera's sensor. 0: not known",
        min=0.0,
        unit="CAMERA",
    )
    calibration: _file(
        "Calibration", "Camera calibration (JSON) with focal length, principal point and distortion"
    )
    has_principal: BoolProperty(
        name="Principal Point",
        description="Give the principal point; without it the centre of the image is taken",
    )
    principal_px: FloatVectorProperty(
        name="Principal Point",
        description="Where the optical axis meets the image, in pixels",
        size=2,
        min=0.0,
        precision=1,
    )
    distortion: FloatVectorProperty(
        name="Distortion",
        description="Lens distortion in OpenCV's order: k1, k2, p1, p2, k3, k4, k5, k6",
        size=8,
        precision=5,
    )


CLASSES = (SPECTRAL_PROBE_PG_photo, SPECTRAL_PROBE_PG_view, SPECTRAL_PROBE_PG_camera)
"""In the order in which Blender has to know them, after those of `outline`."""

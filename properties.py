"""Settings and results, saved in the .blend: `Scene.spectral_probe` and `Material.spectral_probe`.

Angles are radians and lengths scene units inside, as everywhere in Blender; `operators/settings.py`
converts them from and to the capture file. Paths may be relative to the .blend ("//").
"""

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

from . import (
    compare_properties,
    job_report_properties,
    outline_properties,
    packed_properties,
    panorama_properties,
    region_properties,
    swap_properties,
    swatch_properties,
)
from .backplate_properties import SPECTRAL_PROBE_PG_backplate
from .capture_properties import FAMILIES, GROUPS, SPECTRAL_PROBE_PG_known_light, filter_file
from .capture_properties import file_path as _file
from .composite_properties import SPECTRAL_PROBE_PG_composite
from .library_pickers import ball_materials, camera_names
from .material_properties import SPECTRAL_PROBE_PG_light, SPECTRAL_PROBE_PG_material
from .output_properties import SPECTRAL_PROBE_PG_output
from .result_properties import (
    SPECTRAL_PROBE_PG_comparison,
    SPECTRAL_PROBE_PG_probe,
    SPECTRAL_PROBE_PG_progress,
    SPECTRAL_PROBE_PG_render,
    folder_path,
)
from .spectrum_properties import SPECTRAL_PROBE_PG_spectrum


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
    shown: PointerProperty(type=outline_properties.SPECTRAL_PROBE_PG_shown_view)
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


class SPECTRAL_PROBE_PG_scene(bpy.types.PropertyGroup):
    """Everything a scene knows about its probe, in the order of the pipeline."""

    version: IntProperty(
        name="Version",
        description="Version of these settings, by which later ones know what to make of them",
        options={"HIDDEN"},
    )
    capture_path: _file("Capture", "Capture file (TOML) that these settings were read from or saved to")
    camera: PointerProperty(type=SPECTRAL_PROBE_PG_camera)
    ball_radius: FloatProperty(
        name="Radius", description="Radius of the ball", default=0.05, min=1e-4, unit="LENGTH", precision=4
    )
    ball_material: StringProperty(
        name="Material",
        description="What the ball is made of: SUS304, stainless steel, chrome, silver, aluminium, ideal; fractions of metals "
        "such as Fe 0.74, Cr 0.18, Ni 0.08; a page of refractiveindex.info; or a file with its measured reflectance (CSV)",
        default="SUS304",
        search=ball_materials,
        search_options={"SUGGESTION"},
    )
    families: EnumProperty(
        name="Lamps",
        description="Lamp families that may be present. Name only those: the fewer, the surer the spectra",
        items=FAMILIES,
        options={"ENUM_FLAG"},
        default={"incandescent", "daylight"},
    )
    families_automatic: BoolProperty(
        name="Any Lamps", description="Any lamp family may be present; let the photographs decide"
    )
    method: EnumProperty(
        name="Method",
        description="How spectra are recovered from the camera's three channels",
        items=(
            (
                "family",
                "Lamp Family",
                "Non-negative, for the lamps that may be present, seen directly or off surfaces",
            ),
            ("automatic", "Automatic", "The same for all kinds of lamps: less sure of each"),
            (
                "paper",
                "Paper",
                "Three principal components of the lamps, inverted directly (Tominaga and Tanaka)",
            ),
        ),
    )
    known_light: PointerProperty(type=SPECTRAL_PROBE_PG_known_light)
    views: CollectionProperty(type=SPECTRAL_PROBE_PG_view, name="Views")
    active_view: IntProperty(name="Active View", min=0)
    all_views: BoolProperty(
        name="All Views",
        description="Look for the ball in every view, not only in the active one",
        default=True,
    )

    overlay: PointerProperty(type=outline_properties.SPECTRAL_PROBE_PG_overlay)

    composition: EnumProperty(
        name="Composition",
        description="How several views become one panorama",
        items=(
            ("blend", "Blend", "Every direction from the views that sample it best, blended without seams"),
            (
                "cut",
                "Cut",
                "The paper's plain cut: each view to 60 degrees on both sides of the direction to its camera",
            ),
        ),
    )
    probe_width: IntProperty(
        name="Width",
        description="Width of the panorama; its height is half of it. 0: as fine as the photographs",
        default=0,
        min=0,
        soft_max=4096,
        max=16384,
        step=64,
        subtype="PIXEL",
    )
    probe_directory: folder_path(
        "Folder", "Where the files of the probe are written", "//spectral_probe/probe/"
    )
    probe: PointerProperty(type=SPECTRAL_PROBE_PG_probe)
    packed: PointerProperty(type=packed_properties.SPECTRAL_PROBE_PG_packed)
    spectrum: PointerProperty(type=SPECTRAL_PROBE_PG_spectrum)
    region: PointerProperty(type=region_properties.SPECTRAL_PROBE_PG_region)
    edits: PointerProperty(type=region_properties.SPECTRAL_PROBE_PG_edits)
    swap: PointerProperty(type=swap_properties.SPECTRAL_PROBE_PG_swap)
    planned: PointerProperty(type=swap_properties.SPECTRAL_PROBE_PG_plan)

    light: EnumProperty(
        name="Light",
        description="What lights the spectral render, besides lamps",
        items=(
            ("PROBE", "Probe", "The panorama of the probe: its spectra were recovered from photographs"),
            (
                "WORLD",
                "Own World",
                "The scene's own world: its colours are taken as light of these colours, those of a Sky Texture as daylight",
            ),
        ),
    )
    plan: EnumProperty(
        name="Passes",
        description="How the spectrum is sampled by Cycles passes",
        items=(
            (
                "AUTOMATIC",
                "As Few as Needed",
                "As few passes as keep the error bound, chosen for the light and the materials of this scene",
            ),
            (
                "NUMBER",
                "Number",
                "Passes of light layers: this many wavelengths for every set of layers, chosen for light and materials",
            ),
            ("REFERENCE", "Reference", "All 61 wavelengths from 400 to 700 nm, three a pass: 21 passes"),
        ),
    )
    passes: IntProperty(
        name="Wavelengths",
        description="Wavelengths of every set of light layers, a pass each: all materials are set to one wavelength in a pass",
        default=5,
        min=1,
        max=21,
    )
    max_de2000: FloatProperty(
        name="Error Bound",
        description="Colour error CIEDE2000 against all 61 wavelengths that the plan may predict for 99 of 100 pixels. Where the "
        "number of wavelengths is given, it decides how many sets of light layers there are",
        default=0.5,
        min=0.01,
        soft_max=5.0,
        precision=2,
    )
    samples: IntProperty(
        name="Samples",
        description="Samples per pixel of a full pass, in place of those of the render properties",
        default=128,
        min=1,
    )
    full_samples: BoolProperty(
        name="Full Samples",
        description="Give every pass all samples, instead of its part of them or a fraction that is compared with a full pass: "
        "less noise, and nearly as many times slower as there are passes",
    )
    rgb_twin: BoolProperty(
        name="Also RGB",
        description="Render the same scene in plain RGB too, for the comparison",
        default=True,
    )
    render_directory: folder_path("Folder", "Where the render is written", "//spectral_probe/render/")
    output: PointerProperty(type=SPECTRAL_PROBE_PG_output)
    render: PointerProperty(type=SPECTRAL_PROBE_PG_render)
    composite: PointerProperty(type=SPECTRAL_PROBE_PG_composite)
    comparison_blur_px: FloatProperty(
        name="Blur",
        description="Gaussian blur of both images before they are compared, in pixels: takes the noise out",
        min=0.0,
        soft_max=10.0,
        precision=1,
        subtype="PIXEL",
    )
    compare: PointerProperty(type=compare_properties.SPECTRAL_PROBE_PG_compare)
    comparison: PointerProperty(type=SPECTRAL_PROBE_PG_comparison)
    backplate: PointerProperty(type=SPECTRAL_PROBE_PG_backplate)
    swatches: PointerProperty(type=swatch_properties.SPECTRAL_PROBE_PG_swatch_light)


_register_classes, _unregister_classes = bpy.utils.register_classes_factory(
    (
        *GROUPS,
        *outline_properties.CLASSES,
        SPECTRAL_PROBE_PG_photo,
        SPECTRAL_PROBE_PG_view,
        SPECTRAL_PROBE_PG_camera,
        SPECTRAL_PROBE_PG_probe,
        *packed_properties.CLASSES,
        SPECTRAL_PROBE_PG_output,
        SPECTRAL_PROBE_PG_render,
        SPECTRAL_PROBE_PG_composite,
        SPECTRAL_PROBE_PG_comparison,
        SPECTRAL_PROBE_PG_spectrum,
        *region_properties.CLASSES,
        *swap_properties.CLASSES,
        SPECTRAL_PROBE_PG_backplate,
        *compare_properties.CLASSES,
        *swatch_properties.CLASSES,
        SPECTRAL_PROBE_PG_scene,
        SPECTRAL_PROBE_PG_material,
        SPECTRAL_PROBE_PG_light,
        SPECTRAL_PROBE_PG_progress,
        *job_report_properties.CLASSES,
    )
)


def register() -> None:
    """Attach the settings to scenes and materials."""
    _register_classes()
    bpy.types.Scene.spectral_probe = PointerProperty(type=SPECTRAL_PROBE_PG_scene, name="Spectral Probe")
    bpy.types.Material.spectral_probe = PointerProperty(
        type=SPECTRAL_PROBE_PG_material, name="Spectral Probe"
    )
    bpy.types.Light.spectral_probe = PointerProperty(type=SPECTRAL_PROBE_PG_light, name="Spectral Probe")
    bpy.types.WindowManager.spectral_probe = PointerProperty(
        type=SPECTRAL_PROBE_PG_progress, options={"SKIP_SAVE"}
    )
    job_report_properties.attach()
    swatch_properties.register()
    panorama_properties.register()


def unregister() -> None:
    """Detach them."""
    panorama_properties.unregister()
    swatch_properties.unregister()
    job_report_properties.detach()
    del bpy.types.WindowManager.spectral_probe
    del bpy.types.Light.spectral_probe
    del bpy.types.Material.spectral_probe
    del bpy.types.Scene.spectral_probe
    _unregister_classes()

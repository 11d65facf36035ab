"""How a render is put into its photograph, and what came of it: `Scene.spectral_probe.composite`."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, StringProperty

from .known_light import file_path


class SPECTRAL_PROBE_PG_composite(bpy.types.PropertyGroup):
    """What is behind the render, what the photograph's file does not say, and numbers of the last composite."""

    background: EnumProperty(
        name="Background",
        description="What the objects are put into",
        items=(
            (
                "PHOTO",
                "Photograph",
                "A photograph of the render's size, or the one that the scene's backplate was made from",
            ),
            ("PROBE", "Panorama", "The light of the probe, as the render's camera sees it"),
        ),
    )
    plate: file_path("Photograph", "Photograph to put the objects into. Empty: that of the scene's backplate")
    srgb: BoolProperty(
        name="Plain sRGB",
        description="Take a JPEG as plain sRGB. Off: by the response curve of the backplate, which a JPEG without one needs",
    )
    camera: StringProperty(
        name="Camera",
        description="Camera that took a raw photograph: a name of the library, or a file of its sensitivities "
        "(CSV: nm, r, g, b). Empty: that of the backplate",
    )
    exposure_s: FloatProperty(
        name="Exposure",
        description="Exposure time of the photograph. 0: as the backplate or the file says",
        min=0.0,
        precision=5,
        unit="TIME_ABSOLUTE",
    )
    denoised: BoolProperty(
        name="Denoised Objects",
        description="Take the objects without their noise, where the render was denoised",
        default=True,
    )
    show: EnumProperty(
        name="Show",
        description="Which picture the Image Editor shows",
        items=(
            ("composite", "Composite", "The photograph with the spectral render"),
            ("composite_rgb", "RGB Composite", "The photograph with the ordinary RGB render"),
            ("difference", "Difference", "What the objects change on the ground, grey where nothing"),
        ),
    )
    directory: StringProperty(
        name="Folder",
        description="Folder of the last composite",
        subtype="DIR_PATH",
        options={"PATH_SUPPORTS_BLEND_RELATIVE"},
    )
    changed_fraction: FloatProperty(
        name="Changed", description="Share of the photograph's pixels that were changed", subtype="FACTOR"
    )
    remarks: StringProperty(name="Remarks", description="What is less than right, a line each")

"""What the stages gave, kept on `Scene.spectral_probe`, and the job that runs now."""

import bpy
from bpy.props import BoolProperty, FloatProperty, FloatVectorProperty, IntProperty, StringProperty


def folder_path(name: str, description: str, default: str = "") -> object:
    """Return a folder that may be relative to the .blend."""
    return StringProperty(
        name=name,
        description=description,
        default=default,
        subtype="DIR_PATH",
        options={"PATH_SUPPORTS_BLEND_RELATIVE"},
    )


class SPECTRAL_PROBE_PG_probe(bpy.types.PropertyGroup):
    """What building the probe gave."""

    directory: folder_path("Built In", "Folder with the files of the probe")
    width_px: IntProperty(name="Width", description="Width of the panorama", subtype="PIXEL")
    height_px: IntProperty(name="Height", description="Height of the panorama", subtype="PIXEL")
    blind_fraction: FloatProperty(
        name="Blind",
        description="Share of all directions that no view saw",
        subtype="FACTOR",
        min=0.0,
        max=1.0,
    )
    seconds: FloatProperty(name="Time", description="How long building took", unit="TIME_ABSOLUTE")
    warnings: StringProperty(
        name="Warnings", description="What building warned of, one sentence or two a line"
    )


class SPECTRAL_PROBE_PG_render(bpy.types.PropertyGroup):
    """What the spectral render gave."""

    directory: folder_path("Rendered To", "Folder with the files of the render")
    passes: IntProperty(name="Passes", description="Cycles passes rendered")
    samples: IntProperty(name="Samples", description="Samples of a full pass")
    predicted_de2000: FloatProperty(
        name="Predicted ΔE",
        description="Mean error the plan predicts against all 61 wavelengths",
        precision=2,
    )
    seconds: FloatProperty(
        name="Spectral", description="How long the spectral render took", unit="TIME_ABSOLUTE"
    )
    rgb_seconds: FloatProperty(name="RGB", description="How long the RGB render took", unit="TIME_ABSOLUTE")
    has_rgb: BoolProperty(name="RGB Twin", description="The same scene was rendered in plain RGB too")
    warnings: StringProperty(
        name="Warnings", description="What the render warned of, one sentence or two a line"
    )


class SPECTRAL_PROBE_PG_comparison(bpy.types.PropertyGroup):
    """How far the RGB render is from the spectral one."""

    directory: folder_path("Compared In", "Folder with the comparison")
    mean_de2000: FloatProperty(name="Mean ΔE", description="Mean colour difference CIEDE2000", precision=2)
    p95_de2000: FloatProperty(name="95 %", description="95 % of the pixels differ by less", precision=2)
    max_de2000: FloatProperty(
        name="Largest ΔE", description="Largest colour difference CIEDE2000", precision=2
    )
    xy_shift: FloatVectorProperty(
        name="xy Shift",
        description="Shift of the mean chromaticity from the spectral to the RGB render",
        size=2,
        precision=4,
    )
    warnings: StringProperty(name="Warnings", description="What the comparison left out, a sentence a line")


class SPECTRAL_PROBE_PG_progress(bpy.types.PropertyGroup):
    """The job that runs in the window now; not saved."""

    operator: StringProperty(name="Job", description="Operator whose job runs; empty when none does")
    fraction: FloatProperty(name="Progress", subtype="FACTOR", min=0.0, max=1.0)
    message: StringProperty(name="Step", description="What the job is doing")

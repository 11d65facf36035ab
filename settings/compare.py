"""What a comparison of the spectral with the RGB render shows, and its numbers by object."""

from typing import Any

import bpy
from bpy.props import CollectionProperty, EnumProperty, FloatProperty, FloatVectorProperty, StringProperty

from . import spectrum
from .library_pickers import lamp_names
from .region import table_file


def _wipe_again(settings: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    """Move the divider of the wipe that is shown."""
    from ..operators.show_comparison import wipe_again

    wipe_again(settings.id_data.spectral_probe)


class SPECTRAL_PROBE_PG_compared_object(bpy.types.PropertyGroup):
    """How far one object is in RGB from its spectral colours."""

    mean_de2000: FloatProperty(name="Mean ΔE", description="Mean colour difference CIEDE2000", precision=2)
    p95_de2000: FloatProperty(name="95 %", description="95 % of its pixels differ by less", precision=2)
    xy_shift: FloatVectorProperty(
        name="xy Shift",
        description="Shift of its mean chromaticity from the spectral to the RGB render",
        size=2,
        precision=4,
    )


class SPECTRAL_PROBE_PG_compare(bpy.types.PropertyGroup):
    """The light and the metals of the four ways of RGB, where the wipe is divided, and the objects' numbers."""

    light: EnumProperty(
        name="Light",
        description="Light in which metals are compared by four ways of RGB",
        items=(
            ("RENDER", "Render's", "Mean light of the render, or D65 where its folder does not tell"),
            ("LAMP", "Lamp", "A lamp of the library, or a file with a spectrum"),
            ("PROBE", "Probe's", "Mean light of the probe over all directions that were seen"),
            ("DIRECTION", "Direction", "Light of the probe from one direction"),
        ),
    )
    lamp: StringProperty(
        name="Lamp",
        description="A light of the library, Planck 3200 K or Daylight 6500 K",
        default="D65",
        search=lamp_names,
        search_options={"SUGGESTION"},
    )
    lamp_path: table_file("Spectrum", "CSV with wavelength_nm,power, in place of a lamp's name")
    azimuth: spectrum.bearing()
    elevation: spectrum.height()
    metals: StringProperty(
        name="Metals",
        description="Metals of the library, or pages of refractiveindex.info, parted by commas",
        default="gold, silver, copper",
    )
    split: FloatProperty(
        name="Wipe at",
        description="Where the wipe changes from the spectral to the RGB render, as a share of the width; moving it moves the "
        "divider of the wipe that is shown",
        default=0.5,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=_wipe_again,
    )
    objects: CollectionProperty(type=SPECTRAL_PROBE_PG_compared_object, name="Objects")


CLASSES: tuple[type[Any], ...] = (SPECTRAL_PROBE_PG_compared_object, SPECTRAL_PROBE_PG_compare)
"""To be registered before the scene's settings."""

"""Show what a comparison drew: the sheet, the wipe, the map, the diagrams."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.props import EnumProperty

from .base import FINISHED, OperatorResult, ReportsErrors
from .pictures import NAME_PREFIX, show

VIEWS = {
    "SHEET": ("sheet", "Comparison"),
    "WIPE": ("wipe", "Wipe"),
    "MAP": ("delta_e", "Colour Difference"),
    "CHROMATICITY": ("chromaticity", "Chromaticity"),
    "WAYS": ("rgb_ways", "Four Ways of RGB"),
}
"""File and name in the image editor of each picture of a comparison."""


class SPECTRAL_PROBE_OT_show_comparison(ReportsErrors, bpy.types.Operator):
    """Show a picture of the comparison in the Image Editor"""

    bl_idname = "spectral_probe.show_comparison"
    bl_label = "Show Comparison"

    view: EnumProperty(
        name="Picture",
        description="Which picture",
        items=(
            ("SHEET", "Sheet", "Everything on one page"),
            ("WIPE", "Wipe", "The spectral render on the left, the RGB render on the right of a divider"),
            ("MAP", "Map", "Colour differences ΔE 2000, with their scale"),
            ("CHROMATICITY", "Objects", "How the objects shift on the xy diagram"),
            ("WAYS", "Four Ways", "Metals in one light, spectrally and by four ways of RGB"),
        ),
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a comparison."""
        directory = context.scene.spectral_probe.comparison.directory
        if directory and (Path(bpy.path.abspath(directory)) / "sheet.png").is_file():
            return True
        cls.poll_message_set("Compare the renders first")
        return False

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Load it and show it; a wipe is divided where the panel says."""
        settings = context.scene.spectral_probe
        if self.view == "WIPE":
            _write_wipe(settings)
        file, name = VIEWS[self.view]
        show(_folder(settings) / f"{file}.png", name)
        return FINISHED


def wipe_again(settings: bpy.types.PropertyGroup) -> None:
    """Divide the wipe that was shown anew; without one, or without its pictures, nothing."""
    from ..spectral_probe.errors import SpectralProbeError

    image = bpy.data.images.get(NAME_PREFIX + VIEWS["WIPE"][1])
    if image is None or not settings.comparison.directory:
        return
    try:
        _write_wipe(settings)
    except SpectralProbeError:  # the folder is gone: the divider stays where it was, and the button says why
        return
    image.reload()


def _write_wipe(settings: bpy.types.PropertyGroup) -> None:
    from ..spectral_probe.compare_command import write_wipe

    write_wipe(_folder(settings), settings.compare.split)


def _folder(settings: bpy.types.PropertyGroup) -> Path:
    return Path(bpy.path.abspath(settings.comparison.directory))

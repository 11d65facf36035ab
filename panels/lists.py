"""The list of views, and of the photographs in one."""

import math
from pathlib import PurePath

import bpy


class SPECTRAL_PROBE_UL_views(bpy.types.UIList):
    """One view a row: its name, its bearing, and whether its ball was found."""

    def draw_item(
        self,
        _context: bpy.types.Context,
        layout: bpy.types.UILayout,
        _data: bpy.types.AnyType,
        view: bpy.types.AnyType,
        _icon: int,
        _active_data: bpy.types.AnyType,
        _active_property: str,
    ) -> None:
        """Draw one row."""
        row = layout.row(align=True)
        row.prop(view, "name", text="", emboss=False, icon="CAMERA_DATA")
        details = row.row()
        details.alignment = "RIGHT"
        details.active = False
        details.label(text=f"{math.degrees(view.azimuth):.1f}°")
        row.label(text="", icon="CHECKMARK" if view.has_outline else "BLANK1")


class SPECTRAL_PROBE_UL_photos(bpy.types.UIList):
    """One photograph a row: its file and its exposure time."""

    def draw_item(
        self,
        _context: bpy.types.Context,
        layout: bpy.types.UILayout,
        _data: bpy.types.AnyType,
        photo: bpy.types.AnyType,
        _icon: int,
        _active_data: bpy.types.AnyType,
        _active_property: str,
    ) -> None:
        """Draw one row."""
        row = layout.row(align=True)
        row.label(text=PurePath(photo.path).name or "No file", icon="FILE_IMAGE" if photo.path else "ERROR")
        details = row.row()
        details.alignment = "RIGHT"
        details.active = False
        details.label(text=shutter(photo.exposure_s))


def shutter(exposure_s: float) -> str:
    """An exposure time as photographers write it.

    Examples
    --------
    >>> shutter(0.004), shutter(2.5), shutter(0.0)
    ('1/250 s', '2.5 s', 'EXIF')
    """
    if exposure_s <= 0:
        return "EXIF"
    return f"{exposure_s:.3g} s" if exposure_s >= 0.3 else f"1/{1 / exposure_s:.0f} s"

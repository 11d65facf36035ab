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


class SPECTRAL_PROBE_UL_own_lights(bpy.types.UIList):
    """One measured lamp a row: its file."""

    def draw_item(
        self,
        _context: bpy.types.Context,
        layout: bpy.types.UILayout,
        _data: bpy.types.AnyType,
        light: bpy.types.AnyType,
        _icon: int,
        _active_data: bpy.types.AnyType,
        _active_property: str,
    ) -> None:
        """Draw one row."""
        layout.label(text=PurePath(light.path).name or "No file", icon="LIGHT" if light.path else "ERROR")


class SPECTRAL_PROBE_UL_region_lights(bpy.types.UIList):
    """One region a row: its name, and what is known of its light."""

    def draw_item(
        self,
        _context: bpy.types.Context,
        layout: bpy.types.UILayout,
        _data: bpy.types.AnyType,
        region: bpy.types.AnyType,
        _icon: int,
        _active_data: bpy.types.AnyType,
        _active_property: str,
    ) -> None:
        """Draw one row."""
        row = layout.row(align=True)
        row.prop(region, "name", text="", emboss=False, icon="SELECT_SET")
        details = row.row()
        details.alignment = "RIGHT"
        details.active = False
        details.label(text="Measured" if region.light == "SPECTRUM" else "Families")


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

"""File > Import: the photographs of the ball."""

import bpy


def draw_import(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """One line of the menu."""
    menu.layout.operator(
        "spectral_probe.import_photographs", text="Mirrored Ball Photographs (raw, .tif, .exr, .jpg)"
    )


def register() -> None:
    """Add the line to the menu."""
    bpy.types.TOPBAR_MT_file_import.append(draw_import)


def unregister() -> None:
    """Take it away."""
    bpy.types.TOPBAR_MT_file_import.remove(draw_import)

"""Pictures shown in Blender's image editor."""

from __future__ import annotations

from pathlib import Path

import bpy

NAME_PREFIX = "Spectral Probe "


def show(context: bpy.types.Context, path: Path, name: str) -> bpy.types.Image:
    """Load a picture under a name of ours, in place of an earlier one, and show it.

    An open image editor is used if there is one, else a new window; in background the picture is only loaded.
    """
    image = _loaded(path, NAME_PREFIX + name)
    if bpy.app.background or context.window is None:
        return image
    editors = [
        area
        for window in context.window_manager.windows
        for area in window.screen.areas
        if area.type == "IMAGE_EDITOR"
    ]
    if not editors:
        bpy.ops.wm.window_new()
        editors = [context.window_manager.windows[-1].screen.areas[0]]
        editors[0].type = "IMAGE_EDITOR"
    editors[0].spaces.active.image = image
    return image


def _loaded(path: Path, name: str) -> bpy.types.Image:
    image = bpy.data.images.get(name)
    if image is None:
        image = bpy.data.images.load(str(path))
        image.name = name
    else:
        image.filepath = str(path)
        image.reload()
    return image

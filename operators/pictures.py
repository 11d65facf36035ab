"""Pictures shown in Blender's image editor."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import bpy

NAME_PREFIX = "Spectral Probe "
RENDER_NAME = "Spectral Render"


def show(path: Path, name: str) -> bpy.types.Image:
    """Load a picture under a name of ours, in place of an earlier one, and show it.

    An open image editor is used if there is one, else a new window; in background the picture is only loaded.
    """
    image = _loaded(path, NAME_PREFIX + name)
    _show_soon(image)
    return image


def show_render(path: Path) -> bpy.types.Image:
    """Load image.exr of a spectral render as the image "Spectral Render", in place of an earlier one, and show it.

    It keeps its floats, is taken to be in the file's working space, and is shown under the scene's view transform, as
    Blender's own Render Result is. It stays on disk: nothing is packed.
    """
    image = _loaded(path, RENDER_NAME)
    image.colorspace_settings.name = bpy.data.colorspace.working_space
    image.alpha_mode = "PREMUL"
    image.use_view_as_render = True
    _show_soon(image)
    return image


def show_image(image: bpy.types.Image, *, in_new_window: bool = True) -> None:
    """Show an image in an open image editor if there is one, else in a new window where asked for; nothing in background."""
    if in_new_window or _image_editor() is not None:
        _show_soon(image)


def _show_soon(image: bpy.types.Image) -> None:
    if not bpy.app.background:
        # Once, when the operator has ended: Blender does not expect a window to open within a modal operator.
        bpy.app.timers.register(partial(_shown, image.name), first_interval=0.0)


def _shown(name: str) -> None:
    editor = _image_editor()
    if editor is None:
        with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
            bpy.ops.wm.window_new()
        editor = bpy.context.window_manager.windows[-1].screen.areas[0]
        editor.type = "IMAGE_EDITOR"
    editor.spaces.active.image = bpy.data.images.get(name)
    bpy.app.timers.register(_fitted, first_interval=0.2)  # a new editor has no size before it was drawn


def _fitted() -> None:
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area == _image_editor():
                region = next(region for region in area.regions if region.type == "WINDOW")
                with bpy.context.temp_override(window=window, area=area, region=region):
                    bpy.ops.image.view_all(fit_view=True)


def _image_editor() -> bpy.types.Area | None:
    """The first image editor of all windows."""
    areas = [area for window in bpy.context.window_manager.windows for area in window.screen.areas]
    return next((area for area in areas if area.type == "IMAGE_EDITOR"), None)


def _loaded(path: Path, name: str) -> bpy.types.Image:
    image = bpy.data.images.get(name)
    if image is None:
        image = bpy.data.images.load(str(path))
        image.name = name
    else:
        image.filepath = str(path)
        image.reload()
    return image

"""Photographs as image datablocks: packed into the .blend, each kept by its view."""

from __future__ import annotations

from pathlib import Path

import bpy

from ...versions import stored_settings


def keep_picture(view: bpy.types.PropertyGroup, picture: Path, size_px: tuple[int, int], photo: int) -> None:
    """Make a picture file the image of a view, in place of an earlier one wherever that is shown.

    The image is packed: it survives saving and opening the file again, and the picture file may go.
    """
    shown = view.shown
    name = f"{view.name or 'View'} ({photo + 1})"
    before = shown.picture
    image = bpy.data.images.load(str(picture))
    image.pack()
    image.filepath = ""  # the temporary file is of no further use
    if before is not None and not _shown_elsewhere(view, before):
        before.user_remap(image)
        bpy.data.images.remove(before)
    image.name = name
    shown.picture, shown.size_px, shown.photo = image, size_px, photo


def _shown_elsewhere(view: bpy.types.PropertyGroup, picture: bpy.types.Image) -> bool:
    """Whether another view has the picture, too: that of a copied scene."""
    scenes = [scene for scene in bpy.data.scenes if stored_settings(scene) is not None]
    views = (other for scene in scenes for other in scene.spectral_probe.views)
    return any(other.shown.picture == picture for other in views if other != view)


def view_shown(scene: bpy.types.Scene, image: bpy.types.Image | None) -> int | None:
    """Which view of a scene an image shows, from 0; None where it is no photograph of ours."""
    if image is None:
        return None
    for number, view in enumerate(scene.spectral_probe.views):
        if view.shown.picture == image:
            return number
    return None


def shift_of(view: bpy.types.PropertyGroup) -> tuple[float, float]:
    """Where the ball lies in the photograph shown from where it is in the first one, in pixels (x, y)."""
    if view.shown.photo >= len(view.photos):
        return (0.0, 0.0)
    x_px, y_px = view.photos[view.shown.photo].shift_px
    return (x_px, y_px)

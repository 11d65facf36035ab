"""Textures whose files are gone: Cycles would render them pink."""

import bpy

from ...spectral_probe.errors import RenderError
from .fingerprint import image_files
from .restore import in_scene

_NAMED = 3


def check_textures(scene: bpy.types.Scene, *, own_world: bool = False) -> None:
    """Refuse a scene that uses images whose files are missing; those of its world only if that is the light.

    Raises
    ------
    RenderError
        That names them.
    """
    candidates = [image for image in bpy.data.images if _is_missing(image)]
    missing = [
        image
        for image in (in_scene(scene, candidates) if candidates else [])
        if own_world or not _only_in_world(scene, image)
    ]
    if missing:
        named = ", ".join(f'"{image.name}" ({image.filepath})' for image in missing[:_NAMED])
        more = f" and {len(missing) - _NAMED} more" if len(missing) > _NAMED else ""
        are = "is" if len(missing) == 1 else "are"
        raise RenderError(
            f"Texture {named}{more} {are} missing. Find the files (File > External Data > Find Missing Files), or "
            "remove the textures."
        )


def _is_missing(image: bpy.types.Image) -> bool:
    if image.source not in {"FILE", "SEQUENCE", "MOVIE", "TILED"} or image.packed_files or image.packed_file:
        return False
    if image.source == "SEQUENCE":
        return bool(image.filepath) and not any(path.parent.is_dir() for path in image_files(image))
    return any(not path.is_file() for path in image_files(image))


def _only_in_world(scene: bpy.types.Scene, image: bpy.types.Image) -> bool:
    """Whether only the world shows an image: the probe's light takes its place."""
    users = bpy.data.user_map(subset=[image])[image]
    return bool(users) and all(user == scene.world for user in users)

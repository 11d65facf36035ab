"""Whether a scene still holds what its first pass showed: in a window somebody may remove any of it between two passes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ...spectral_probe.errors import RenderError

_KINDS = ("materials", "lights", "worlds", "node_groups")


@dataclass(frozen=True)
class Contents:
    """What a scene shows, and what its shaders are made of, by Blender's numbers of a session."""

    camera: int
    world: int
    layers: tuple[str, ...]
    objects: frozenset[int]
    shading: frozenset[int]


def contents(scene: bpy.types.Scene) -> Contents:
    """The contents of a scene now."""
    return Contents(
        _number(scene.camera),
        _number(scene.world),
        tuple(layer.name for layer in scene.view_layers),
        frozenset(thing.session_uid for thing in scene.objects),
        frozenset(block.session_uid for kind in _KINDS for block in getattr(bpy.data, kind)),
    )


def check_same(scene: bpy.types.Scene, before: Contents) -> None:
    """Refuse to go on with a scene that has lost something: passes of different scenes make no image.

    Raises
    ------
    RenderError
        If an object, the camera, the world, a lamp or a material is another now, or gone.
    """
    now = contents(scene)
    if replace(now, shading=before.shading) != before or not before.shading <= now.shading:
        raise RenderError(
            rpt_(
                'Scene "{name}" was changed while it was rendered: an object, its camera, its world, a view layer or a '
                "material came or went. Render it again."
            ).format(name=scene.name)
        )


def _number(block: bpy.types.ID | None) -> int:
    return 0 if block is None else block.session_uid

"""Which pixels of a render show which object: one ray a pixel centre through the scene's own geometry."""

from collections.abc import Sequence
from typing import Any

import bpy
import numpy as np
from mathutils import Vector

type Mask = np.ndarray[Any, np.dtype[np.bool_]]


def object_masks(scene: bpy.types.Scene, objects: Sequence[bpy.types.Object]) -> dict[str, Mask]:
    """Masks (H, W) of objects as the scene's perspective camera sees them, by object name; row 0 is the image's top.

    What hides behind another object does not belong to its mask. Depth of field, motion and an object's edge pixels are
    not resolved.
    """
    height, width = _size(scene)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    camera = scene.camera
    top_right, _, bottom_left, top_left = (
        camera.matrix_world @ corner for corner in camera.data.view_frame(scene=scene)
    )
    origin = camera.matrix_world.translation
    names = {target.name for target in objects}
    masks = {name: np.zeros((height, width), bool) for name in sorted(names)}
    across, down = (top_right - top_left) / width, (bottom_left - top_left) / height
    for row in range(height):
        start: Vector = top_left + down * (row + 0.5) - origin
        for column in range(width):
            hit, _, _, _, found, _ = scene.ray_cast(depsgraph, origin, start + across * (column + 0.5))
            if hit and found.name in names:
                masks[found.name][row, column] = True
    return masks


def _size(scene: bpy.types.Scene) -> tuple[int, int]:
    render = scene.render
    share = render.resolution_percentage / 100
    return max(int(render.resolution_y * share), 1), max(int(render.resolution_x * share), 1)

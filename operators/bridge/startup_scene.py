"""What Blender's start-up scene holds, as long as nobody has touched it: a cube, a lamp and a camera."""

from __future__ import annotations

from collections.abc import Sequence

import bpy

_CUBE_CORNERS, _CUBE_HALF_M = 8, 1.0
_LAMP_M, _LAMP_WATTS = (4.0762, 1.0055, 5.9039), 1000.0
_CAMERA_M, _CAMERA_LENS_MM = (7.3589, -6.9258, 4.9583), 50.0
_TOLERANCE_M = 1e-3


def startup_cube_and_lamp(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """The cube and the lamp of the start-up scene that are as Blender put them there."""
    return [thing for thing in scene.objects if _is_cube(thing) or _is_lamp(thing)]


def startup_camera(scene: bpy.types.Scene) -> bpy.types.Object | None:
    """The scene's camera, where it is the start-up scene's and stands as Blender put it there."""
    camera = scene.camera
    if camera is None or camera.type != "CAMERA" or not _at(camera, _CAMERA_M):
        return None
    return camera if abs(camera.data.lens - _CAMERA_LENS_MM) < _TOLERANCE_M else None


def _is_cube(thing: bpy.types.Object) -> bool:
    if thing.type != "MESH" or thing.modifiers or not _at(thing, (0.0, 0.0, 0.0)):
        return False
    corners = thing.data.vertices
    return len(corners) == _CUBE_CORNERS and all(
        abs(abs(value) - _CUBE_HALF_M) < _TOLERANCE_M for corner in corners for value in corner.co
    )


def _is_lamp(thing: bpy.types.Object) -> bool:
    if thing.type != "LIGHT" or thing.data.type != "POINT" or not _at(thing, _LAMP_M):
        return False
    return abs(thing.data.energy - _LAMP_WATTS) < _TOLERANCE_M


def _at(thing: bpy.types.Object, place_m: Sequence[float]) -> bool:
    """Whether an object stands there, at its own size, and nothing moves it."""
    if thing.parent or thing.constraints or thing.animation_data:
        return False
    apart = max(abs(value - wanted) for value, wanted in zip(thing.location, place_m, strict=True))
    return apart < _TOLERANCE_M and all(abs(factor - 1.0) < _TOLERANCE_M for factor in thing.scale)

"""What the 3D viewport shows of what was made: the world's light, and the camera's picture."""

from __future__ import annotations

import bpy


def show_world(context: bpy.types.Context) -> None:
    """Have the largest 3D viewport of the window show objects in the scene's light, unless it is rendered already."""
    area = _largest_viewport(context)
    if area is None:
        return
    shading = area.spaces.active.shading
    if shading.type != "RENDERED":
        shading.type = "MATERIAL"
        shading.use_scene_world = shading.use_scene_lights = True


def look_through_camera(context: bpy.types.Context) -> None:
    """Have the largest 3D viewport of the window show what the scene's camera sees."""
    area = _largest_viewport(context)
    if area is not None and context.scene.camera is not None:
        area.spaces.active.region_3d.view_perspective = "CAMERA"


def _largest_viewport(context: bpy.types.Context) -> bpy.types.Area | None:
    """None in background, and where the window has none."""
    if bpy.app.background or context.window is None:
        return None
    areas = [area for area in context.window.screen.areas if area.type == "VIEW_3D"]
    return max(areas, key=lambda area: area.width * area.height, default=None)

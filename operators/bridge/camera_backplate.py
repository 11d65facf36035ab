"""The camera of a scene as a backplate without photograph, so that a composite knows in which direction each pixel looks."""

from pathlib import Path

import bpy
import numpy as np

from ...spectral_probe.composite_model import Backplate
from ...spectral_probe.model import Camera


def rendered_size(scene: bpy.types.Scene) -> tuple[int, int]:
    """Width and height of a scene's whole frame in pixels, in whole numbers as Blender reckons them."""
    render = scene.render
    percent = render.resolution_percentage
    return render.resolution_x * percent // 100, render.resolution_y * percent // 100


def camera_backplate(
    scene: bpy.types.Scene, size_px: tuple[int, int], *, cut: bool = False
) -> Backplate | None:
    """The scene's camera as the camera of a backplate without a photograph; None where it is no perspective one.

    Parameters
    ----------
    scene
        The scene, at the frame that was rendered.
    size_px
        Width and height of the render, which may be a part of the frame only.
    cut
        It is the part within the scene's render border, whatever its size.
    """
    render, camera = scene.render, scene.camera
    if camera.type != "CAMERA" or camera.data.type != "PERSP":
        return None
    corners = np.array(camera.data.view_frame(scene=scene))
    (left, bottom, _), (right, top, _) = corners.min(0), corners.max(0)
    depth = -corners[0, 2]
    width, height = rendered_size(scene)
    per_unit = width / (right - left), height / (top - bottom)
    principal = np.array([-left * per_unit[0], top * per_unit[1]])
    if cut or size_px != (width, height):  # to the border
        principal -= int(render.border_min_x * width), height - int(render.border_max_y * height)
    rotation = np.array(camera.matrix_world.to_quaternion().to_matrix()) @ np.diag([1.0, -1.0, -1.0])
    return Backplate(
        camera=Camera(
            (float(per_unit[0] * depth), float(per_unit[1] * depth)),
            (float(principal[0]), float(principal[1])),
            size_px,
            source="Blender",
        ),
        rotation=rotation,
        position_m=np.array(camera.matrix_world.translation) * scene.unit_settings.scale_length,
        photo=Path(),
        photo_size_px=size_px,
        frame_px=(0.0, 0.0, *size_px),
    )

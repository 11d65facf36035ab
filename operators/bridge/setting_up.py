"""A scene set up for a prepared plate: camera, picture, ground, and the settings that remember them."""

import math
from collections.abc import Sequence

import bpy

from ...spectral_probe.composite.ground import GroundReflectance
from ...spectral_probe.composite.prepare import PreparedPlate
from .backplate import add_ground, keep_backplate, match_camera, show_plate


def set_up(scene: bpy.types.Scene, prepared: PreparedPlate) -> bpy.types.Object:
    """Give a scene the plate's camera, its picture, and the ground; returns the ground.

    Blender's exposure is set so that the scene is as bright in the viewport as the photograph.
    """
    backplate = prepared.match.backplate
    scene.render.engine = "CYCLES"
    camera = match_camera(scene, backplate)
    show_plate(camera, prepared.picture, backplate)
    ground = lay_ground(scene, prepared.ground, prepared.ground_radius_m)
    level = backplate.exposure * float(backplate.gain[1])
    scene.view_settings.exposure = max(-32.0, min(32.0, math.log2(level)))
    keep_backplate(scene, backplate)
    keep_numbers(scene, prepared)
    return ground


def lay_ground(
    scene: bpy.types.Scene, reflectance: GroundReflectance | Sequence[float], radius_m: float
) -> bpy.types.Object:
    """Give a scene the ground of a plate, or one of a colour (3,), and keep its mean for the panel."""
    mean = reflectance.mean if isinstance(reflectance, GroundReflectance) else reflectance
    scene.spectral_probe.backplate.ground_mean = [float(value) for value in mean]
    return add_ground(scene, reflectance, radius_m)


def keep_numbers(scene: bpy.types.Scene, prepared: PreparedPlate) -> None:
    """Keep what matching measured, for the panel."""
    kept, match = scene.spectral_probe.backplate, prepared.match
    kept.plate = str(match.backplate.photo)
    kept.aligned = match.alignment is not None
    kept.shift_px = (0.0, 0.0) if match.alignment is None else match.alignment.shift_px
    kept.error_px = 0.0 if match.alignment is None else match.alignment.error_px
    kept.gain = (0.0, 0.0, 0.0) if match.gain is None else [float(value) for value in match.gain]
    kept.remarks = "\n".join(prepared.remarks)

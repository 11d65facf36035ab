"""The demo's metals stand in the sample's plate where the ball stood."""

import bpy
import numpy as np
import pytest


@pytest.mark.usefixtures("scene")
def test_the_silver_ball_is_as_high_as_the_mirrored_ball_was(extension, uniform_light):
    light = uniform_light(np.ones(61), height=64)
    backplate = extension("spectral_probe.sample_plate").gym_plate(light)
    made = extension("operators.demo_plate")._scene(backplate, light)
    bpy.context.view_layer.update()
    silver = bpy.data.objects["Silver Ball"]
    middle_m = np.mean([silver.matrix_world @ vertex.co for vertex in silver.data.vertices], axis=0)
    assert middle_m[2] == pytest.approx(backplate.ball_centre_m[2], abs=0.05)
    assert np.hypot(*middle_m[:2]) < 0.5
    (ground,) = (thing for thing in made.objects if thing.is_shadow_catcher)
    assert ground.location.z == bpy.data.objects["Copper Ball"].location.z == 0.0
    assert (made.render.resolution_x, made.render.resolution_y) == backplate.camera.size_px

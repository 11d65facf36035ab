"""The demo's metals stand on the floor of the sample's plate, before its camera."""

import bpy
import numpy as np
import pytest


@pytest.mark.usefixtures("scene")
def test_the_metals_stand_on_the_floor_and_in_the_picture(extension, uniform_light):
    light = uniform_light(np.ones(61), height=64)
    backplate = extension("spectral_probe.sample_plate").gym_plate(light)
    made = extension("operators.demo_plate")._scene(backplate, light)
    bpy.context.view_layer.update()
    (ground,) = (thing for thing in made.objects if thing.is_shadow_catcher)
    metals = [bpy.data.objects[name] for name in ("Gold Pedestal", "Silver Ball", "Copper Ball")]
    points_m = [np.array([thing.matrix_world @ v.co for v in thing.data.vertices]) for thing in metals]
    assert ground.location.z == 0.0
    assert points_m[0][:, 2].min() == points_m[2][:, 2].min() == pytest.approx(0.0, abs=1e-6)
    seen = (np.concatenate(points_m) - backplate.position_m) @ backplate.rotation
    places = seen[:, :2] / seen[:, 2:] * backplate.camera.focal_px + backplate.camera.principal_px
    assert (places > 10).all()
    assert (places < np.array(backplate.camera.size_px) - 10).all()
    assert np.ptp(places[:, 1]) > 0.33 * backplate.camera.size_px[1]  # large enough to be looked at
    # The ground that takes their shadows reaches as far beyond them as they are high.
    reach_m = np.hypot(*np.concatenate(points_m)[:, :2].T).max()
    assert reach_m + points_m[1][:, 2].max() < ground.dimensions.x / 2
    assert (made.render.resolution_x, made.render.resolution_y) == backplate.camera.size_px

"""A transparent film, with and without lamps: what is behind objects is in no image."""

import bpy
import numpy as np
import pytest


@pytest.mark.parametrize(("passes", "lamp"), [(3, False), (3, True), (None, True), ("all", True)])
def test_nothing_of_the_light_is_seen_through(
    scene, bridge, extension, ball, uniform_light, tmp_path, lamp, passes
):
    read = extension("spectral_probe.files.image_exr").read_channels
    scene.render.film_transparent, scene.cycles.use_denoising = True, False
    scene.render.resolution_x = scene.render.resolution_y = 32
    ball()
    if lamp:
        thing = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
        thing.location, thing.data.energy = (0.0, -3.0, 2.0), 30.0
        scene.collection.objects.link(thing)
    job = bridge.spectral_render(
        scene, uniform_light(np.full(61, 0.01)), None, tmp_path, samples=8, passes=passes
    )
    result = extension("spectral_probe.model").finish(job)
    xyz, rgb = read(result.xyz)[0], read(result.rgb)[0]
    outside = xyz["A"] == 0.0
    assert 0.1 < outside.mean() < 0.9
    assert not xyz["Y"][outside].any()
    assert not rgb["G"][outside].any()
    inside = xyz["A"] == 1.0
    to_rec709 = extension("spectral_probe.spectra.colorimetry").xyz_to_rec709
    seen = to_rec709(np.stack([xyz[name] for name in "XYZ"], -1))[inside].mean(0)
    wanted = np.stack([rgb[name] for name in "RGB"], -1)[inside].mean(0)
    np.testing.assert_allclose(seen, wanted, rtol=0.02)
    edge = (xyz["A"] > 0.0) & (xyz["A"] < 1.0)
    np.testing.assert_allclose(
        (xyz["Y"][edge] / xyz["A"][edge]).mean(), xyz["Y"][inside].mean(), rtol=0.3
    )  # premultiplied

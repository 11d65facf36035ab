"""A white furnace: in equal light from everywhere, what reflects everything cannot be seen, in any pass of either plan."""

import numpy as np
import pytest

TOLERANCE = 0.002


def perfect_mirror(tmp_path, material, distribution, roughness):
    """A metal of n = 0, which reflects everything at every angle."""
    table = tmp_path / "mirror.csv"
    table.write_text("wavelength_nm,n,k\n400,0,3\n700,0,4\n")
    node = material.node_tree.nodes["Shader"]
    node.distribution = distribution
    node.inputs["Roughness"].default_value = roughness
    material.spectral_probe.kind = "METAL"
    material.spectral_probe.metal = str(table)


@pytest.mark.parametrize("passes", [3, "all"])
@pytest.mark.parametrize("surface", ["white", "smooth metal", "rough metal"])
def test_white_furnace(scene, bridge, extension, uniform_light, ball, tmp_path, surface, passes):
    if surface == "white":
        material = ball("ShaderNodeBsdfDiffuse")
        material.node_tree.nodes["Shader"].inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    else:
        rough = surface == "rough metal"
        material = ball("ShaderNodeBsdfMetallic")
        perfect_mirror(tmp_path, material, "MULTI_GGX" if rough else "GGX", 0.5 if rough else 0.0)
    finish = extension("spectral_probe.model").finish
    read_rgb = extension("spectral_probe.files.image_exr").read_rgb
    read_pass = extension("spectral_probe.render.pass_folder").read_pass
    job = bridge.spectral_render(
        scene,
        uniform_light(np.full(61, 0.02)),
        None,
        tmp_path / "out",
        samples=32,
        passes=passes,
        rgb_twin=False,
    )
    result = finish(job)

    assert len(result.passes) == (21 if passes == "all" else 3)
    for path in result.passes:
        image = read_pass(path).groups["world"]
        light = image[0, 0]  # a corner looks past the ball
        inside = image[16:48, 16:48].reshape(-1, 3)
        assert light.min() > 0
        np.testing.assert_allclose(inside.mean(0) / light, 1.0, atol=TOLERANCE)
    xyz = read_rgb(result.xyz, ("X", "Y", "Z"))
    luminance = 0.02 * 106.8566  # the sum over nm of y-bar
    np.testing.assert_allclose(xyz[..., 1].mean(), luminance, rtol=TOLERANCE)

"""A white furnace: in equal light from everywhere, what reflects everything cannot be seen, in either plan.

What single-scattering facets lose of it is compared with an integral of their model.
"""

import math

import bpy
import numpy as np
import pytest

TOLERANCE = 0.002
SPECTRUM = np.full(61, 0.02)


@pytest.fixture
def furnace(scene, bridge, extension, uniform_light, three_wavelengths, tmp_path):
    """Render in equal light; XYZ over that of the light, which a corner of the picture shows."""

    scene.cycles.use_denoising = False

    def render(kind, samples=32):
        job = bridge.spectral_render(
            scene,
            uniform_light(SPECTRUM),
            three_wavelengths if kind == "wavelength" else None,
            tmp_path / "out",
            samples=samples,
            passes=3,
            rgb_twin=False,
        )
        result = extension("spectral_probe.model").finish(job)
        assert result.plan.kind == kind
        xyz = extension("spectral_probe.files.image_exr").read_rgb(result.xyz, ("X", "Y", "Z"))
        assert xyz[0, 0].min() > 0
        return xyz / xyz[0, 0]

    return render


def perfect_mirror(tmp_path, material, distribution, roughness):
    """A metal of n = 0, which reflects everything at every angle."""
    table = tmp_path / "mirror.csv"
    table.write_text("wavelength_nm,n,k\n400,0,3\n700,0,4\n")
    node = material.node_tree.nodes["Shader"]
    node.distribution = distribution
    node.inputs["Roughness"].default_value = roughness
    material.spectral_probe.kind = "METAL"
    material.spectral_probe.metal = str(table)


def white_colour(material):
    material.node_tree.nodes["Shader"].inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)


def white_texture(material):
    """A white picture, as 8-bit sRGB."""
    image = bpy.data.images.new("White", 4, 4)
    image.pixels.foreach_set(np.ones(64, np.float32))
    node = material.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    material.node_tree.links.new(node.outputs["Color"], material.node_tree.nodes["Shader"].inputs["Color"])


def white_vertices(material):
    """White vertex colours."""
    mesh = bpy.context.object.data
    colours = mesh.color_attributes.new("Painted", "FLOAT_COLOR", "POINT")
    colours.data.foreach_set("color", np.ones(4 * len(mesh.vertices), np.float32))
    node = material.node_tree.nodes.new("ShaderNodeVertexColor")
    node.layer_name = "Painted"
    material.node_tree.links.new(node.outputs["Color"], material.node_tree.nodes["Shader"].inputs["Color"])


WHITE = {"colour": white_colour, "texture": white_texture, "vertex colours": white_vertices}


@pytest.mark.parametrize("kind", ["light-basis", "wavelength"])
@pytest.mark.parametrize(
    "surface", ["colour", "texture", "vertex colours", "smooth metal", "MULTI_GGX metal", "rougher metal"]
)
def test_white_furnace(furnace, ball, tmp_path, surface, kind):
    if surface in WHITE:
        WHITE[surface](ball("ShaderNodeBsdfDiffuse"))
    else:
        smooth = surface == "smooth metal"
        roughness = 0.0 if smooth else 0.5 if surface == "MULTI_GGX metal" else 0.8
        distribution = "GGX" if smooth else "MULTI_GGX"
        perfect_mirror(tmp_path, ball("ShaderNodeBsdfMetallic"), distribution, roughness)
    inside = furnace(kind)[16:48, 16:48].reshape(-1, 3)
    np.testing.assert_allclose(inside.mean(0), 1.0, atol=TOLERANCE)


def test_the_light_itself_has_its_luminance(scene, bridge, extension, uniform_light, ball, tmp_path):
    """All 61 wavelengths of the furnace add up to the light's own tristimulus value."""
    white_colour(ball())
    scene.cycles.use_denoising = False
    scene.render.resolution_x = scene.render.resolution_y = 16
    light = uniform_light(SPECTRUM)
    job = bridge.spectral_render(
        scene, light, None, tmp_path / "out", samples=16, passes="all", rgb_twin=False
    )
    result = extension("spectral_probe.model").finish(job)
    xyz = extension("spectral_probe.files.image_exr").read_rgb(result.xyz, ("X", "Y", "Z"))
    np.testing.assert_allclose(
        xyz[..., 1].mean(), 0.02 * 106.8566, rtol=TOLERANCE
    )  # the sum over nm of y-bar


def ggx_albedo(cos_view, alpha, steps=(400, 200)):
    """Share of equal light that GGX facets of reflectance 1 send to a viewer in one reflection, by quadrature.

    Walter et al. (2007), doi:10.2312/EGWR/EGSR07/195-206, with Smith's shadowing correlated in height (Heitz 2014).
    """
    cosine = (np.arange(steps[0]) + 0.5) / steps[0]
    azimuth = (np.arange(steps[1]) + 0.5) / steps[1] * np.pi
    cos_light, azimuth = np.meshgrid(cosine, azimuth)
    sine, sin_view = np.sqrt(1 - cos_light**2), math.sqrt(1 - cos_view**2)
    cos_between = cos_light * cos_view + sine * sin_view * np.cos(azimuth)
    half = np.sqrt((1 + cos_between) / 2)
    cos_facet = (cos_light + cos_view) / (2 * half)
    distribution = alpha**2 / (np.pi * (cos_facet**2 * (alpha**2 - 1) + 1) ** 2)

    def smith(cosine):
        return (np.sqrt(1 + alpha**2 * (1 / cosine**2 - 1)) - 1) / 2

    shadowing = 1 / (1 + smith(cos_light) + smith(cos_view))
    return float((distribution * shadowing / (4 * cos_view)).mean() * 2 * np.pi)


def test_the_integral_of_facets_is_one_where_it_must_be():
    assert ggx_albedo(1.0, 0.02, steps=(100_000, 4)) == pytest.approx(1.0, abs=0.002)
    assert ggx_albedo(0.5, 1.0) < 0.8


@pytest.mark.parametrize("roughness", [0.5, 0.8])
def test_single_scattering_loses_what_its_model_says(scene, furnace, ball, tmp_path, roughness):
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 2.0
    scene.cycles.pixel_filter_type = "BOX"
    perfect_mirror(tmp_path, ball("ShaderNodeBsdfMetallic"), "GGX", roughness)
    rows, columns = (np.mgrid[:64, :64] + 0.5) / 32 - 1
    distance = np.hypot(rows, columns)
    image = furnace("wavelength", samples=64)
    for least, most in ((0.0, 0.4), (0.4, 0.7), (0.7, 0.9)):
        mask = (distance >= least) & (distance < most)
        expected = np.mean(
            [ggx_albedo(math.sqrt(1 - d * d), roughness**2) for d in np.unique(distance[mask])[::8]]
        )
        np.testing.assert_allclose(image[mask].mean(0), expected, atol=0.004)

"""Coloured and dispersive glass against Beer, Lambert and Snell."""

import bpy
import numpy as np
import pytest

NM = [440.0, 550.0, 650.0]
KINDS = ["light-basis", "wavelength"]
GRID = np.arange(400.0, 701.0, 5.0)
LIGHT = np.full(61, 0.01)


def centre(images):
    return images[:, 28:36, 28:36].mean((1, 2))


@pytest.fixture
def slab(scene):
    """A box of a thickness in front of the camera, of one shader."""

    def add(shader, thickness=0.5):
        half = thickness / 2
        corners = [(x, y, z) for x in (-9, 9) for y in (-half, half) for z in (-9, 9)]
        faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        mesh = bpy.data.meshes.new("Slab")
        mesh.from_pydata(corners, [], faces)
        scene.collection.objects.link(bpy.data.objects.new("Slab", mesh))
        material = bpy.data.materials.new("Slab")
        tree = material.node_tree
        tree.nodes.clear()
        node, output = tree.nodes.new(shader), tree.nodes.new("ShaderNodeOutputMaterial")
        node.name = "Shader"
        tree.links.new(node.outputs[0], output.inputs["Surface"])
        mesh.materials.append(material)
        return material

    return add


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("shader", ["ShaderNodeBsdfTransparent", "ShaderNodeBsdfRefraction"])
def test_a_body_absorbs_by_beer_and_lambert(radiance, slab, extension, kind, shader):
    settings = slab(shader, 0.5).spectral_probe
    bpy.data.materials["Slab"].node_tree.nodes["Shader"].inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    if shader == "ShaderNodeBsdfRefraction":
        node = bpy.data.materials["Slab"].node_tree.nodes["Shader"]
        node.inputs["Roughness"].default_value = 0.0
        node.inputs["IOR"].default_value = 1.0
    clear = centre(radiance(NM, kind, LIGHT)[0])  # not quite the light: rays graze the surfaces
    settings.kind, settings.glass, settings.glass_as = "GLASS", "cadmium-yellow", "BODY"
    settings.glass_thickness, settings.glass_with_surfaces = 0.25, False
    images, warnings = radiance(NM, kind, LIGHT)
    pane = extension("spectral_probe.spectra.glass").glass_transmittance("cadmium-yellow")
    expected = clear * np.interp(NM, GRID, np.maximum(pane, 1e-4) ** 2)
    np.testing.assert_allclose(centre(images), expected, rtol=0.002, atol=1e-7)
    assert not warnings


@pytest.mark.parametrize("kind", KINDS)
def test_a_thin_filter_takes_its_light_at_every_surface(radiance, slab, extension, kind):
    settings = slab("ShaderNodeBsdfTransparent").spectral_probe
    settings.kind, settings.glass = "GLASS", "copper-ruby"
    images, _ = radiance(NM, kind, LIGHT)
    pane = extension("spectral_probe.spectra.glass").glass_transmittance("copper-ruby")
    np.testing.assert_allclose(centre(images), 0.01 * np.interp(NM, GRID, pane**2), rtol=1e-3, atol=1e-7)


@pytest.mark.parametrize(
    "shader", ["ShaderNodeBsdfGlass", "ShaderNodeBsdfRefraction", "ShaderNodeBsdfPrincipled"]
)
def test_dispersive_glass_bends_each_wavelength_by_its_index(scene, radiance, slab, shader):
    """A tilted plate shifts an edge behind it by d sin(a) (1 - cos(a) / sqrt(n^2 - sin(a)^2))."""
    material = slab(shader, 1.0)
    material.spectral_probe.kind = "DISPERSIVE"
    material.spectral_probe.index_from, material.spectral_probe.cauchy = "CAUCHY", (1.2, 0.2, 0.0)
    node = material.node_tree.nodes["Shader"]
    node.inputs["Roughness"].default_value = 0.0
    if shader == "ShaderNodeBsdfPrincipled":
        node.inputs["Transmission Weight"].default_value = 1.0
    plate = bpy.data.objects["Slab"]
    plate.scale, plate.rotation_euler = (0.5, 1.0, 0.5), (0.0, 0.0, np.radians(45))
    mesh = bpy.data.meshes.new("Half")
    mesh.from_pydata([(-20, 9, -20), (0, 9, -20), (0, 9, 20), (-20, 9, 20)], [], [(0, 1, 2, 3)])
    scene.collection.objects.link(bpy.data.objects.new("Half", mesh))
    black = bpy.data.materials.new("Black")
    black.node_tree.nodes.clear()
    diffuse, output = (
        black.node_tree.nodes.new(f"ShaderNode{name}") for name in ("BsdfDiffuse", "OutputMaterial")
    )
    diffuse.inputs["Color"].default_value = (0.0, 0.0, 0.0, 1.0)
    black.node_tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
    mesh.materials.append(black)
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 2.0
    nm = [420.0, 550.0, 680.0]
    n = 1.2 + 0.2 / (np.array(nm) / 1000) ** 2
    sine = np.sin(np.radians(45))
    shift = 1.0 * sine * (1 - sine / np.sqrt(n**2 - sine**2))
    found = {}
    for kind in KINDS:
        images, warnings = radiance(nm, kind, LIGHT, samples=64)
        profile = images[:, 16:48].mean(1)
        bright = (profile > profile.max(1, keepdims=True) / 2).sum(1) / 64 * 2.0
        found[kind] = np.abs(1.0 - bright)
        np.testing.assert_allclose(found[kind], shift, atol=0.04)
        assert not warnings
    assert np.ptp(shift) > 0.1

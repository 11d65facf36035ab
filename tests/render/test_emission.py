"""Lamps and emitting materials against the spectra they must have, in passes of either kind."""

import bpy
import numpy as np
import pytest

NM = [400.0, 450.0, 500.0, 550.0, 600.0, 700.0]
KINDS = ["light-basis", "wavelength"]


def centre(images):
    return images[:, 28:36, 28:36].mean((1, 2))


@pytest.fixture
def spectra(extension):
    """Modules with the truth."""
    return {
        name: extension(f"spectral_probe.spectra.{name}")
        for name in ("emission", "library", "colorimetry", "uplift")
    }


@pytest.fixture
def at_nm():
    grid = np.arange(400.0, 701.0, 5.0)
    return lambda spectrum: np.interp(NM, grid, spectrum)


@pytest.fixture
def glowing(ball):
    """A ball that emits a colour at a strength."""

    def add(colour, strength=2.0, location=(0.0, 0.0, 0.0)):
        material = ball("ShaderNodeEmission", location)
        node = material.node_tree.nodes["Shader"]
        node.inputs["Color"].default_value = (*colour, 1.0)
        node.inputs["Strength"].default_value = strength
        return material

    return add


@pytest.fixture
def lamp(scene):
    """A sun that shines along the view, on a white wall behind the origin."""

    def add(name="Sun", kind="SUN", **settings):
        data = bpy.data.lights.new(name, kind)
        for key, value in settings.items():
            setattr(data, key, value)
        thing = bpy.data.objects.new(name, data)
        thing.location, thing.rotation_euler = (0.0, -4.0, 0.0), (np.pi / 2, 0.0, 0.0)
        scene.collection.objects.link(thing)
        return data

    return add


@pytest.fixture
def wall(scene):
    mesh = bpy.data.meshes.new("Wall")
    mesh.from_pydata([(-9, 1, -9), (9, 1, -9), (9, 1, 9), (-9, 1, 9)], [], [(0, 1, 2, 3)])
    scene.collection.objects.link(bpy.data.objects.new("Wall", mesh))
    material = bpy.data.materials.new("White")
    tree = material.node_tree
    tree.nodes.clear()
    node, output = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
    node.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    mesh.materials.append(material)
    return material


@pytest.mark.parametrize("kind", KINDS)
def test_a_coloured_emission_has_the_spectrum_of_its_colour(radiance, glowing, spectra, at_nm, kind):
    colour = np.array([0.9, 0.5, 0.1])
    glowing(colour, 3.0)
    images, warnings = radiance(NM, kind)
    np.testing.assert_allclose(
        centre(images), at_nm(3.0 * colour @ spectra["emission"].rgb_illuminants()), rtol=1e-4
    )
    assert not warnings


@pytest.mark.parametrize("kind", KINDS)
def test_a_sun_of_a_colour(radiance, lamp, wall, spectra, at_nm, kind):
    lamp(color=(0.2, 0.6, 1.0), energy=2.0)
    images, _ = radiance(NM, kind, samples=16)
    expected = 2.0 / np.pi * np.array([0.2, 0.6, 1.0]) @ spectra["emission"].rgb_illuminants()
    np.testing.assert_allclose(centre(images), at_nm(expected), rtol=0.01)

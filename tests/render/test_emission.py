"""Lamps and emitting materials against the spectra they must have, in passes of either kind."""

import bpy
import numpy as np
import pytest

NM = [440.0, 550.0, 650.0]
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


@pytest.mark.parametrize("by", ["collection", "vertices"])
def test_an_instanced_lamp_shines_in_its_group(scene, radiance, glowing, spectra, at_nm, by):
    colour = np.array([0.9, 0.5, 0.1])
    glowing(colour, 3.0)
    thing = bpy.context.object
    scene.collection.objects.unlink(thing)
    group = bpy.data.collections.new("Lamps")
    group.objects.link(thing)
    if by == "collection":
        instance = bpy.data.objects.new("Instance", None)
        instance.instance_type, instance.instance_collection = "COLLECTION", group
        scene.collection.objects.link(instance)
    else:
        mesh = bpy.data.meshes.new("Point")
        mesh.from_pydata([(0.0, 0.0, 0.0)], [], [])
        instance = bpy.data.objects.new("Instance", mesh)
        modifier = instance.modifiers.new("Places", "NODES")
        modifier.node_group = places(thing)
        scene.collection.objects.link(instance)
    images, _ = radiance(NM)
    expected = at_nm(3.0 * colour @ spectra["emission"].rgb_illuminants())
    np.testing.assert_allclose(centre(images), expected, rtol=1e-4)


def places(thing):
    """Geometry nodes that put an object on every point."""
    tree = bpy.data.node_groups.new("Places", "GeometryNodeTree")
    for side in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=side, socket_type="NodeSocketGeometry")
    source, target = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    put, info = tree.nodes.new("GeometryNodeInstanceOnPoints"), tree.nodes.new("GeometryNodeObjectInfo")
    info.inputs["Object"].default_value, info.inputs["As Instance"].default_value = thing, True
    tree.links.new(source.outputs[0], put.inputs["Points"])
    tree.links.new(info.outputs["Geometry"], put.inputs["Instance"])
    tree.links.new(put.outputs[0], target.inputs[0])
    return tree


@pytest.mark.usefixtures("wall")
@pytest.mark.parametrize("kind", KINDS)
def test_a_sun_of_a_colour(radiance, lamp, spectra, at_nm, kind):
    lamp(color=(0.2, 0.6, 1.0), energy=2.0)
    images, _ = radiance(NM, kind, samples=16)
    expected = 2.0 / np.pi * np.array([0.2, 0.6, 1.0]) @ spectra["emission"].rgb_illuminants()
    np.testing.assert_allclose(centre(images), at_nm(expected), rtol=0.01)


@pytest.mark.usefixtures("wall")
@pytest.mark.parametrize("kind", KINDS)
def test_a_measured_lamp_has_its_spectrum_at_the_luminance_of_its_colour(
    radiance, lamp, spectra, at_nm, kind
):
    sun = lamp(color=(0.2, 0.6, 1.0), energy=2.0)
    sun.spectral_probe.light, sun.spectral_probe.lamp = "LAMP", "FL11"
    images, warnings = radiance(NM, kind, samples=16)
    luminance = (
        2.0 / np.pi * np.array([0.2, 0.6, 1.0]) @ spectra["colorimetry"].rec709_to_xyz(np.eye(3))[:, 1]
    )
    expected = luminance * spectra["emission"].of_unit_luminance(spectra["library"].lamp_spectrum("FL11"))
    np.testing.assert_allclose(centre(images), at_nm(expected), rtol=0.01)
    assert not warnings


@pytest.mark.usefixtures("wall")
@pytest.mark.parametrize("kind", KINDS)
def test_temperature_is_a_black_body_and_a_colour_before_it_a_gel(radiance, lamp, spectra, at_nm, kind):
    lamp(use_temperature=True, temperature=3200.0, energy=np.pi)
    of_unit_luminance, body = spectra["emission"].of_unit_luminance, spectra["library"].planck(3200.0)
    images, _ = radiance(NM, kind, samples=16)
    np.testing.assert_allclose(centre(images), at_nm(of_unit_luminance(body)), rtol=0.01)
    bpy.data.lights["Sun"].color = (0.1, 0.5, 0.9)
    gel = spectra["uplift"].uplift(np.array([0.1, 0.5, 0.9]))
    images, _ = radiance(NM, kind, samples=16)
    shape = centre(images) / at_nm(body * gel)
    np.testing.assert_allclose(shape / shape[0], 1.0, rtol=1e-3)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("shader", ["ShaderNodeEmission", "ShaderNodeBsdfPrincipled"])
def test_a_blackbody_node_is_planck(radiance, ball, spectra, at_nm, kind, shader):
    tree = ball(shader).node_tree
    node, body = tree.nodes["Shader"], tree.nodes.new("ShaderNodeBlackbody")
    body.inputs[0].default_value = 2500.0
    principled = shader == "ShaderNodeBsdfPrincipled"
    tree.links.new(body.outputs[0], node.inputs["Emission Color" if principled else "Color"])
    node.inputs["Emission Strength" if principled else "Strength"].default_value = 3.0
    images, warnings = radiance(NM, kind)
    expected = 3.0 * spectra["emission"].of_unit_luminance(spectra["library"].planck(2500.0))
    np.testing.assert_allclose(centre(images), at_nm(expected), rtol=0.003)
    assert not warnings


@pytest.mark.usefixtures("wall")
@pytest.mark.parametrize("kind", KINDS)
def test_lamps_of_all_sorts_add_up_with_the_world(scene, radiance, glowing, lamp, kind):
    """Together as much as one by one: no light is in no group, or in two."""
    world = np.linspace(0.5, 2.0, 61) * 0.01
    scene.render.resolution_x = scene.render.resolution_y = 24
    glowing((1.0, 0.2, 0.1), 5.0, (3.0, -1.0, 0.0))
    measured = glowing((0.5, 0.5, 0.5), 8.0, (-3.0, -1.0, 0.0))
    measured.spectral_probe.light, measured.spectral_probe.lamp = "LAMP", "HP1"
    for name in ("FL11", "D65"):
        sun = lamp(name, energy=0.3)
        sun.spectral_probe.light, sun.spectral_probe.lamp = "LAMP", name
    together, _ = radiance(NM, kind, world, samples=32)
    dark, _ = radiance(NM, kind, world, samples=32, emission=False)
    sums = dark.copy()
    emitting = [thing for thing in scene.objects if thing.name not in {"Wall", "Camera"}]
    for thing in emitting:
        for other in emitting:
            other.hide_render = other != thing
        alone, _ = radiance(NM, kind, samples=32)
        sums += alone
    assert not np.allclose(together.mean((1, 2)), dark.mean((1, 2)), rtol=0.05)
    np.testing.assert_allclose(together.mean((1, 2)), sums.mean((1, 2)), rtol=0.02)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("source", ["image", "vertex colours", "procedural"])
def test_emission_of_varying_colour(radiance, glowing, spectra, at_nm, kind, source):
    colour = np.array([0.2, 0.7, 0.4])
    tree = glowing((1.0, 1.0, 1.0), 1.5).node_tree
    tree.links.new(varying(tree, source, colour), tree.nodes["Shader"].inputs["Color"])
    images, _ = radiance(NM, kind)
    np.testing.assert_allclose(
        centre(images), at_nm(1.5 * colour @ spectra["emission"].rgb_illuminants()), rtol=1e-3
    )


def varying(tree, source, colour):
    """A node output that gives a colour as an artist's texture does."""
    if source == "image":
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image = bpy.data.images.new("Texture", 4, 4, float_buffer=True, is_data=True)
        node.image.pixels = np.tile([*colour, 1.0], 16).tolist()
        return node.outputs["Color"]
    if source == "vertex colours":
        mesh = bpy.context.object.data
        layer = mesh.color_attributes.new("Col", "FLOAT_COLOR", "POINT")
        layer.data.foreach_set("color", np.tile([*colour, 1.0], len(mesh.vertices)).astype(np.float32))
        node = tree.nodes.new("ShaderNodeVertexColor")
        node.layer_name = "Col"
        return node.outputs["Color"]
    node = tree.nodes.new("ShaderNodeTexChecker")
    node.inputs["Color1"].default_value = node.inputs["Color2"].default_value = (*colour, 1.0)
    return node.outputs["Color"]


def test_a_texture_and_a_measured_lamp_on_one_object_are_named(radiance, glowing):
    tree = glowing((1.0, 1.0, 1.0)).node_tree
    tree.links.new(varying(tree, "procedural", (0.2, 0.7, 0.4)), tree.nodes["Shader"].inputs["Color"])
    measured = bpy.data.materials.new("Measured")
    node = measured.node_tree.nodes.new("ShaderNodeEmission")
    output = next(n for n in measured.node_tree.nodes if n.type == "OUTPUT_MATERIAL")
    measured.node_tree.links.new(node.outputs[0], output.inputs["Surface"])
    measured.spectral_probe.light, measured.spectral_probe.lamp = "LAMP", "FL11"
    bpy.context.object.data.materials.append(measured)
    _, warnings = radiance([550.0])
    assert len(warnings) == 1
    assert 'Material "Measured"' in warnings[0]
    assert "objects of their own" in warnings[0]


def test_an_unknown_lamp_is_named(radiance, lamp, extension):
    sun = lamp("Key")
    sun.spectral_probe.light, sun.spectral_probe.lamp = "LAMP", "Candle of Doom"
    with pytest.raises(extension("spectral_probe.errors").RenderError, match=r'Lamp "Key".*Candle of Doom'):
        radiance([550.0])

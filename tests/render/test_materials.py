"""Shaders of all kinds at a wavelength: what their colours must come to, and passes that stay grey."""

import bpy
import numpy as np
import pytest

NM = [440.0, 550.0, 650.0]
KINDS = ["light-basis", "wavelength"]
GRID = np.arange(400.0, 701.0, 5.0)
LIGHT = np.full(61, 0.01)
COLOUR = np.array([0.7, 0.35, 0.15])


def centre(images):
    return images[:, 28:36, 28:36].mean((1, 2))


@pytest.fixture
def reflectance(extension):
    """Reflectance of a Rec.709 colour at the wavelengths."""
    uplift = extension("spectral_probe.spectra.uplift").uplift
    return lambda colour: np.interp(NM, GRID, uplift(np.asarray(colour, float)))


SCALING = {
    "ShaderNodeBsdfDiffuse": "Color",
    "ShaderNodeBsdfAnisotropic": "Color",
    "ShaderNodeBsdfTransparent": "Color",
    "ShaderNodeBsdfRefraction": "Color",
    "ShaderNodeBsdfToon": "Color",
    "ShaderNodeBsdfSheen": "Color",
    "ShaderNodeBsdfHair": "Color",
}
"""Shaders whose throughput is proportional to one colour."""

THROUGH = ("ShaderNodeBsdfTransparent", "ShaderNodeBsdfRefraction")
"""Those of them that a ball shows twice."""

SHAPING = {
    "ShaderNodeBsdfPrincipled": {"Base Color": 1.0, "Specular Tint": 1.0, "Subsurface Weight": 0.5, "Coat Weight": 0.5,
                                 "Coat Tint": 1.0, "Sheen Weight": 0.3, "Sheen Tint": 1.0},
    "ShaderNodeSubsurfaceScattering": {"Color": 1.0},
    "ShaderNodeBsdfMetallic": {"Base Color": 1.0, "Edge Tint": 1.0},
    "ShaderNodeBsdfGlass": {"Color": 1.0},
    "ShaderNodeBsdfTranslucent": {"Color": 1.0},
    "ShaderNodeBsdfHairPrincipled": {"Color": 1.0},
}  # fmt: skip
"""Shaders that do more with their colours: a grey one of the reflectance must look the same."""


@pytest.mark.parametrize("kind", KINDS)
def test_throughput_follows_the_reflectance_of_the_colour(scene, radiance, ball, reflectance, kind):
    """One ball of each shader, its light with the colour over that in white."""
    sockets = []
    for number, (shader, name) in enumerate(SCALING.items()):
        place = ((number % 3 - 1) * 1.1, 0.0, (number // 3 - 1) * 1.1)
        node = ball(shader, place).node_tree.nodes["Shader"]
        if getattr(node, "distribution", "") == "MULTI_GGX":
            node.distribution = "GGX"  # several scatterings multiply the colour with itself
        thing = bpy.context.object
        thing.scale = (0.5, 0.5, 0.5)
        thing.visible_glossy = thing.visible_diffuse = thing.visible_shadow = False  # each for itself
        sockets.append(node.inputs[name])
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 3.3
    scene.cycles.max_bounces = 1
    scene.cycles.transparent_max_bounces = 8
    light = {}
    for colour in ((1.0, 1.0, 1.0), COLOUR):
        for socket in sockets:
            socket.default_value = (*colour, 1.0)
        images, warnings = radiance(NM, kind, LIGHT, samples=16)
        assert not warnings
        light[tuple(colour)] = (
            images[:, :63, :63].reshape(3, 3, 21, 3, 21)[:, ::-1, 8:13, :, 8:13].mean((2, 4))
        )
    white, coloured = light.values()
    for number, shader in enumerate(SCALING):
        row, column = number // 3, number % 3
        if white[:, row, column].max() < 1e-5:
            continue  # nothing of a back-lit shader from here
        ratio = coloured[:, row, column] / white[:, row, column]
        once = reflectance(COLOUR)
        surfaces = np.log(ratio) / np.log(once)
        passed = 2.0 if shader in THROUGH else 1.0
        np.testing.assert_allclose(surfaces, passed, atol=0.02 * passed, err_msg=shader)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("shader", SHAPING)
def test_a_colour_acts_as_the_grey_of_its_reflectance(scene, radiance, ball, reflectance, shader, kind):
    node = ball(shader).node_tree.nodes["Shader"]
    scene.render.resolution_x = scene.render.resolution_y = 32
    numbers = {name: v for name, v in SHAPING[shader].items() if node.inputs[name].type == "VALUE"}
    colours = [name for name in SHAPING[shader] if name not in numbers]
    for name, value in numbers.items():
        node.inputs[name].default_value = value
    for name in colours:
        node.inputs[name].default_value = (*COLOUR, 1.0)
    images, warnings = radiance(NM, kind, LIGHT, samples=16)
    assert not warnings
    for number, grey in enumerate(reflectance(COLOUR)):
        for name in colours:
            node.inputs[name].default_value = (grey, grey, grey, 1.0)
        alone, _ = radiance([NM[number]], "light-basis", LIGHT, samples=16)
        inner = (slice(None), slice(10, 22), slice(10, 22))
        tolerance = (
            0.03 if any("Radius" in i.name for i in node.inputs) else 0.004
        )  # walks below the surface are noisy
        np.testing.assert_allclose(images[inner][number].mean(), alone[inner].mean(), rtol=tolerance)


@pytest.mark.parametrize("working_space", ["Linear Rec.709", "ACEScg", "Linear Rec.2020"])
@pytest.mark.parametrize("kind", KINDS)
def test_colours_from_anywhere_agree(scene, radiance, ball, reflectance, kind, working_space):
    """Constant, texture, vertex colours, ramp and object colour in any working space; and white stays white."""
    from mathutils import Color

    bpy.ops.wm.set_working_color_space(working_space=working_space, convert_colors=False)
    inside = tuple(Color(COLOUR).from_rec709_linear_to_scene_linear())
    sources = ["constant", "image", "vertex", "ramp", "object"]
    for number, source in enumerate(sources):
        tree = ball(location=((number % 3 - 1) * 1.1, 0.0, (number // 3) * 1.1)).node_tree
        bpy.context.object.scale = (0.5, 0.5, 0.5)
        paint(tree, source, inside)
    white = ball(location=(1.1, 0.0, 1.1)).node_tree.nodes["Shader"]
    bpy.context.object.scale = (0.5, 0.5, 0.5)
    white.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 3.3
    scene.cycles.max_bounces = 1
    images, warnings = radiance(NM, kind, LIGHT, samples=16)
    assert not warnings
    cells = images[:, :63, :63].reshape(3, 3, 21, 3, 21)[:, :, 8:13, :, 8:13].mean((2, 4)) / 0.01
    rows = cells[:, 1], cells[:, 0]  # the ball at z = 0, and that above it
    measured = [rows[number // 3][:, number % 3] for number in range(6)]
    for source, values in zip(sources, measured, strict=False):
        np.testing.assert_allclose(values / measured[5], reflectance(COLOUR), rtol=0.01, err_msg=source)


def paint(tree, source, colour):
    """Link a shader's colour to something that gives a colour of the working space."""
    socket, rgba = tree.nodes["Shader"].inputs["Color"], (*colour, 1.0)
    if source == "constant":
        socket.default_value = rgba
        return
    if source == "image":
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image = bpy.data.images.new("Texture", 4, 4, float_buffer=True, is_data=True)
        node.image.pixels = list(rgba) * 16
    elif source == "vertex":
        mesh = bpy.context.object.data
        layer = mesh.color_attributes.new("Col", "FLOAT_COLOR", "POINT")
        layer.data.foreach_set("color", np.tile(rgba, len(mesh.vertices)).astype(np.float32))
        node = tree.nodes.new("ShaderNodeVertexColor")
        node.layer_name = "Col"
    elif source == "ramp":
        node = tree.nodes.new("ShaderNodeValToRGB")
        for element in node.color_ramp.elements:
            element.color = rgba
    else:
        bpy.context.object.color = rgba
        node = tree.nodes.new("ShaderNodeObjectInfo")
    tree.links.new(node.outputs["Color"], socket)


def test_colours_out_of_gamut_are_clipped_and_named(radiance, ball):
    bpy.ops.wm.set_working_color_space(working_space="Linear Rec.2020", convert_colors=False)
    ball().node_tree.nodes["Shader"].inputs["Color"].default_value = (0.0, 0.8, 0.0, 1.0)
    images, warnings = radiance(NM, "light-basis", LIGHT)
    assert len(warnings) == 1
    assert 'Material "Material"' in warnings[0]
    assert "gamut" in warnings[0]
    assert centre(images).max() <= 0.01


def test_a_thin_film_is_left_out_and_named(radiance, ball):
    node = ball("ShaderNodeBsdfMetallic").node_tree.nodes["Shader"]
    node.inputs["Thin Film Thickness"].default_value = 400.0
    _, warnings = radiance([550.0], "light-basis", LIGHT)
    assert len(warnings) == 1
    assert "thin film" in warnings[0]


def test_melanin_darkens_the_short_waves(radiance, ball):
    node = ball("ShaderNodeBsdfHairPrincipled").node_tree.nodes["Shader"]
    node.parametrization = "MELANIN"
    images, warnings = radiance(NM, "light-basis", LIGHT)
    assert not warnings
    blue, _, red = centre(images)
    assert 0 < blue < red

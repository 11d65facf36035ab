"""The scene's own world as light: exact colours, and the sky as daylight."""

import bpy
import numpy as np
import pytest

NM = [440.0, 550.0, 650.0]
GRID = np.arange(400.0, 701.0, 5.0)


@pytest.fixture
def world(scene):
    scene.world = bpy.data.worlds.new("Own")
    return scene.world


@pytest.fixture
def rendered(scene, extension, render_groups):
    """Spectral radiance (M, H, W) of the scene in the light of its own world."""

    def render(kind, level=0.03):
        own_world_light = extension("operators.bridge.own_world").own_world_light
        one = kind == "light-basis"
        triples = [np.full(3, nm) for nm in NM] if one else np.reshape(NM, (-1, 3))
        images = []
        with own_world_light(scene, one_wavelength=one, level=level) as light:
            for triple in triples:
                light.set_wavelengths(triple)
                image = render_groups()["Combined"]
                if one:
                    images.append(image @ np.array([np.interp(triple[0], GRID, s) for s in light.spectra]))
                else:
                    images.extend(np.moveaxis(image, -1, 0) * level)
        return np.stack(images)

    return render


@pytest.mark.parametrize("kind", ["light-basis", "wavelength"])
@pytest.mark.parametrize("linked", [False, True])
def test_a_coloured_world_is_light_of_that_colour(rendered, world, extension, kind, linked):
    colour = np.array([0.3, 0.9, 0.2])
    tree = world.node_tree
    background = tree.nodes["Background"]
    background.inputs["Strength"].default_value = 1.5
    background.inputs["Color"].default_value = (*colour, 1.0)
    if linked:
        node = tree.nodes.new("ShaderNodeRGB")
        node.outputs[0].default_value = (*colour, 1.0)
        tree.links.new(node.outputs[0], background.inputs["Color"])
    illuminants = extension("spectral_probe.spectra.emission").rgb_illuminants()
    expected = np.interp(NM, GRID, 1.5 * colour @ illuminants)
    np.testing.assert_allclose(rendered(kind)[:, 32, 32], expected, rtol=1e-4)
    assert bpy.context.scene.world == world
    assert len(bpy.data.worlds) == 1


def test_a_sky_is_daylight_in_either_kind_of_pass(scene, rendered, world, extension):
    tree = world.node_tree
    sky = tree.nodes.new("ShaderNodeTexSky")
    sky.sun_disc, sky.sky_type = False, "PREETHAM"
    tree.links.new(sky.outputs[0], tree.nodes["Background"].inputs["Color"])
    world.cycles.sampling_method = "NONE"  # only looked at: no importance map
    scene.camera.rotation_euler = (np.pi * 0.7, 0.0, 0.0)
    layers, wavelengths = rendered("light-basis"), rendered("wavelength")
    np.testing.assert_allclose(layers, wavelengths, rtol=0.02, atol=1e-3 * layers.max())
    modules = [extension(f"spectral_probe.spectra.{name}") for name in ("emission", "library")]
    spectrum = layers[:, 32, 32]
    phases = np.stack([modules[1].daylight(kelvin) for kelvin in (5000.0, 6500.0, 12000.0, 20000.0)])
    at = np.stack([np.interp(NM, GRID, phase) for phase in phases])
    misses = [np.abs(spectrum / spectrum[1] - phase / phase[1]).max() for phase in at]
    assert min(misses) < 0.35, misses
    assert spectrum[0] > spectrum[2]  # the sky is blue


def test_without_a_world_it_is_said(scene, extension, world):
    own_world_light = extension("operators.bridge.own_world").own_world_light
    error = extension("spectral_probe.errors").RenderError
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0
    with pytest.raises(error, match="is dark"), own_world_light(scene, one_wavelength=True):
        pass
    scene.world = None
    with pytest.raises(error, match="no world and no lamp"), own_world_light(scene, one_wavelength=True):
        pass


@pytest.mark.parametrize(
    ("passes", "colour", "lamp"),
    [(4, (0.3, 0.9, 0.2), False), (4, (0.0, 0.0, 0.0), True), ("all", (0.3, 0.9, 0.2), True)],
)
def test_a_whole_render_in_the_light_of_the_own_world(
    scene, world, bridge, extension, ball, tmp_path, passes, colour, lamp
):
    """The background has the world's colour, a white ball that of all light on it, as the RGB twin has."""
    finish, read = (
        extension("spectral_probe.model").finish,
        extension("spectral_probe.files.image_exr").read_rgb,
    )
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (*colour, 1.0)
    background.inputs["Strength"].default_value = 1.5
    material = ball()
    material.node_tree.nodes["Shader"].inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    if lamp:
        sun = bpy.data.lights.new("Sun", "SUN")
        sun.color, sun.energy, sun.angle = (0.9, 0.5, 0.4), 3.0, 0.0
        thing = bpy.data.objects.new("Sun", sun)
        thing.rotation_euler = (np.pi / 2, 0.0, 0.0)
        scene.collection.objects.link(thing)
    before = scene.world, len(bpy.data.worlds)
    result = finish(bridge.spectral_render(scene, None, None, tmp_path, samples=4, passes=passes))
    rgb = read(result.rgb, ("R", "G", "B"))
    to_rec709 = extension("spectral_probe.spectra.colorimetry").xyz_to_rec709
    image = to_rec709(read(result.xyz, ("X", "Y", "Z")))
    np.testing.assert_allclose(image[2, 2], 1.5 * np.array(colour), rtol=1e-3, atol=1e-5)
    np.testing.assert_allclose(image[28:36, 28:36], rgb[28:36, 28:36], rtol=0.01)
    assert image[32, 32].min() > 0.1
    assert (scene.world, len(bpy.data.worlds)) == before
    if passes != "all":
        return
    again = finish(  # a wavelength plan that was rendered by is multiplied by the light's level once only
        bridge.spectral_render(scene, None, result.plan, tmp_path / "again", samples=4, rgb_twin=False)
    )
    np.testing.assert_allclose(to_rec709(read(again.xyz, ("X", "Y", "Z"))), image, rtol=1e-4, atol=1e-5)


def test_without_world_and_lamp_it_is_said_before_rendering(scene, bridge, extension, tmp_path):
    scene.world = None
    job = bridge.spectral_render(scene, None, None, tmp_path, samples=1, passes=3)
    with pytest.raises(extension("spectral_probe.errors").RenderError, match="no world and no lamp"):
        extension("spectral_probe.model").finish(job)

"""The spectral render against what theory says its pixels must be."""

import json
import math

import bpy
import numpy as np
import pytest

RAMP = np.linspace(0.5, 2.0, 61)


@pytest.fixture
def render(scene, bridge, extension, tmp_path):
    """Render the scene to its end and return (result, reader of its images)."""

    def run(probe, *, passes=3, samples=4, rgb_twin=False, plan=None, folder="out"):
        job = bridge.spectral_render(
            scene, probe, plan, tmp_path / folder, samples=samples, passes=passes, rgb_twin=rgb_twin
        )
        return extension("spectral_probe.model").finish(job)

    return run


@pytest.fixture
def xyz_of(extension):
    return lambda result: extension("spectral_probe.files.image_exr").read_rgb(result.xyz, ("X", "Y", "Z"))


def centre(image):
    return image[28:36, 28:36].mean((0, 1))


@pytest.mark.parametrize("passes", [4, "all"])
def test_background_is_the_light_itself(render, xyz_of, extension, uniform_light, passes):
    expected = extension("spectral_probe.spectra.colorimetry").spectra_to_xyz(RAMP)
    np.testing.assert_allclose(
        centre(xyz_of(render(uniform_light(RAMP), passes=passes))), expected, rtol=1e-4
    )


@pytest.mark.parametrize("passes", [5, "all"])
def test_gold_facing_the_camera_reflects_by_fresnel(render, xyz_of, extension, uniform_light, ball, passes):
    material = ball("ShaderNodeBsdfMetallic")
    material.spectral_probe.kind, material.spectral_probe.metal = "METAL", "Au"
    material.node_tree.nodes["Shader"].inputs["Roughness"].default_value = 0.0
    metals = extension("spectral_probe.spectra.metals")
    to_xyz = extension("spectral_probe.spectra.colorimetry").spectra_to_xyz
    expected = to_xyz(metals.metal_reflectance("Au", np.array(1.0)) * RAMP)
    measured = centre(xyz_of(render(uniform_light(RAMP), passes=passes, samples=8)))
    np.testing.assert_allclose(measured, expected, rtol=0.004)


@pytest.mark.parametrize("shader", ["ShaderNodeBsdfPrincipled", "ShaderNodeBsdfAnisotropic"])
def test_other_shaders_become_the_metal(render, xyz_of, extension, uniform_light, ball, shader):
    material = ball(shader)
    material.spectral_probe.kind, material.spectral_probe.metal = "METAL", "Cu"
    material.node_tree.nodes["Shader"].inputs["Roughness"].default_value = 0.0
    metals = extension("spectral_probe.spectra.metals")
    to_xyz = extension("spectral_probe.spectra.colorimetry").spectra_to_xyz
    expected = to_xyz(metals.metal_reflectance("Cu", np.array(1.0)) * RAMP)
    np.testing.assert_allclose(centre(xyz_of(render(uniform_light(RAMP), passes=5))), expected, rtol=0.005)


def test_measured_reflectance(render, xyz_of, extension, uniform_light, ball, tmp_path):
    reflectance = 0.2 + 0.6 * (np.arange(61) > 30)
    np.savetxt(tmp_path / "step.csv", np.column_stack([np.arange(400, 701, 5), reflectance]), delimiter=",")
    material = ball()
    material.spectral_probe.kind = "REFLECTANCE"
    material.spectral_probe.reflectance_path = str(tmp_path / "step.csv")
    expected = extension("spectral_probe.spectra.colorimetry").spectra_to_xyz(reflectance * RAMP)
    measured = centre(xyz_of(render(uniform_light(RAMP), passes="all", samples=8)))
    np.testing.assert_allclose(measured, expected, rtol=0.005)


@pytest.mark.parametrize(
    ("passes", "working_space", "linked"),
    [
        (6, "Linear Rec.709", False),
        (6, "Linear Rec.709", True),
        (6, "ACEScg", False),
        ("all", "ACEScg", True),
    ],
)
def test_colours_are_uplifted(render, xyz_of, extension, uniform_light, ball, passes, working_space, linked):
    """Constant or linked, in whatever working space: a colour is the reflectance that looks like it under D65."""
    rec709 = np.array([0.7, 0.3, 0.1])
    bpy.ops.wm.set_working_color_space(working_space=working_space, convert_colors=False)
    from mathutils import Color

    material = ball()
    tree, colour = material.node_tree, (*Color(rec709).from_rec709_linear_to_scene_linear(), 1.0)
    if linked:
        source = tree.nodes.new("ShaderNodeRGB")
        source.outputs[0].default_value = colour
        tree.links.new(source.outputs[0], tree.nodes["Shader"].inputs["Color"])
    else:
        tree.nodes["Shader"].inputs["Color"].default_value = colour
    colorimetry = extension("spectral_probe.spectra.colorimetry")
    daylight = colorimetry.illuminant("D65") / colorimetry.spectra_to_xyz(colorimetry.illuminant("D65"))[1]
    result = render(uniform_light(daylight), passes=passes, samples=8, rgb_twin=True)
    spectral = centre(xyz_of(result))
    np.testing.assert_allclose(colorimetry.xyz_to_rec709(spectral), rec709, rtol=0.02, atol=0.004)
    read_rgb = extension("spectral_probe.files.image_exr").read_rgb
    np.testing.assert_allclose(centre(read_rgb(result.rgb)), colour[:3], rtol=0.01)  # in the working space
    np.testing.assert_allclose(
        centre(read_rgb(result.image)), centre(read_rgb(result.rgb)), rtol=0.03, atol=0.004
    )


def test_linked_groups_are_translated_too(render, xyz_of, extension, uniform_light, ball):
    material = ball()
    group = bpy.data.node_groups.new("Group", "ShaderNodeTree")
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    shader, output = group.nodes.new("ShaderNodeBsdfDiffuse"), group.nodes.new("NodeGroupOutput")
    shader.inputs["Color"].default_value = (0.1, 0.6, 0.2, 1.0)
    group.links.new(shader.outputs[0], output.inputs[0])
    node = material.node_tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    surface = next(n for n in material.node_tree.nodes if n.type == "OUTPUT_MATERIAL").inputs["Surface"]
    material.node_tree.links.new(node.outputs[0], surface)
    reflectance = extension("spectral_probe.spectra.uplift").uplift(np.array([0.1, 0.6, 0.2]))
    expected = extension("spectral_probe.spectra.colorimetry").spectra_to_xyz(reflectance * RAMP)
    measured = centre(xyz_of(render(uniform_light(RAMP), passes="all", samples=8)))
    np.testing.assert_allclose(measured, expected, rtol=0.005)


def two_lights(extension, height=16):
    """Filament light from +X's half of the world, daylight from the other."""
    library = extension("spectral_probe.spectra.library")
    weights = np.zeros((height, 2 * height, 2), np.float32)
    towards_x = np.abs(np.arange(2 * height) + 0.5 - height) < height / 2
    weights[:, towards_x, 0] = weights[:, ~towards_x, 1] = 1.0
    return extension("spectral_probe.model").SpectralPanorama(
        weights=weights,
        bases=np.stack([library.planck(2856.0), library.daylight(6500.0)])[None],
        basis_index=np.zeros(weights.shape[:2], np.uint8),
        wavelengths_nm=np.arange(400.0, 701.0, 5.0),
        valid=np.ones(weights.shape[:2], bool),
        confidence=np.ones(weights.shape[:2], np.float32),
    )


@pytest.mark.long
def test_a_light_basis_plan_agrees_with_all_wavelengths(render, xyz_of, extension, ball):
    for metal, x in (("Au", -1.1), ("Cu", 1.1)):
        material = ball("ShaderNodeBsdfMetallic", (x, 0.0, 0.0))
        material.spectral_probe.kind, material.spectral_probe.metal = "METAL", metal
    probe = two_lights(extension)
    few, every = (
        xyz_of(render(probe, passes=passes, samples=32, folder=str(passes))) for passes in (None, "all")
    )
    assert np.abs(few.mean((0, 1)) / every.mean((0, 1)) - 1).max() < 0.005
    coarse = [image.reshape(16, 4, 16, 4, 3).mean((1, 3)) for image in (few, every)]
    colorimetry = extension("spectral_probe.spectra.colorimetry")
    white = np.asarray(colorimetry.white_xyz("D65")) * every[..., 1].max()
    error = colorimetry.delta_e_2000(*coarse, white)
    assert error.mean() < 0.5


def test_the_world_of_the_user_turns_the_light(scene, render, xyz_of, extension, tmp_path):
    probe, world = two_lights(extension), extension("operators.bridge.world")
    scene.camera.data.type, scene.camera.data.panorama_type = "PANO", "EQUIRECTANGULAR"
    scene.camera.rotation_euler = (
        math.pi / 2,
        0.0,
        -math.pi / 2,
    )  # looks along +X, so that columns are the panorama's
    scene.render.resolution_x, scene.render.resolution_y = 128, 64
    plain = xyz_of(render(probe))
    small = plain.reshape(16, 4, 32, 4, 3).mean((1, 3))
    expected = extension("spectral_probe.spectra.colorimetry").spectra_to_xyz(
        np.einsum("hwk,kl->hwl", probe.weights, probe.bases[0])
    )
    inner = (
        slice(1, -1),
        np.array([2, 4, 14, 16, 18, 28, 30]),
    )  # away from the edges, which interpolation blurs
    np.testing.assert_allclose(small[inner], expected[inner], rtol=1e-3)

    image = tmp_path / "world.exr"
    extension("spectral_probe.files.image_exr").write_rgb(image, np.ones((16, 32, 3)))
    world.light_world(scene, image, rotation_rad=math.pi / 2, strength=2.0)
    turned = xyz_of(render(probe, folder="turned"))
    # Counter-clockwise by a quarter, what was at +X is at +Y: a quarter of the width to the left.
    difference = np.abs(turned - 2.0 * np.roll(plain, -32, axis=1)) / plain.max()
    assert np.median(difference) < 1e-3
    assert np.median(np.abs(turned - 2.0 * plain) / plain.max()) > 0.01


def test_lamps_and_emission_light_both_alike(scene, render, extension, uniform_light, ball):
    light = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    light.rotation_euler, light.data.energy, light.data.color = (1.2, 0.0, 0.3), 3.0, (0.9, 0.6, 0.4)
    scene.collection.objects.link(light)
    ball()
    glowing = ball("ShaderNodeEmission", (1.1, 0.0, 1.1))
    glowing.node_tree.nodes["Shader"].inputs["Color"].default_value = (0.2, 0.5, 0.9, 1.0)
    result = render(uniform_light(RAMP * 1e-3), rgb_twin=True, passes=4, samples=16)
    read_rgb = extension("spectral_probe.files.image_exr").read_rgb
    spectral, rgb = read_rgb(result.image), read_rgb(result.rgb)
    np.testing.assert_allclose(centre(spectral), centre(rgb), rtol=0.05)
    np.testing.assert_allclose(spectral.mean((0, 1)), rgb.mean((0, 1)), rtol=0.03)
    written = json.loads((result.xyz.parent / "report.json").read_text())
    assert written["warnings"] == list(result.warnings)
    assert written["seconds"]["spectral"] > 0
    assert written["seconds"]["rgb"] > 0
    np.testing.assert_allclose(written["mean_light"], RAMP * 1e-3)


def test_transparent_film_keeps_alpha(scene, render, extension, uniform_light, ball):
    scene.render.film_transparent = True
    ball()
    result = render(uniform_light(RAMP), rgb_twin=True)
    for path in (result.image, result.rgb):
        channels, _ = extension("spectral_probe.files.image_exr").read_channels(path)
        assert channels["A"][0, 0] == 0
        assert channels["A"][32, 32] == 1
        assert channels["R"][0, 0] == 0


def test_folders_with_signs_that_blender_reads_as_templates(render, uniform_light):
    result = render(uniform_light(RAMP), folder="a {scene} # folder")
    assert result.image.is_file()
    assert len(list((result.image.parent / "passes").glob("*.exr"))) == 3


def test_a_second_render_leaves_no_pass_of_the_first(render, uniform_light):
    render(uniform_light(RAMP), passes=5)
    result = render(uniform_light(RAMP), passes=3)
    assert sorted((result.image.parent / "passes").glob("*.exr")) == list(result.passes)


def test_a_plan_is_kept_and_can_be_given(render, xyz_of, extension, uniform_light):
    first = render(uniform_light(RAMP), passes=4)
    plan = extension("spectral_probe.render.plan").load_plan(first.xyz.parent / "plan.json")
    again = render(uniform_light(RAMP), plan=plan, folder="again")
    assert again.plan.passes == 4
    np.testing.assert_allclose(xyz_of(again), xyz_of(first), rtol=1e-5)


class TestRefusals:
    def refused(self, extension, render, uniform_light, match, **options):
        error = extension("spectral_probe.errors").RenderError
        with pytest.raises(error, match=match) as caught:
            render(uniform_light(RAMP), **options)
        assert "\n" not in str(caught.value)

    def test_another_engine(self, scene, extension, render, uniform_light):
        scene.render.engine = "BLENDER_EEVEE"
        self.refused(extension, render, uniform_light, "Set Render Engine to Cycles")
        assert scene.render.engine == "BLENDER_EEVEE"

    def test_no_camera(self, scene, extension, render, uniform_light):
        scene.camera = None
        self.refused(extension, render, uniform_light, "no camera")

    def test_a_plan_for_other_light(self, extension, render, uniform_light):
        plan = render(uniform_light(RAMP[::-1].copy()), passes=3).plan
        self.refused(extension, render, uniform_light, "another light", plan=plan, folder="other")

    def test_an_unknown_metal(self, extension, render, uniform_light, ball):
        material = ball("ShaderNodeBsdfMetallic")
        material.spectral_probe.kind, material.spectral_probe.metal = "METAL", "Unobtainium"
        self.refused(extension, render, uniform_light, f'Material "{material.name}".*Unobtainium')

    def test_a_metal_without_a_shader(self, extension, render, uniform_light, ball):
        ball().spectral_probe.kind = "METAL"
        self.refused(extension, render, uniform_light, "Add a Metallic BSDF")

    def test_a_missing_table(self, extension, render, uniform_light, ball):
        material = ball()
        material.spectral_probe.kind = "REFLECTANCE"
        self.refused(extension, render, uniform_light, "no file with its reflectance")

    def test_data_of_another_file(self, scene, extension, render, uniform_light, ball, tmp_path):
        ball().name = "Foreign"
        bpy.data.libraries.write(str(tmp_path / "library.blend"), {bpy.context.object})
        name = bpy.context.object.name
        bpy.data.objects.remove(bpy.context.object)
        bpy.data.materials.remove(bpy.data.materials["Foreign"])
        with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, wanted):
            wanted.objects = [name]
        scene.collection.objects.link(wanted.objects[0])
        self.refused(extension, render, uniform_light, 'Material "Foreign".*Make it local')
        assert len(bpy.data.materials) == 1

"""Scenes with shadow catchers: rendered with their virtual objects and without, into folders that belong together."""

import json

import bpy
import numpy as np
import pytest

WORDS = {"samples": 16, "passes": 2, "rgb_twin": False}


@pytest.fixture
def furnished(scene, ball):
    """A ball on a ground that is a shadow catcher, seen from above; beyond the ground, nothing."""
    scene.render.resolution_x, scene.render.resolution_y = 36, 24
    scene.cycles.use_denoising = False
    scene.camera.location.z, scene.camera.rotation_euler.x = 2.5, 1.12
    ball()
    bpy.context.object.name = "Ball"
    bpy.ops.mesh.primitive_plane_add(size=8.0, location=(0.0, 0.0, -1.0))
    bpy.context.object.name = "Ground"
    bpy.context.object.is_shadow_catcher = True
    return scene


@pytest.fixture
def job_of(furnished, bridge, uniform_light, tmp_path):
    def make(**words):
        return bridge.spectral_render(
            furnished, uniform_light(np.full(61, 0.01)), None, tmp_path / "out", **{**WORDS, **words}
        )

    return make


@pytest.fixture
def render(job_of, extension):
    return lambda **words: extension("spectral_probe.model").finish(job_of(**words))


@pytest.fixture
def luminance(extension):
    def read(path):
        channels, _ = extension("spectral_probe.files.image_exr").read_channels(path)
        return channels["Y" if "Y" in channels else "G"], channels["A"]

    return read


def test_both_parts_are_complete_renders(render, luminance, extension, tmp_path):
    result = render(rgb_twin=True)
    out, alone = tmp_path / "out", tmp_path / "out" / "without"
    names = {path.name for path in out.iterdir()}
    assert names - {path.name for path in alone.iterdir()} == {"objects.exr", "backplate.json", "without"}
    assert (out / "plan.json").read_bytes() == (alone / "plan.json").read_bytes()
    report = json.loads((out / "report.json").read_text())
    assert (report["objects"], report["shadow_catchers"]) == (["Ball"], ["Ground"])
    assert report["without"]["folder"] == "without"
    assert report["without"]["seconds"]["spectral"] == result.without.seconds_spectral > 0

    found = extension("spectral_probe.files.objects_exr").read_objects(result.objects)
    for name in ("xyz.exr", "rgb.exr"):
        (with_, alpha), (without, alpha_alone) = luminance(out / name), luminance(alone / name)
        np.testing.assert_allclose(alpha, found.coverage + found.ground, atol=2e-3)
        hidden = found.coverage > 0.999
        assert alpha_alone[hidden].min() == 0.0  # the ball's upper part is before nothing
        assert alpha_alone[hidden].max() == 1.0
        assert without[alpha_alone == 0].max() == 0.0
        ground = (found.coverage == 0) & (found.ground == 1.0)
        near = np.zeros_like(ground)
        near[20:, 13:-13] = True
        assert with_[ground & near].mean() < 0.8 * without[ground & near].mean()
        far = np.zeros_like(ground)
        far[16:, :4] = far[16:, -4:] = True
        np.testing.assert_allclose(with_[ground & far].mean(), without[ground & far].mean(), rtol=0.15)


def test_the_noise_of_both_cancels_where_no_path_meets_an_object(render, furnished, luminance, tmp_path):
    """Same samples and same seed: with the ball behind the camera's back and far away, hardly a pixel differs."""
    furnished.objects["Ball"].location = (0.0, -60.0, 0.0)
    render()
    (with_, _), (without, _) = (luminance(tmp_path / "out" / part / "xyz.exr") for part in ("", "without"))
    noise = without[-8:].std()
    assert noise > 0
    assert (np.abs(with_ - without)[-8:] < 0.05 * noise).mean() > 0.9


def test_lamps_stay_and_what_emits_is_virtual(render, furnished, luminance, tmp_path):
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    lamp.location, lamp.data.energy = (-3.0, 0.0, 1.0), 60.0
    furnished.collection.objects.link(lamp)
    tree = bpy.data.materials["Material"].node_tree
    glow = tree.nodes.new("ShaderNodeEmission")
    glow.inputs["Strength"].default_value = 20.0
    tree.links.new(
        glow.outputs[0], next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL").inputs["Surface"]
    )
    render()
    (with_, _), (without, _) = (luminance(tmp_path / "out" / part / "xyz.exr") for part in ("", "without"))
    assert without[-6:, :6].mean() > 1.15 * without[-6:, -6:].mean()  # the lamp is on the left
    assert with_[-2:, -6:].mean() > 1.1 * without[-2:, -6:].mean()  # and the ball shines, too


@pytest.mark.parametrize("by", ["collection", "geometry nodes"])
def test_instances_are_left_out_too(render, furnished, luminance, tmp_path, by):
    ball = furnished.objects["Ball"]
    ball.hide_render = by == "geometry nodes"
    if by == "collection":
        shown = bpy.data.collections.new("Shown")
        furnished.collection.objects.unlink(ball)
        shown.objects.link(ball)
        maker = bpy.data.objects.new("Maker", None)
        maker.instance_type, maker.instance_collection = "COLLECTION", shown
    else:
        maker = bpy.data.objects.new("Maker", bpy.data.meshes.new("Empty"))
        group = bpy.data.node_groups.new("Shows", "GeometryNodeTree")
        group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
        info, output = group.nodes.new("GeometryNodeObjectInfo"), group.nodes.new("NodeGroupOutput")
        info.inputs["Object"].default_value, info.inputs["As Instance"].default_value = ball, True
        group.links.new(info.outputs["Geometry"], output.inputs[0])
        maker.modifiers.new("Shows", "NODES").node_group = group
    furnished.collection.objects.link(maker)
    bpy.context.view_layer.update()
    result = render()
    assert "Ball" in result.virtual
    (_, alpha), (_, alone) = (luminance(tmp_path / "out" / part / "xyz.exr") for part in ("", "without"))
    assert alpha[4, 18] == 1.0
    assert alone[4, 18] == 0.0


class TestInterrupted:
    def test_in_the_part_without_the_objects(self, job_of, render, furnished, tmp_path):
        job, told = job_of(), set()
        for progress in job:
            told |= {progress.message} if "without the objects" in progress.message else set()
            if len(told) == 2:  # its first pass is rendered
                break
        job.close()
        assert all(thing.visible_camera for thing in furnished.objects)
        assert furnished.objects["Ground"].is_shadow_catcher
        assert not furnished.render.film_transparent
        assert not (tmp_path / "out" / "report.json").exists()
        result = render()
        assert result.steps_kept == len(result.passes)
        assert result.without.steps_kept == 1 < len(result.without.passes)

    def test_and_the_scene_changed(self, job_of, render, furnished, extension):
        job = job_of()
        for progress in job:
            if "without the objects" in progress.message:
                break
        job.close()
        furnished.objects["Ball"].is_shadow_catcher = True
        with pytest.raises(extension("operators.bridge.resuming").SceneChangedError, match="scene changed"):
            render()
        result = render(on_change="restart")
        assert result.steps_kept == 0
        assert result.without is None
        assert any("nothing virtual" in text for text in result.warnings)


def test_a_render_of_ordinary_surfaces_is_not_taken_for_one_of_catchers(render, furnished, tmp_path):
    assert render().without.steps_kept == 0
    assert render().without.steps_kept == 3  # the same again
    furnished.objects["Ground"].is_shadow_catcher = False
    note = tmp_path / "out" / "without" / "note.txt"
    note.write_text("mine")
    ordinary = render()
    assert (ordinary.steps_kept, ordinary.without) == (0, None)
    assert [path.name for path in note.parent.iterdir()] == ["note.txt"]
    furnished.objects["Ground"].is_shadow_catcher = True
    assert render().without.steps_kept == 0


def test_under_its_own_world_and_in_every_view_layer(furnished, bridge, extension, tmp_path):
    furnished.world = bpy.data.worlds.new("Own")
    furnished.view_layers.new("Other")
    job = bridge.spectral_render(furnished, None, None, tmp_path, **WORDS)
    result = extension("spectral_probe.model").finish(job)
    read = extension("spectral_probe.files.objects_exr").read_objects
    first, other = read(tmp_path / "objects.exr"), read(tmp_path / "objects_Other.exr")
    np.testing.assert_array_equal(first.coverage, other.coverage)
    assert (tmp_path / "without" / "xyz_Other.exr").is_file()
    assert result.without.layers == result.layers == ("ViewLayer", "Other")


def test_the_camera_is_written(furnished, extension):
    """A point of the world falls on the pixel where Blender's own camera puts it."""
    from bpy_extras.object_utils import world_to_camera_view
    from mathutils import Vector

    camera = furnished.camera.data
    camera.shift_x, camera.shift_y, camera.sensor_fit = 0.1, -0.05, "VERTICAL"
    furnished.render.pixel_aspect_x = 1.5
    furnished.camera.rotation_euler = (1.4, 0.1, 0.2)
    bpy.context.view_layer.update()
    find = extension("operators.bridge.camera_backplate").camera_backplate
    backplate = find(furnished, (36, 24))
    for point in ((0.3, 0.5, -0.4), (-1.0, 2.0, 0.7)):
        seen = (np.array(point) - backplate.position_m) @ backplate.rotation
        pixel = np.array(backplate.camera.focal_px) * seen[:2] / seen[2] + backplate.camera.principal_px
        u, v, _ = world_to_camera_view(furnished, furnished.camera, Vector(point))
        np.testing.assert_allclose(pixel, (u * 36, (1 - v) * 24), atol=1e-3)
    camera.type = "ORTHO"
    assert find(furnished, (36, 24)) is None

"""A virtual grey ball where a real one stood: a simulated photograph of it, and the composite into one without it.

The photographs are ordinary Cycles renders in RGB, of other samples; the ball is rendered spectrally.
"""

from contextlib import ExitStack

import bpy
import numpy as np
import pytest

PHOTO_SAMPLES, SAMPLES = 128, 96
RADIUS_M, TABLE_Z_M = 0.8, -1.0


@pytest.fixture
def light(extension):
    """A bright sky over a darker lower half, with a large lamp in it."""
    weights = np.ones((16, 32, 1), np.float32)
    weights[8:] *= 0.4
    weights[3:5, 10:13] = 14.0
    daylight = extension("spectral_probe.spectra.library").daylight(5500.0)
    return extension("spectral_probe.model").SpectralPanorama(
        weights=weights,
        bases=(daylight / daylight.max())[None, None] * 0.01,
        basis_index=np.zeros(weights.shape[:2], np.uint8),
        wavelengths_nm=np.arange(400.0, 701.0, 5.0),
        valid=np.ones(weights.shape[:2], bool),
        confidence=np.ones(weights.shape[:2], np.float32),
    )


@pytest.fixture
def table(scene, ball):
    """A grey ball on a wide brown table, seen from above at an angle; its upper edge is before the bright sky."""
    scene.render.resolution_x, scene.render.resolution_y = 120, 64
    scene.cycles.use_denoising = False
    scene.camera.data.lens = 18.0
    scene.camera.location, scene.camera.rotation_euler = (0.0, -4.0, 0.4), (1.44, 0.0, 0.0)
    colour(ball(location=(0.0, 0.0, TABLE_Z_M + RADIUS_M)), 0.35, 0.35, 0.35)
    bpy.context.object.name, bpy.context.object.scale = "Ball", 3 * (RADIUS_M,)
    brown = bpy.data.materials.new("Brown")
    brown.node_tree.nodes.clear()
    shader, output = (
        brown.node_tree.nodes.new(kind) for kind in ("ShaderNodeBsdfDiffuse", "ShaderNodeOutputMaterial")
    )
    shader.name = "Shader"
    brown.node_tree.links.new(shader.outputs[0], output.inputs["Surface"])
    colour(brown, 0.45, 0.38, 0.30)
    bpy.ops.mesh.primitive_plane_add(size=60.0, location=(0.0, 0.0, TABLE_Z_M))
    bpy.context.object.name = "Table"
    bpy.context.object.data.materials.append(brown)
    return scene


def colour(material, *rgb):
    material.node_tree.nodes["Shader"].inputs["Color"].default_value = (*rgb, 1.0)


@pytest.fixture
def photograph(table, extension, light, tmp_path):
    """A plain Cycles render of the scene as it is, (H, W, 3) linear Rec.709."""

    def take(name):
        with ExitStack() as stack:
            settings = stack.enter_context(extension("operators.bridge.pass_settings").pass_settings(table))
            output = extension("operators.bridge.pass_output").pass_output(table, settings.layers)
            render_to = stack.enter_context(output)
            rgb = extension("operators.bridge.light").panorama_rec709(light)
            world = extension("operators.bridge.world").temporary_light(table, *rgb.shape[:2])
            stack.enter_context(world)(rgb)
            settings.set_samples(PHOTO_SAMPLES, 0, PHOTO_SAMPLES)
            model = extension("spectral_probe.model")
            progress = model.Progress(0.0, "The photograph")
            model.finish(render_to(progress, tmp_path / name, ["world"], False))
        return extension("spectral_probe.render.pass_folder").read_pass(tmp_path / name).groups["world"]

    return take


def test_it_looks_like_the_real_one(table, photograph, bridge, extension, light, tmp_path):
    real = photograph("real.exr")
    ball = table.objects["Ball"]
    ball.hide_render = True
    plate = photograph("plate.exr")
    ball.hide_render = False
    table.objects["Table"].is_shadow_catcher = True
    table.cycles.seed = 5  # a photograph has noise of its own
    result = extension("spectral_probe.model").finish(
        bridge.spectral_render(table, light, None, tmp_path / "out", samples=SAMPLES, rgb_twin=False)
    )
    camera_colour = extension("spectral_probe.composite.camera_colour")
    rec709 = extension("spectral_probe.spectra.camera").camera_sensitivities("Rec.709")
    (with_, _), (without, alone) = (
        camera_colour.camera_rgb(picture.xyz.parent, rec709) for picture in (result, result.without)
    )
    shows = extension("spectral_probe.files.objects_exr").read_objects(result.objects)
    made = extension("spectral_probe.composite.differential").differential(
        plate, with_, without, shows, without_alpha=alone
    )
    colorimetry = extension("spectral_probe.spectra.colorimetry")
    to_xyz = np.linalg.inv(colorimetry.xyz_to_rec709(np.eye(3)))
    white = np.percentile(plate @ to_xyz, 98, axis=(0, 1))
    error = colorimetry.delta_e_2000(made.pixels @ to_xyz, real @ to_xyz, white)

    inside = shows.coverage == 1.0
    ground = shows.coverage == 0.0
    shadow = ground & (real[..., 1] < 0.93 * plate[..., 1])
    assert inside.sum() > 300
    assert shadow.sum() > 300
    assert error[inside].mean() <= 1.5
    assert error[shadow].mean() <= 1.0

    away = _distance_on_table(extension, result.xyz.parent, made.pixels.shape[:2])
    far = ground & (away > 10.0 * RADIUS_M) & ~_beside(inside)
    assert (far & np.isfinite(away)).mean() > 0.05
    np.testing.assert_array_equal(made.pixels[far], plate[far])  # bit for bit

    halo = (shows.coverage > 0.0) & (shows.coverage < 1.0) & (alone == 0.0)  # before the sky
    assert halo.sum() > 8
    ratio = made.pixels[halo] / real[halo]
    np.testing.assert_allclose(ratio.mean(), 1.0, atol=0.03)
    np.testing.assert_allclose(ratio, 1.0, atol=0.2)


def _beside(inside):
    """Pixels on or beside the object in the picture, whatever they show."""
    rows, columns = np.indices(inside.shape)
    middle = np.argwhere(inside).mean(0)
    return np.hypot(rows - middle[0], columns - middle[1]) < 1.5 * np.sqrt(inside.sum() / np.pi)


def _distance_on_table(extension, directory, shape):
    """How far from the ball's foot each pixel of the table is, by the render's own camera; the sky is infinitely far."""
    seen = extension("spectral_probe.composite.backplate_file").load_backplate(directory / "backplate.json")
    rows, columns = np.indices(shape) + 0.5
    rays = np.stack([columns, rows], -1) - seen.camera.principal_px
    rays = np.concatenate([rays / seen.camera.focal_px, np.ones((*shape, 1))], -1) @ seen.rotation.T
    down = np.minimum(rays[..., 2], -1e-9)
    foot = seen.position_m[:2] + rays[..., :2] * ((TABLE_Z_M - seen.position_m[2]) / down)[..., None]
    return np.where(rays[..., 2] < 0, np.hypot(*np.moveaxis(foot, -1, 0)), np.inf)

"""Directions against Cycles: a mirrored ball rendered inside a checkerboard at infinity, unwrapped from its own outline."""

import bpy
import cv2
import numpy as np
import pytest

from spectral_probe.geometry.ball import fit_ball, reflect
from spectral_probe.geometry.camera import pixel_rays
from spectral_probe.geometry.frames import camera_to_world
from spectral_probe.geometry.outline import find_ball
from spectral_probe.model import Camera
from spectral_probe.photo.read import read_photograph

SIZE_PX, RADIUS_PX = 1064, 500.0
SQUARES = 12  # around the horizon: 30 degrees each
LEVELS = (0.2, 1.2)
REFLECTANCE = 0.9


def checkerboard_world(scene):
    """Dark and light squares of 30 degrees, as nodes: exact at any resolution. Their colour tells the direction:
    level (0.5 + 0.25 L)."""
    world = bpy.data.worlds.new("Checkerboard")
    scene.world = world
    world.cycles.sampling_method = "NONE"  # mirrors need no importance map
    tree = world.node_tree
    tree.nodes.clear()
    direction = tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"]
    split = tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(direction, split.inputs[0])

    def calculate(operation, *values):
        node = tree.nodes.new("ShaderNodeMath")
        node.operation = operation
        for socket, value in zip(node.inputs, values, strict=False):
            if isinstance(value, float):
                socket.default_value = value
            else:
                tree.links.new(value, socket)
        return node.outputs[0]

    side = 2 * np.pi / SQUARES
    azimuth = calculate("ARCTAN2", split.outputs["Y"], split.outputs["X"])
    elevation = calculate("ARCSINE", split.outputs["Z"])
    index = calculate(
        "ADD",
        *(calculate("FLOOR", calculate("DIVIDE", angle, side)) for angle in (azimuth, elevation)),
    )
    odd = calculate("FLOORED_MODULO", index, 2.0)
    level = calculate("MULTIPLY_ADD", odd, LEVELS[1] - LEVELS[0], LEVELS[0])
    colour = tree.nodes.new("ShaderNodeCombineXYZ")
    for axis, name in enumerate("XYZ"):
        coded = calculate("MULTIPLY_ADD", split.outputs[name], 0.25, 0.5)
        tree.links.new(calculate("MULTIPLY", coded, level), colour.inputs[axis])
    background = tree.nodes.new("ShaderNodeBackground")
    output = tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(colour.outputs[0], background.inputs["Color"])
    tree.links.new(background.outputs[0], output.inputs["Surface"])


def unit_sphere(segments=512, rings=256):
    """A smooth sphere: its facets leave the silhouette within 0.02 pixels. (Blender's own operator takes minutes.)"""
    longitude = np.arange(segments) * 2 * np.pi / segments
    latitude = np.linspace(-np.pi / 2, np.pi / 2, rings + 1)[1:-1]
    ring = np.stack([np.cos(longitude), np.sin(longitude), 0 * longitude], axis=-1)
    points = np.cos(latitude)[:, None, None] * ring
    points[..., 2] = np.sin(latitude)[:, None]
    vertices = np.concatenate([points.reshape(-1, 3), [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]])
    index = np.arange(segments * (rings - 1)).reshape(rings - 1, segments)
    after = np.roll(index, -1, axis=1)
    quads = np.stack([index[:-1], after[:-1], after[1:], index[1:]], axis=-1).reshape(-1, 4)
    south, north = len(vertices) - 2, len(vertices) - 1
    caps = [(b, a, south) for a, b in zip(index[0], after[0], strict=True)]
    caps += [(a, b, north) for a, b in zip(index[-1], after[-1], strict=True)]
    mesh = bpy.data.meshes.new("Sphere")
    mesh.from_pydata(vertices, [], [*quads.tolist(), *caps])
    mesh.shade_smooth()
    return mesh


def mirrored_ball(scene, distance):
    ball = bpy.data.objects.new("Ball", unit_sphere())
    scene.collection.objects.link(ball)
    material = bpy.data.materials.new("Mirror")
    tree = material.node_tree
    tree.nodes.clear()
    glossy = tree.nodes.new("ShaderNodeBsdfGlossy")
    glossy.inputs["Color"].default_value = (*(REFLECTANCE,) * 3, 1.0)
    glossy.inputs["Roughness"].default_value = 0.0
    tree.links.new(glossy.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    ball.data.materials.append(material)
    data = bpy.data.cameras.new("Camera")
    camera = bpy.data.objects.new("Camera", data)
    scene.collection.objects.link(camera)
    scene.camera = camera
    camera.location = (0.0, -distance, 0.0)
    camera.rotation_euler = (np.pi / 2, 0.0, 0.0)  # along +Y: azimuth 0
    focal_px = RADIUS_PX / np.tan(np.arcsin(1.0 / distance))
    data.sensor_width = 36.0
    data.lens = 36.0 * focal_px / SIZE_PX
    return Camera((focal_px, focal_px), (SIZE_PX / 2, SIZE_PX / 2), (SIZE_PX, SIZE_PX))


def photograph(scene, path):
    checkerboard_world(scene)
    render = scene.render
    render.resolution_x = render.resolution_y = SIZE_PX
    # Few samples, all near the middle of their pixel: then a pixel shows one direction, and not the mean of several.
    scene.cycles.samples, scene.cycles.filter_width = 3, 0.75
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.max_bounces = 2
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return read_photograph(path)


def level_of(directions):
    """What the checkerboard multiplies its colour by."""
    side = 2 * np.pi / SQUARES
    azimuth = np.arctan2(directions[..., 1], directions[..., 0])
    elevation = np.arcsin(np.clip(directions[..., 2], -1, 1))
    return np.take(LEVELS, (np.floor(azimuth / side) + np.floor(elevation / side)).astype(int) % 2)


def true_directions(pixels, predicted):
    """World directions (H, W, 3) that the pixels show, and where no square ends near them."""
    level = level_of(predicted).astype(np.float32)
    inside = cv2.erode(level, np.ones((7, 7))) == cv2.dilate(level, np.ones((7, 7)))
    coded = pixels / (REFLECTANCE * level[..., None])
    directions = (coded - 0.5) / 0.25
    return directions / np.linalg.norm(directions, axis=-1, keepdims=True), inside


def angles_deg(one, other):
    return np.degrees(2 * np.arcsin(np.linalg.norm(one - other, axis=-1) / 2))


def orthographic(pixels_px, outline):
    """The formula of the usual tools: parallel rays, and a circle cropped by hand."""
    x, y = np.moveaxis((pixels_px - outline.centre_px) / np.mean(outline.semi_axes_px), -1, 0)
    normal = np.stack([x, y, -np.sqrt(np.maximum(1 - x**2 - y**2, 0))], axis=-1)
    return np.array([0.0, 0.0, 1.0]) - 2 * normal[..., 2:] * normal


@pytest.mark.parametrize(
    "distance", [pytest.param(5.0, marks=pytest.mark.long), 10.0, pytest.param(40.0, marks=pytest.mark.long)]
)
def test_directions_of_a_ball_rendered_in_a_checkerboard(scene, tmp_path, distance, record_property):
    camera = mirrored_ball(scene, distance)
    picture = photograph(scene, tmp_path / "ball.exr")
    outline = find_ball([picture]).outlines[0]
    ball = fit_ball(camera, outline, 1.0)
    columns, rows = np.meshgrid(np.arange(SIZE_PX) + 0.5, np.arange(SIZE_PX) + 0.5)
    places = np.stack([columns, rows], axis=-1)
    mirrored = reflect(ball, pixel_rays(camera, places))
    exact = mirrored.directions @ camera_to_world(0).T
    truth, readable = true_directions(picture.pixels, exact)
    facing = np.degrees(np.arccos(-mirrored.directions @ ball.centre_m / ball.distance_m))
    told_of = mirrored.hit & readable & (facing < 150)
    usual = orthographic(places, outline) @ camera_to_world(0).T
    error, usual_error = (angles_deg(found, truth)[told_of] for found in (exact, usual))
    told = (
        f"d/r {distance:g}, {told_of.sum()} pixels: median {np.median(error):.4f}, p99 {np.percentile(error, 99):.4f} degrees; "
        f"orthographic formula: median {np.median(usual_error):.2f}, p99 {np.percentile(usual_error, 99):.2f}"
    )
    record_property("figures", told)
    assert told_of.sum() > 300_000, told
    assert np.median(error) <= 0.03, told
    assert np.percentile(error, 99) <= 0.3, told
    assert np.median(usual_error) > 20 * np.median(error), told
    assert max(outline.semi_axes_px) == pytest.approx(RADIUS_PX, abs=0.3), told

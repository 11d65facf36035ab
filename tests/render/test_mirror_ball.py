"""Directions against Cycles: a mirrored ball rendered inside a checkerboard at infinity, unwrapped from its own outline."""

import bpy
import cv2
import numpy as np
import pytest

from spectral_probe.geometry.ball import find_reflection, fit_ball, reflect
from spectral_probe.geometry.camera import pixel_rays, project
from spectral_probe.geometry.frames import bearing_to_direction, camera_to_world
from spectral_probe.geometry.outline import detect_outline
from spectral_probe.model import Camera
from spectral_probe.photo.read import read_photograph

SIZE_PX, RADIUS_PX = 1064, 500.0
SQUARES = 24  # around the horizon: 15 degrees each


def checkerboard_world(scene):
    """Dark and light squares of 15 degrees by azimuth and elevation, as nodes: exact at any resolution."""
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
    level = calculate("MULTIPLY_ADD", odd, 0.8, 0.1)
    background = tree.nodes.new("ShaderNodeBackground")
    output = tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(level, background.inputs["Color"])
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
    glossy.inputs["Color"].default_value = (0.9, 0.9, 0.9, 1.0)
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
    scene.cycles.samples = 8
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.max_bounces = 2
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return read_photograph(path)


def corners(ball):
    """Directions (N, 3) of the checkerboard's corners, in the camera's frame, 5 to 150 degrees from the camera."""
    side = 360 / SQUARES
    azimuth, elevation = np.meshgrid(np.arange(0, 360, side), np.arange(-75, 76, side))
    directions = bearing_to_direction(azimuth.ravel(), elevation.ravel()) @ camera_to_world(0)
    facing = np.degrees(np.arccos(-directions @ ball.centre_m / ball.distance_m))
    return directions[(facing > 5) & (facing < 150)]


def angles_deg(one, other):
    return np.degrees(2 * np.arcsin(np.linalg.norm(one - other, axis=-1) / 2))


def orthographic(pixels_px, outline):
    """The formula of the usual tools: parallel rays, and a circle cropped by hand."""
    x, y = ((pixels_px - outline.centre_px) / np.mean(outline.semi_axes_px)).T
    normal = np.stack([x, y, -np.sqrt(np.maximum(1 - x**2 - y**2, 0))], axis=-1)
    return np.array([0.0, 0.0, 1.0]) - 2 * normal[:, 2:] * normal


@pytest.mark.parametrize("distance", [5.0, 10.0, 40.0])
def test_directions_of_a_ball_rendered_in_a_checkerboard(scene, tmp_path, distance, record_property):
    camera = mirrored_ball(scene, distance)
    picture = photograph(scene, tmp_path / "ball.exr")
    outline = detect_outline(picture)
    ball = fit_ball(camera, outline, 1.0)
    truth = corners(ball)
    places, _ = find_reflection(ball, truth)
    start = project(camera, places.astype(float)).astype(np.float32)
    grey = np.clip(picture.pixels.mean(-1) * 255, 0, 255).astype(np.uint8)
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 60, 1e-3)
    found = cv2.cornerSubPix(grey, start[:, None] - 0.5, (5, 5), (-1, -1), criteria)[:, 0] + 0.5

    error = angles_deg(reflect(ball, pixel_rays(camera, found)).directions, truth)
    usual = angles_deg(orthographic(found, outline), truth)
    record_property(
        "figures",
        f"d/r {distance:g}: exact {np.median(error):.3f}, orthographic {np.median(usual):.3f} degrees",
    )
    told = (
        f"d/r {distance:g}, {len(truth)} corners: median {np.median(error):.4f}, p99 {np.percentile(error, 99):.4f} degrees; "
        f"orthographic formula: median {np.median(usual):.2f}, p99 {np.percentile(usual, 99):.2f}"
    )
    record_property("figures", told)
    assert len(truth) > 200
    assert np.median(error) <= 0.03, told
    assert np.percentile(error, 99) <= 0.3, told
    assert np.median(usual) > 20 * np.median(error), told
    assert max(outline.semi_axes_px) == pytest.approx(RADIUS_PX, abs=0.3), told

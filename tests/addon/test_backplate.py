"""The matched camera, its picture and its ground in Blender: where the photograph has something, the render has it too."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import numpy as np
import pytest

type Importer = Callable[[str], ModuleType]


@pytest.fixture
def bridge(in_extension: Importer) -> ModuleType:
    return in_extension("operators.bridge.backplate")


@pytest.fixture
def backplate(in_extension: Importer) -> Any:
    """Nothing simple: oblong pixels, an optical axis off the middle, a tilted camera, a lens that bends."""
    model, composite = in_extension("spectral_probe.model"), in_extension("spectral_probe.composite_model")
    geometry = in_extension("spectral_probe.composite.plate_geometry")
    frames = in_extension("spectral_probe.geometry.frames")
    camera = model.Camera((70.0, 77.0), (37.0, 21.0), (64, 48), (-0.12, 0.03, 1e-3, -2e-3, 0.0))
    return composite.Backplate(
        camera=camera,
        rotation=frames.camera_to_world(30.0, 25.0, 4.0),
        position_m=np.array([-0.38, -0.66, 0.42]),
        photo=Path(),
        photo_size_px=(640, 480),
        frame_px=geometry.rendered_frame(camera),
        ball_centre_m=np.array([0.0, 0.0, 0.1]),
        ball_radius_m=0.1,
        exposure=0.02,
    )


def outline_px(in_extension: Importer, backplate: Any) -> Any:
    """The ball's outline in the frame, (N, 2): the rays that touch it."""
    to_centre = backplate.ball_centre_m - backplate.position_m
    distance = np.linalg.norm(to_centre)
    axis = to_centre / distance
    sine = backplate.ball_radius_m / distance
    across = np.cross(axis, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across)
    up = np.cross(across, axis)
    angle = np.linspace(0.0, 2 * np.pi, 90, endpoint=False)[:, None]
    rim = np.sqrt(1 - sine**2) * axis + sine * (np.cos(angle) * across + np.sin(angle) * up)
    points = backplate.position_m + distance * rim
    return points, in_extension("spectral_probe.composite.plate_geometry").world_to_frame(backplate, points)


def test_blender_sees_points_where_the_photograph_has_them(
    scene: Any, in_extension: Importer, bridge: ModuleType, backplate: Any
) -> None:
    from bpy_extras.object_utils import world_to_camera_view
    from mathutils import Vector

    scene.unit_settings.scale_length = 0.1
    camera = bridge.match_camera(scene, backplate)
    bpy.context.view_layer.update()
    points, expected = outline_px(in_extension, backplate)
    size = np.array([scene.render.resolution_x, scene.render.resolution_y])
    seen = np.array([world_to_camera_view(scene, camera, Vector(point / 0.1))[:2] for point in points])
    np.testing.assert_allclose(np.column_stack([seen[:, 0], 1.0 - seen[:, 1]]) * size, expected, atol=0.01)


def test_the_camera_is_read_back_as_it_was_set(
    scene: Any, in_extension: Importer, bridge: ModuleType, backplate: Any
) -> None:
    scene.unit_settings.scale_length = 0.1
    bridge.match_camera(scene, backplate)
    bpy.context.view_layer.update()
    found = in_extension("operators.bridge.camera_backplate").camera_backplate(scene, backplate.frame_px[2:])
    left, top, width, height = backplate.frame_px
    assert found.camera.size_px == (width, height)
    np.testing.assert_allclose(found.camera.focal_px, backplate.camera.focal_px, rtol=1e-5)
    np.testing.assert_allclose(
        found.camera.principal_px, np.subtract(backplate.camera.principal_px, (left, top)), atol=1e-3
    )
    np.testing.assert_allclose(found.rotation, backplate.rotation, atol=1e-6)
    np.testing.assert_allclose(found.position_m, backplate.position_m, atol=1e-6)


@pytest.mark.parametrize("fit", ["AUTO", "HORIZONTAL", "VERTICAL"])
@pytest.mark.parametrize("size", [(80, 50), (50, 80)])
def test_any_camera_of_blender_is_read(
    scene: Any, in_extension: Importer, fit: str, size: tuple[int, int]
) -> None:
    from bpy_extras.object_utils import world_to_camera_view
    from mathutils import Vector

    camera, render = scene.camera, scene.render
    camera.data.sensor_fit, camera.data.sensor_width, camera.data.sensor_height = fit, 30.0, 20.0
    camera.data.shift_x, camera.data.shift_y = 0.1, -0.07
    render.resolution_x, render.resolution_y = size
    render.pixel_aspect_x, render.pixel_aspect_y = 1.0, 1.3
    bpy.context.view_layer.update()
    found = in_extension("operators.bridge.camera_backplate").camera_backplate(scene, size)
    for point in np.random.default_rng(1).uniform(-1.0, 1.0, (5, 3)):
        x, y, _ = world_to_camera_view(scene, camera, Vector(point))
        local = (point - found.position_m) @ found.rotation
        seen = local[:2] / local[2] * found.camera.focal_px + found.camera.principal_px
        np.testing.assert_allclose(seen, np.array([x, 1.0 - y]) * size, atol=0.01)


def test_a_render_lies_on_the_photographed_ball_and_its_ground_on_the_photographed_ground(
    scene: Any, in_extension: Importer, bridge: ModuleType, backplate: Any, tmp_path: Path
) -> None:
    ground_module = in_extension("spectral_probe.composite.ground")
    scene.render.engine = "CYCLES"
    for thing in [each for each in scene.objects if each.type != "CAMERA"]:
        bpy.data.objects.remove(thing)
    bridge.match_camera(scene, backplate)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64, radius=0.1, location=(0.0, 0.0, 0.1))
    ball = bpy.context.object
    ball.data.shade_smooth()
    glow = bpy.data.materials.new("Glow")
    glow.node_tree.nodes.clear()
    shader = glow.node_tree.nodes.new("ShaderNodeEmission")
    shader.inputs["Color"].default_value = (0.0, 0.0, 1e4, 1.0)
    target = glow.node_tree.nodes.new("ShaderNodeOutputMaterial")
    glow.node_tree.links.new(shader.outputs[0], target.inputs["Surface"])
    ball.data.materials.append(glow)
    ball.visible_diffuse = ball.visible_shadow = False  # the ground is as if it were alone
    width, height = backplate.frame_px[2:]
    rows, columns = np.mgrid[:height, :width]
    pixels = np.dstack([0.1 + 0.6 * columns / width, 0.1 + 0.6 * rows / height, np.full(rows.shape, 0.05)])
    seen = np.ones(rows.shape, bool)
    ground = ground_module.GroundReflectance(
        pixels.astype(np.float32), seen, np.array([0.2, 0.2, 0.2]), np.zeros(3)
    )
    disc = bridge.add_ground(scene, ground, 0.5)
    assert disc.is_shadow_catcher
    disc.is_shadow_catcher = False
    world = scene.world.node_tree.nodes["Background"]
    world.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    world.inputs["Strength"].default_value = 1.0
    image = rendered(scene, tmp_path / "render.exr", in_extension)
    cover = np.clip((image[..., 2] - 1.0) / 1e4, 0.0, 1.0)  # of the sky there is one
    _, outline = outline_px(in_extension, backplate)
    mass = np.array([(cover * (columns + 0.5)).sum(), (cover * (rows + 0.5)).sum()]) / cover.sum()
    polygon = np.vstack([outline, outline[:1]])
    twice_area = polygon[:-1, 0] * polygon[1:, 1] - polygon[1:, 0] * polygon[:-1, 1]
    centroid = (((polygon[:-1] + polygon[1:]) * twice_area[:, None]).sum(0)) / (3 * twice_area.sum())
    np.testing.assert_allclose(mass, centroid, atol=0.05)  # pixels
    assert cover.sum() == pytest.approx(abs(twice_area.sum()) / 2, rel=0.01)
    inner = ground_module.ground_distance(backplate) < 0.4
    on_ground = inner & (cover < 1e-3)
    assert np.count_nonzero(on_ground) > 300
    np.testing.assert_allclose(image[on_ground][:, :2], pixels[on_ground][:, :2], atol=0.02)


def rendered(scene: Any, path: Path, in_extension: Importer) -> Any:
    scene.cycles.samples, scene.cycles.use_denoising = 16, False
    scene.cycles.use_adaptive_sampling = False
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return in_extension("spectral_probe.files.image_exr").read_rgb(path)


def test_a_saved_file_knows_its_photograph_and_a_moved_camera_does_not(
    scene: Any, bridge: ModuleType, backplate: Any, tmp_path: Path
) -> None:
    assert bridge.scene_backplate(scene) is None
    camera = bridge.match_camera(scene, backplate)
    bridge.show_plate(camera, np.full((48, 64, 3), 0.2), backplate)
    bridge.keep_backplate(scene, replace(backplate, photo=tmp_path / "plate.jpg"))
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))
    scene = bpy.context.scene
    found = bridge.scene_backplate(scene)
    assert found.photo == tmp_path / "plate.jpg"
    assert found.camera == backplate.camera
    assert found.frame_px == backplate.frame_px
    background = scene.camera.data.background_images[0].image
    assert tuple(background.size) == backplate.frame_px[2:]
    assert background.packed_file is not None
    scene.camera.location.x += 0.05
    bpy.context.view_layer.update()
    assert bridge.scene_backplate(scene) is None


def test_matching_again_adds_nothing_twice(scene: Any, bridge: ModuleType, backplate: Any) -> None:
    def everything() -> dict[str, int]:
        return {
            name: len(getattr(bpy.data, name))
            for name in ("objects", "cameras", "images", "meshes", "materials")
        }

    def match() -> None:
        camera = bridge.match_camera(scene, backplate)
        bridge.show_plate(camera, np.full((48, 64, 3), 0.2), backplate)
        bridge.add_ground(scene, (0.3, 0.2, 0.1), 0.5)

    match()
    once = everything()
    match()
    assert everything() == once
    assert len(scene.camera.data.background_images) == 1

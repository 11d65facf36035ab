"""A matched photograph in a scene: the camera that took it, its picture behind the camera's view, the ground before it.

What was matched is kept as text in the scene's settings, so that a saved .blend knows its photograph when it is opened again.
"""

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix

from ...spectral_probe.composite.backplate_file import backplate_from, backplate_table
from ...spectral_probe.composite.ground import GroundReflectance, faded
from ...spectral_probe.composite.plate_geometry import at_frame_size, frame_camera, undistorted
from ...spectral_probe.composite_model import BACKPLATE_NAME, Backplate
from ...spectral_probe.files.atomic import written_whole
from ...spectral_probe.files.json_object import UNREADABLE
from ...spectral_probe.photo.samples import linear_to_srgb
from ...spectral_probe.render.frame_record import FrameRecord
from .camera_backplate import camera_backplate, rendered_size

CAMERA_NAME = "Backplate Camera"
GROUND_NAME = "Ground"
PLATE_IMAGE = "Backplate"
REFLECTANCE_IMAGE = "Ground Reflectance"

_SENSOR_MM = 36.0
_FADE = 0.03
"""Share of the picture's width over which the ground's reflectance fades to its mean at the border."""

_SAME_PX = 0.5
"""A camera that sees the picture's corners within this is still the photograph's."""

type Array = np.ndarray[Any, Any]


# ---------------------------------------------------------------- the camera


def match_camera(scene: bpy.types.Scene, backplate: Backplate) -> bpy.types.Object:
    """Give a scene the camera of a backplate, and its resolution; a camera that was made so before is used again.

    Lens, sensor, shift and pixel aspect hold the focal lengths and the principal point; the frame is the undistorted one.
    """
    thing = next((each for each in scene.objects if each.type == "CAMERA" and each.name == CAMERA_NAME), None)
    if thing is None:
        thing = bpy.data.objects.new(CAMERA_NAME, bpy.data.cameras.new(CAMERA_NAME))
        scene.collection.objects.link(thing)
    camera = frame_camera(backplate)
    (width, height), (focal_x, focal_y) = camera.size_px, camera.focal_px
    render, data = scene.render, thing.data
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    render.pixel_aspect_x = max(1.0, focal_y / focal_x)
    render.pixel_aspect_y = max(1.0, focal_x / focal_y)
    render.use_border = False
    data.type, data.sensor_fit, data.sensor_width = "PERSP", "HORIZONTAL", _SENSOR_MM
    data.lens_unit = "MILLIMETERS"
    data.lens = _SENSOR_MM * focal_x / width
    data.shift_x = (width / 2 - camera.principal_px[0]) / width
    data.shift_y = (camera.principal_px[1] - height / 2) / focal_y * focal_x / width
    scale = scene.unit_settings.scale_length
    reach = float(np.linalg.norm(backplate.position_m)) / scale
    data.clip_start, data.clip_end = min(0.1, 0.02 * reach), max(1000.0, 100.0 * reach)
    thing.parent = None
    thing.matrix_world = _blender_pose(backplate, scale)
    scene.camera = thing
    return thing


def _blender_pose(backplate: Backplate, scale: float) -> Matrix:
    """The pose of a camera that looks along -z with y up, lengths in scene units of `scale` metres."""
    pose = np.eye(4)
    pose[:3, :3] = np.asarray(backplate.rotation) * (1.0, -1.0, -1.0)
    pose[:3, 3] = np.asarray(backplate.position_m) / scale
    return Matrix(pose.tolist())


# ---------------------------------------------------------------- kept in the scene


def keep_backplate(scene: bpy.types.Scene, backplate: Backplate) -> None:
    """Keep a matched photograph in the scene's settings."""
    kept = scene.spectral_probe.backplate
    kept.matched = json.dumps(backplate_table(backplate, Path("/")))


def scene_backplate(scene: bpy.types.Scene) -> Backplate | None:
    """The matched photograph of a scene; None where it has none, or its camera is no longer the photograph's.

    Its camera may have been moved or its resolution changed since: then what is rendered does not lie on the photograph.
    """
    kept = scene.spectral_probe.backplate
    if not kept.matched:
        return None
    try:
        backplate = backplate_from(json.loads(kept.matched), Path("/"))
    except UNREADABLE:  # edited by hand, or of another version
        return None
    if kept.plate:  # may be relative to the .blend, which moved together with it
        backplate = replace(backplate, photo=Path(bpy.path.abspath(kept.plate)))
    return backplate if sees_the_same(scene, backplate) else None


def sees_the_same(scene: bpy.types.Scene, backplate: Backplate) -> bool:
    """Whether the scene's camera is that of a backplate, to half a pixel at the corners of what it renders.

    It may render at another size: at a percentage of the resolution, for a quick look.
    """
    size = rendered_size(scene)
    wanted = frame_camera(at_frame_size(backplate, size))
    if scene.camera is None or scene.render.use_border:
        return False
    own = camera_backplate(scene, size)
    if own is None:
        return False
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]) * size
    rays = [
        np.column_stack([(corners - camera.principal_px) / camera.focal_px, np.ones(4)]) @ turn.T
        for camera, turn in ((wanted, backplate.rotation), (own.camera, own.rotation))
    ]
    apart = np.linalg.norm(rays[0] - rays[1], axis=-1).max() * max(wanted.focal_px)
    reach = max(float(np.linalg.norm(backplate.position_m)), 1e-6)
    aside = np.linalg.norm(own.position_m - backplate.position_m) / reach * max(wanted.focal_px)
    return bool(max(apart, aside) < _SAME_PX)


def backplates_of(scene: bpy.types.Scene) -> tuple[Backplate | None, Backplate | None]:
    """What belongs behind a scene's render, its photograph or only its camera: of the whole frame, and of one cut to its border.

    The latter has the size of the whole frame still: `write_backplate` knows that of the render.
    """
    size = rendered_size(scene)
    found = scene_backplate(scene)
    whole = camera_backplate(scene, size) if found is None else at_frame_size(found, size)
    return whole, camera_backplate(scene, size, cut=True)


def write_backplate(record: FrameRecord, size_px: tuple[int, int], directory: Path, output: Path) -> None:
    """Write backplate.json of the frame in a folder to another, by what was kept when it was begun; nothing without one.

    `size_px` is that of its passes; paths are relative to the frame's folder.
    """
    table = record.backplates[size_px != record.frame_px]
    if table is None:
        return
    found = backplate_from(table, directory)
    if size_px != record.frame_px:
        found = replace(
            found, camera=replace(found.camera, size_px=size_px), photo_size_px=size_px,
            frame_px=(0.0, 0.0, *size_px),
        )  # fmt: skip
    with written_whole(output / BACKPLATE_NAME) as temporary:
        temporary.write_text(json.dumps(backplate_table(found, directory), indent=1) + "\n", encoding="utf-8")


# ---------------------------------------------------------------- the picture behind it


def show_plate(camera: bpy.types.Object, linear: Array, backplate: Backplate) -> bpy.types.Image:
    """Show the plate behind a camera's view, as its undistorted frame has it.

    Parameters
    ----------
    camera
        The camera object.
    linear
        (H, W, 3) the plate at the size rendered, linear, 1 = white.
    backplate
        Its camera.
    """
    picture = linear_to_srgb(np.clip(undistorted(linear, backplate), 0.0, 1.0))
    image = packed_image(PLATE_IMAGE, picture)
    data = camera.data
    for shown in [each for each in data.background_images if each.image in (None, image)]:
        data.background_images.remove(shown)
    background = data.background_images.new()
    background.source, background.image = "IMAGE", image
    background.frame_method, background.display_depth, background.alpha = "STRETCH", "BACK", 1.0
    data.show_background_images = True
    return image


def packed_image(name: str, pixels: Array, *, colour_space: str = "sRGB") -> bpy.types.Image:
    """An image datablock of pixels (H, W, 3 or 4), row 0 its top, of 8 bits, packed; one of that name is replaced."""
    known = bpy.data.images.get(name)
    height, width = pixels.shape[:2]
    image = bpy.data.images.new(name, width, height, alpha=True)
    if known is not None:
        known.user_remap(image)
        bpy.data.images.remove(known)
        image.name = name
    image.colorspace_settings.name = colour_space
    whole = np.ones((height, width, 4), np.float32)
    whole[..., : pixels.shape[2]] = pixels
    image.pixels.foreach_set(whole[::-1].ravel())
    image.update()
    image.pack()
    return image


# ---------------------------------------------------------------- the ground


def add_ground(
    scene: bpy.types.Scene,
    reflectance: GroundReflectance | Sequence[float],
    radius_m: float,
    height_m: float = 0.0,
) -> bpy.types.Object:
    """A round ground at the world's origin that catches shadows; one that was added before is replaced.

    Parameters
    ----------
    scene
        The scene.
    reflectance
        From the plate, projected onto the ground by the camera; or one colour (3,), linear Rec.709.
    radius_m
        Of the disc.
    height_m
        Of the ground over the origin.
    """
    scale = scene.unit_settings.scale_length
    mesh = _disc(radius_m / scale)
    ground = next(
        (each for each in scene.objects if each.name == GROUND_NAME and each.is_shadow_catcher), None
    )
    if ground is None:
        ground = bpy.data.objects.new(GROUND_NAME, mesh)
        scene.collection.objects.link(ground)
    else:
        before, ground.data = ground.data, mesh
        if not before.users:
            bpy.data.meshes.remove(before)
    mesh.name = GROUND_NAME
    ground.location = (0.0, 0.0, height_m / scale)
    ground.is_shadow_catcher = True
    ground.display_type = "WIRE"  # or it would hide the photograph where objects are put
    mesh.materials.append(_ground_material(reflectance))
    return ground


def _disc(radius: float, segments: int = 128) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new(GROUND_NAME)
    angles = [2 * math.pi * step / segments for step in range(segments)]
    rim = [(radius * math.cos(angle), radius * math.sin(angle), 0.0) for angle in angles]
    mesh.from_pydata(rim, [], [tuple(range(segments))])
    mesh.update()
    return mesh


def _ground_material(reflectance: GroundReflectance | Sequence[float]) -> bpy.types.Material:
    """Matt, of one colour, or of the plate's where the camera sees it and of the mean elsewhere.

    What the camera sees itself has the plate's colour up to the border; what metals mirror fades to the mean before it.
    """
    material = bpy.data.materials.get(GROUND_NAME) or bpy.data.materials.new(GROUND_NAME)
    tree = material.node_tree
    tree.nodes.clear()
    output, shader = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new("ShaderNodeBsdfDiffuse")
    output.location, shader.location = (300.0, 0.0), (100.0, 0.0)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    if not isinstance(reflectance, GroundReflectance):
        shader.inputs["Color"].default_value = (*_working(reflectance), 1.0)
        return material
    pixels = faded(reflectance, round(_FADE * reflectance.pixels.shape[1]))
    pixels[..., :3] = linear_to_srgb(pixels[..., :3])
    image = packed_image(REFLECTANCE_IMAGE, pixels)
    image.alpha_mode = "CHANNEL_PACKED"  # the colours are not multiplied by it
    place, texture = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeTexImage")
    mixed = tree.nodes.new("ShaderNodeMix")
    place.location, texture.location, mixed.location = (-600.0, 0.0), (-400.0, 0.0), (-100.0, 0.0)
    texture.image, texture.extension = image, "EXTEND"
    mixed.data_type = "RGBA"
    colours = {socket.identifier: socket for socket in mixed.inputs}
    colours["A_Color"].default_value = (*_working(reflectance.mean), 1.0)
    tree.links.new(place.outputs["Window"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], colours["B_Color"])
    path, largest = tree.nodes.new("ShaderNodeLightPath"), tree.nodes.new("ShaderNodeMath")
    path.location, largest.location = (-400.0, 300.0), (-250.0, 150.0)
    largest.operation = "MAXIMUM"
    tree.links.new(path.outputs["Is Camera Ray"], largest.inputs[0])
    tree.links.new(texture.outputs["Alpha"], largest.inputs[1])
    tree.links.new(largest.outputs[0], colours["Factor_Float"])
    result = next(socket for socket in mixed.outputs if socket.identifier == "Result_Color")
    tree.links.new(result, shader.inputs["Color"])
    return material


def _working(rec709: Sequence[float]) -> tuple[float, float, float]:
    """A linear Rec.709 colour in the file's working space."""
    from mathutils import Color

    red, green, blue = Color([float(value) for value in rec709]).from_rec709_linear_to_scene_linear()
    return float(red), float(green), float(blue)

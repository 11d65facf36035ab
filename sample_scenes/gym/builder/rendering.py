"""Cycles renders of the hall: two layers of light (lamps, windows) at every node wavelength."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from .hall import build_ball, build_hall, build_photographer
from .layout import BALL_AT, CAMERA_DISTANCE_M, FOCAL_MM, PICTURE_PX, PRINCIPAL_PX, SENSOR_MM
from .materials import SpectralMaterials
from .spectra import NODES_NM, Array

LAYERS = ("lamps", "windows")
PANORAMA_PX = (256, 128)
PLATE_PX = (720, 480)


@dataclass(frozen=True)
class Gym:
    """The Blender scene: its spectral materials, what stands in the middle, and the photographer."""

    scene: Any
    materials: SpectralMaterials
    ball: list[Any]
    photographer: Any
    writer: Any


def build_scene() -> Gym:
    """A new Blender scene with the hall, set up for exact and additive passes (no clamping, filters or denoising)."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.use_persistent_data = True
    scene.render.compositor_device = "CPU"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = False
    cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces = 8, 3, 3
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
    for layer in LAYERS:
        bpy.context.view_layer.lightgroups.add(name=layer)
    materials = SpectralMaterials()
    build_hall(materials)
    gym = Gym(scene, materials, build_ball(materials), build_photographer(materials), _layer_writer(scene))
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    scene.camera = camera
    return gym


def view_from(gym: Gym, azimuth_deg: float) -> None:
    """Put camera and photographer where they stand for one view of the ball, 0.8 m from its centre."""
    azimuth = np.radians(azimuth_deg)
    forward = np.array([np.sin(azimuth), np.cos(azimuth), 0.0])
    at = np.asarray(BALL_AT) - CAMERA_DISTANCE_M * forward
    camera, lens = gym.scene.camera, gym.scene.camera.data
    camera.location, camera.rotation_euler = at, (np.pi / 2, 0.0, -azimuth)
    lens.type, lens.lens, lens.sensor_width, lens.sensor_fit = "PERSP", FOCAL_MM, SENSOR_MM, "HORIZONTAL"
    lens.shift_x = 0.5 - PRINCIPAL_PX[0] / PICTURE_PX
    lens.shift_y = PRINCIPAL_PX[1] / PICTURE_PX - 0.5
    lens.clip_start = 0.001
    gym.photographer.location, gym.photographer.rotation_euler = (at[0], at[1], 0.0), (0.0, 0.0, -azimuth)
    _show(gym, ball=True, photographer=True)
    gym.scene.render.resolution_x = gym.scene.render.resolution_y = PICTURE_PX


def view_all_round(gym: Gym) -> None:
    """A panorama from the ball's centre, without the ball, its stand and the photographer; column centre +Y, +X right of it."""
    camera = gym.scene.camera
    camera.location, camera.rotation_euler = BALL_AT, (np.pi / 2, 0.0, 0.0)
    camera.data.type, camera.data.panorama_type = "PANO", "EQUIRECTANGULAR"
    camera.data.shift_x = camera.data.shift_y = 0.0  # a lens shift moves panoramas too
    _show(gym, ball=False, photographer=False)
    gym.scene.render.resolution_x, gym.scene.render.resolution_y = PANORAMA_PX


def view_plate(gym: Gym) -> None:
    """A photograph of the hall from its south-west, without the ball: a plate to put rendered objects into."""
    camera, lens = gym.scene.camera, gym.scene.camera.data
    camera.location = (-5.6, -4.3, 1.7)
    camera.rotation_euler = (np.radians(90.0), 0.0, np.radians(-52.0))
    lens.type, lens.lens, lens.sensor_width, lens.shift_x, lens.shift_y = "PERSP", 22.0, 36.0, 0.0, 0.06
    _show(gym, ball=False, photographer=False)
    gym.scene.render.resolution_x, gym.scene.render.resolution_y = PLATE_PX


def _show(gym: Gym, *, ball: bool, photographer: bool) -> None:
    for thing in gym.ball:
        thing.hide_render = not ball
    for part in gym.photographer.children:
        part.hide_render = not photographer


def _layer_writer(scene: Any) -> Any:
    """Compositor nodes that write both layers of light; returned is the File Output node."""
    view_layer = bpy.context.view_layer
    view_layer.cycles.denoising_store_passes = True
    tree = bpy.data.node_groups.new("layers", "CompositorNodeTree")
    scene.compositing_node_group = tree
    rendered = tree.nodes.new("CompositorNodeRLayers")
    rendered.scene = scene
    view_layer.update_render_passes()
    writer = tree.nodes.new("CompositorNodeOutputFile")
    writer.format.media_type, writer.format.file_format = "MULTI_LAYER_IMAGE", "OPEN_EXR_MULTILAYER"
    writer.format.color_depth = "32"
    for layer in LAYERS:
        writer.file_output_items.new("RGBA", layer)
        denoise = tree.nodes.new("CompositorNodeDenoise")
        denoise.name = layer
        for socket, source in (
            ("Image", f"Combined_{layer}"),
            ("Albedo", "Denoising Albedo"),
            ("Normal", "Denoising Normal"),
        ):
            tree.links.new(rendered.outputs[source], denoise.inputs[socket])
        tree.links.new(denoise.outputs["Image"], writer.inputs[layer])
    return writer


def _denoise(gym: Gym, wanted: bool) -> None:
    """Have the layers written denoised (Open Image Denoise with albedo and normals, through the mirror) or as rendered."""
    tree = gym.writer.id_data
    for layer in LAYERS:
        node = tree.nodes[layer]
        source = node.outputs["Image"] if wanted else node.inputs["Image"].links[0].from_socket
        tree.links.new(source, gym.writer.inputs[layer])


def render_layers(gym: Gym, samples: int, told: Callable[[str], None], *, denoise: bool) -> Array:
    """Render what the camera sees now: (2, N, H, W) light of each layer at each node, for a layer of radiance 1.

    Three node wavelengths ride in the R, G, B of one render; the layers are Cycles' light groups. All passes share
    the seed, so what noise is left changes brightness rather than colour.
    """
    gym.scene.cycles.samples = samples
    gym.scene.update_tag()  # with persistent data, Cycles keeps the former sample count without it
    _denoise(gym, denoise)
    parts = []
    for first in range(0, len(NODES_NM), 3):
        told(f"pass {first // 3 + 1} of {len(NODES_NM) // 3}")
        gym.materials.set_wavelengths(NODES_NM[first : first + 3])
        with tempfile.TemporaryDirectory() as folder:
            gym.writer.directory, gym.writer.file_name = folder, "pass"
            with QuietConsole():
                bpy.ops.render.render()
            parts.append(_read_layers(next(Path(folder).glob("*.exr"))))
    return np.maximum(np.concatenate(parts, axis=1), 0.0)


def _read_layers(path: Path) -> Array:
    """(2, 3, H, W) both layers from a multilayer EXR."""
    import OpenEXR

    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = {name: channel.pixels for part in file.parts for name, channel in part.channels.items()}
    return np.stack([np.stack([channels[f"{layer}.{c}"] for c in "RGB"]) for layer in LAYERS])


class QuietConsole:
    """While it is entered, what Blender itself writes to the console goes nowhere."""

    def __enter__(self) -> None:
        self._kept = os.dup(1), os.dup(2)
        with Path(os.devnull).open("w") as nowhere:
            os.dup2(nowhere.fileno(), 1)
            os.dup2(nowhere.fileno(), 2)

    def __exit__(self, *_: object) -> None:
        for stream, kept in enumerate(self._kept, start=1):
            os.dup2(kept, stream)
            os.close(kept)

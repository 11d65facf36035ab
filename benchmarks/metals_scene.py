"""The scene of gold, silver and copper balls that `scene.json` of a reference folder describes, in Blender."""

from __future__ import annotations

import copy
import json
import math
from pathlib import Path
from typing import Any

import bpy
import cv2
import numpy as np
from extension import core
from mathutils import Vector

PANORAMA_HEIGHT = 1024
LIGHTS = ("own", "FL11", "HP1", "FL11+HP1")
"""Light of the scene: as described; all of one lamp's spectrum; or the first in the room and the second in the patches."""

type Array = np.ndarray[Any, Any]


def read_description(folder: Path, *, width: int | None = None, light: str = "own") -> dict[str, Any]:
    """The description of the scene, at another width or in another light if asked for.

    Other light has the luminance of the described one in every direction.
    """
    description = json.loads((folder / "scene.json").read_text())
    own_width, own_height = description["size"]
    if width:
        description["size"] = [width, round(own_height * width / own_width)]
    return description if light == "own" else relit(description, light)


def relit(description: dict[str, Any], light: str) -> dict[str, Any]:
    """The scene under the lamps of `LIGHTS`, with its luminances."""
    room, patches = (*light.split("+"), light)[:2]
    library, colorimetry = core("spectral_probe.spectra.library"), core("spectral_probe.spectra.colorimetry")

    def instead_of(spectrum: Any, lamp: str) -> list[float]:
        other = library.lamp_spectrum(lamp)
        luminances = (colorimetry.spectra_to_xyz(np.asarray(s, float))[1] for s in (spectrum, other))
        return [float(v) for v in other * next(luminances) / next(luminances)]

    changed = copy.deepcopy(description)
    changed["ambient"] = instead_of(description["ambient"], room)
    for patch in changed["patches"]:
        patch["radiance"] = instead_of(patch["radiance"], patches)
    return changed


def read_reference(folder: Path, size: tuple[int, int]) -> Array | None:
    """The reference's XYZ image at a size (width, height), averaged by area; None where pixels do not divide."""
    xyz = np.load(folder / "reference_xyz.npz")["xyz"]
    if xyz.shape[1] % size[0] or xyz.shape[0] % size[1]:
        return None
    return cv2.resize(xyz.astype(np.float64), size, interpolation=cv2.INTER_AREA)


def direction(azimuth_deg: float, elevation_deg: float) -> Array:
    """Unit vector of a compass bearing (clockwise from +Y seen from above) and an elevation."""
    azimuth, elevation = math.radians(azimuth_deg), math.radians(elevation_deg)
    return np.array(
        [
            math.sin(azimuth) * math.cos(elevation),
            math.cos(azimuth) * math.cos(elevation),
            math.sin(elevation),
        ]
    )


def panorama(description: dict[str, Any], height: int = PANORAMA_HEIGHT, fine: int = 4) -> Any:
    """The scene's light, one basis spectrum for the ambient and each patch; edges anti-aliased by supersampling."""
    width, count = 2 * height, 1 + len(description["patches"])
    weights = np.zeros((height, width, count), np.float32)
    weights[..., 0] = 1.0
    azimuths = np.pi * (1.0 - (2.0 * np.arange(width * fine) + 1.0) / (width * fine))
    elevations = np.pi * (0.5 - (np.arange(height * fine) + 0.5) / (height * fine))
    for index, patch in enumerate(description["patches"], 1):
        towards = direction(patch["azimuth_deg"], patch["elevation_deg"])
        horizontal = np.cos(azimuths) * towards[0] + np.sin(azimuths) * towards[1]
        inside = np.empty((height, width), np.float32)
        for row in range(height):  # a strip at a time: the whole would not fit small machines
            angles = elevations[row * fine : (row + 1) * fine, None]
            cosine = np.cos(angles) * horizontal + np.sin(angles) * towards[2]
            covered = cosine > math.cos(math.radians(patch["angular_radius_deg"]))
            inside[row] = covered.reshape(fine, width, fine).mean((0, 2))
        weights[..., index] = inside
        weights[..., 0] *= 1.0 - inside
    bases = np.array([description["ambient"], *(patch["radiance"] for patch in description["patches"])])
    return core("spectral_probe.model").SpectralPanorama(
        weights=weights,
        bases=bases[None],
        basis_index=np.zeros((height, width), np.uint8),
        wavelengths_nm=np.array(description["wavelengths"], float),
        valid=np.ones((height, width), bool),
        confidence=np.ones((height, width), np.float32),
    )


def build_scene(description: dict[str, Any], folder: Path) -> bpy.types.Scene:
    """The described scene in an empty file; the materials' tables are written into a folder."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = description["size"]
    scene.render.resolution_percentage = 100
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.use_denoising = False
    for bounces in ("max_bounces", "diffuse_bounces", "glossy_bounces"):
        setattr(scene.cycles, bounces, 12)

    view = description["camera"]
    camera = bpy.data.cameras.new("Camera")
    camera.sensor_fit, camera.angle_x = "HORIZONTAL", math.radians(view["fov_x_deg"])
    camera_object = bpy.data.objects.new("Camera", camera)
    camera_object.location = view["at"]
    gaze = Vector(view["target"]) - Vector(view["at"])
    camera_object.rotation_euler = gaze.to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(camera_object)
    scene.camera = camera_object

    nm, half = np.array(description["wavelengths"]), description["floor_half_size"]
    floor = bpy.data.meshes.new("Floor")
    floor.from_pydata(
        [(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)], [], [(0, 1, 2, 3)]
    )
    grey = material("Floor", "ShaderNodeBsdfDiffuse")
    grey.spectral_probe.kind = "REFLECTANCE"
    grey.spectral_probe.reflectance_path = table(folder / "floor.csv", nm, description["floor_reflectance"])
    floor.materials.append(grey)
    scene.collection.objects.link(bpy.data.objects.new("Floor", floor))

    for ball in description["balls"]:
        bpy.ops.mesh.primitive_uv_sphere_add(
            segments=256, ring_count=128, radius=ball["radius"], location=ball["at"]
        )
        bpy.ops.object.shade_smooth()
        metal = material(ball["metal"], "ShaderNodeBsdfMetallic")
        metal.node_tree.nodes["Shader"].distribution = "GGX"
        metal.node_tree.nodes["Shader"].inputs["Roughness"].default_value = math.sqrt(ball["ggx_alpha"])
        metal.spectral_probe.kind = "METAL"
        metal.spectral_probe.metal = table(folder / f"{ball['metal']}.csv", nm, ball["n"], ball["k"])
        bpy.context.object.data.materials.append(metal)
    return scene


def material(name: str, shader: str) -> bpy.types.Material:
    """A material of one shader, called "Shader" in its node tree."""
    made = bpy.data.materials.new(name)
    tree = made.node_tree
    tree.nodes.clear()
    node, output = tree.nodes.new(shader), tree.nodes.new("ShaderNodeOutputMaterial")
    node.name = "Shader"
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return made


def table(path: Path, *columns: Any) -> str:
    """Write columns as CSV and return the path."""
    np.savetxt(path, np.column_stack(columns), delimiter=",")
    return str(path)

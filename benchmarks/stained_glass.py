"""A room with coloured walls and stained-glass windows: the default spectral plan against all 61 wavelengths.

A box room, open towards the camera: one wall red, one green, the back wall patterned, a patterned floor; three windows with
panes of red, yellow and green glass, in front of a sky and a low sun; a diffuse, a metal and a clear glass ball; three bounces.
Usage, from the repository:

    .venv/bin/python benchmarks/stained_glass.py [-o out/] [--size 320 200] [--samples 256] [--probe probe.exr]

Prints one JSON object: mean, p99 and largest dE2000 of the default plan and of the RGB render against the 61 wavelengths of
the same samples, after a Gaussian blur of sigma 3 pixels; pictures are kept.
"""

import argparse
import json
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from extension import ROOT, core, load_extension
from mathutils import Vector
from pictures import differences, write_preview, write_sheet

PANES = ("copper-ruby", "silver-stain", "chromium-green")
PATTERN_PX = 64

type Array = np.ndarray[Any, Any]
type Colour = tuple[float, float, float]


def sky(height: int = 256) -> Any:
    """A daylight sky, brighter towards the horizon, a low warm sun behind the windows, and grey ground."""
    colorimetry = core("spectral_probe.spectra.colorimetry")
    daylight, warm = colorimetry.illuminant("D65") / 100, colorimetry.illuminant("A") / 100
    elevation = np.pi * (0.5 - (np.arange(height) + 0.5) / height)
    azimuth = np.pi * (1.0 - 2.0 * (np.arange(2 * height) + 0.5) / (2 * height))
    weights = np.zeros((height, 2 * height, 2), np.float32)
    up = np.where(elevation > 0, 1.0 + 1.5 * np.exp(-4.0 * np.maximum(elevation, 0.0)), 0.15)
    weights[..., 0] = up[:, None]
    towards = (math.radians(90.0), math.radians(38.0))  # +Y is where the windows are
    cosine = np.sin(elevation)[:, None] * math.sin(towards[1]) + np.cos(elevation)[:, None] * math.cos(
        towards[1]
    ) * np.cos(azimuth - towards[0])
    weights[..., 1] = 120.0 * (cosine > math.cos(math.radians(5.0)))
    return core("spectral_probe.model").SpectralPanorama(
        weights=weights,
        bases=np.stack([daylight, warm])[None],
        basis_index=np.zeros((height, 2 * height), np.uint8),
        wavelengths_nm=np.arange(400.0, 701.0, 5.0),
        valid=np.ones((height, 2 * height), bool),
        confidence=np.ones((height, 2 * height), np.float32),
    )


def room() -> bpy.types.Scene:
    """The scene, in an empty file."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces = 6, 3, 3
    cycles.transmission_bounces, cycles.transparent_max_bounces = 6, 8
    _wall(
        "Floor",
        [(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)],
        _pattern("Floor", (0.6, 0.5, 0.4), (0.15, 0.1, 0.3), 8),
    )
    _wall(
        "Ceiling",
        [(-2, -2, 2.6), (-2, 2, 2.6), (2, 2, 2.6), (2, -2, 2.6)],
        _diffuse("White", (0.8, 0.8, 0.8)),
    )
    _wall("Left", [(-2, -2, 0), (-2, 2, 0), (-2, 2, 2.6), (-2, -2, 2.6)], _diffuse("Red", (0.65, 0.06, 0.05)))
    _wall("Right", [(2, -2, 0), (2, -2, 2.6), (2, 2, 2.6), (2, 2, 0)], _diffuse("Green", (0.12, 0.45, 0.1)))
    stone = _pattern("Back", (0.7, 0.65, 0.5), (0.5, 0.3, 0.2), 5)
    openings = [(-1.5, -0.7), (-0.4, 0.4), (0.7, 1.5)]
    low, high, edges = 0.7, 2.2, [-2.0, *(x for pair in openings for x in pair), 2.0]
    for left, right in zip(edges[::2], edges[1::2], strict=True):
        _wall("Pier", _upright(left, right, low, high), stone)
    _wall("Sill", _upright(-2.0, 2.0, 0.0, low), stone)
    _wall("Lintel", _upright(-2.0, 2.0, high, 2.6), stone)
    for (left, right), glass in zip(openings, PANES, strict=True):
        _wall(f"Pane {glass}", _upright(left, right, low, high), _pane(glass))
    _ball("Plaster", (-0.9, 0.2, 0.4), 0.4, _diffuse("Blue", (0.1, 0.2, 0.55)))
    gold = core("operators.bridge.objects").metal_material("Gold", "Au", roughness=0.25)
    _ball("Gold", (0.0, 0.7, 0.4), 0.4, gold)
    _ball("Glass", (0.9, 0.1, 0.4), 0.4, _shader("Clear", "ShaderNodeBsdfGlass", (1.0, 1.0, 1.0)))
    _camera(scene, (0.0, -4.6, 1.4), (0.0, 0.0, 1.15))
    return scene


def _upright(left: float, right: float, low: float, high: float) -> list[tuple[float, float, float]]:
    """A rectangle of the back wall."""
    return [(left, 2, low), (right, 2, low), (right, 2, high), (left, 2, high)]


def _wall(name: str, corners: Sequence[Sequence[float]], material: bpy.types.Material) -> None:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(map(float, corner)) for corner in corners], [], [(0, 1, 2, 3)])
    points = mesh.uv_layers.new().data
    for point, uv in zip(points, [(0, 0), (1, 0), (1, 1), (0, 1)], strict=True):
        point.uv = uv
    mesh.materials.append(material)
    bpy.context.scene.collection.objects.link(bpy.data.objects.new(name, mesh))


def _ball(name: str, at: Sequence[float], radius: float, material: bpy.types.Material) -> None:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48, radius=radius, location=at)
    bpy.ops.object.shade_smooth()
    ball = bpy.context.object
    ball.name = name
    ball.data.materials.append(material)


def _shader(name: str, kind: str, colour: Colour) -> bpy.types.Material:
    material = bpy.data.materials.new(name)
    tree = material.node_tree
    tree.nodes.clear()
    shader, output = tree.nodes.new(kind), tree.nodes.new("ShaderNodeOutputMaterial")
    shader.name = "Shader"
    shader.inputs["Color"].default_value = (*colour, 1.0)
    if "Roughness" in shader.inputs:
        shader.inputs["Roughness"].default_value = 0.0
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def _diffuse(name: str, colour: Colour) -> bpy.types.Material:
    return _shader(name, "ShaderNodeBsdfDiffuse", colour)


def _pane(glass: str) -> bpy.types.Material:
    """A thin pane: straight through, tinted; its colour in nodes is the glass's under D65."""
    colorimetry = core("spectral_probe.spectra.colorimetry")
    transmittance = core("spectral_probe.spectra.glass").glass_transmittance(glass)
    light = colorimetry.illuminant("D65")
    seen = colorimetry.spectra_to_xyz(transmittance * light) / colorimetry.spectra_to_xyz(light)[1]
    colour = np.clip(colorimetry.xyz_to_rec709(seen), 0.0, 1.0)
    pane = _shader(glass, "ShaderNodeBsdfTransparent", tuple(colour.tolist()))
    pane.spectral_probe.kind = "GLASS"
    pane.spectral_probe.glass = glass
    pane.spectral_probe.glass_as = "FILTER"
    pane.spectral_probe.glass_with_surfaces = False
    return pane


def _pattern(name: str, first: Colour, second: Colour, squares: int) -> bpy.types.Material:
    """A diffuse checker in an image texture, colours in linear Rec.709."""
    image = bpy.data.images.new(name, PATTERN_PX, PATTERN_PX, float_buffer=True)
    image.colorspace_settings.name = "Linear Rec.709"
    index = np.arange(PATTERN_PX) * squares // PATTERN_PX
    chosen = ((index[:, None] + index) % 2)[..., None]
    pixels = np.ones((PATTERN_PX, PATTERN_PX, 4), np.float32)
    pixels[..., :3] = np.where(chosen, first, second)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    material = _diffuse(name, first)
    tree = material.node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    tree.links.new(texture.outputs["Color"], tree.nodes["Shader"].inputs["Color"])
    return material


def _camera(scene: bpy.types.Scene, at: Sequence[float], target: Sequence[float]) -> None:
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.lens = 38.0
    camera.location = at
    camera.rotation_euler = (Vector(target) - Vector(at)).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    scene.camera = camera


def main() -> None:
    """Render both plans and compare; prints one JSON object and leaves it, with pictures, in the output folder."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "out" / "stained_glass")
    parser.add_argument("--size", type=int, nargs=2, default=(320, 200), metavar=("WIDTH", "HEIGHT"))
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--probe", type=Path, help="light instead of the built-in sky")
    options = parser.parse_args()
    load_extension()
    cycles, images = core("operators.bridge.cycles"), core("spectral_probe.files.image_exr")
    finish = core("spectral_probe.model").finish
    probe = core("spectral_probe.files.probe_exr").read_probe(options.probe) if options.probe else sky()
    scene = room()
    scene.render.resolution_x, scene.render.resolution_y = options.size
    options.output.mkdir(parents=True, exist_ok=True)
    rendered, results = {}, {}
    for name, passes in (("all", "all"), ("default", None)):
        job = cycles.spectral_render(
            scene,
            probe,
            None,
            options.output / name,
            samples=options.samples,
            passes=passes,
            rgb_twin=not passes,
        )
        result = finish(job)
        rendered[name] = images.read_rgb(result.xyz, ("X", "Y", "Z"))
        results[name] = {
            "passes": result.plan.passes,
            "light_sets": len(set(result.plan.light_sets)),
            "predicted_de2000": result.plan.predicted_de2000,
            "seconds": round(result.seconds_spectral, 1),
            "warnings": list(result.warnings),
        }
    colorimetry = core("spectral_probe.spectra.colorimetry")
    rendered["rgb"] = colorimetry.rec709_to_xyz(images.read_rgb(options.output / "default" / "rgb.exr"))
    scale = 1.0 / np.percentile(rendered["all"][..., 1], 95)
    for name, xyz in rendered.items():
        write_preview(options.output / f"{name}.png", xyz, scale)
    write_sheet(options.output / "sheet.png", rendered, scale)
    results["default against all 61"] = differences(rendered["default"], rendered["all"])
    results["rgb against all 61"] = differences(rendered["rgb"], rendered["all"])
    text = json.dumps(results, indent=2) + "\n"
    (options.output / "stained_glass.json").write_text(text)
    sys.stdout.write(text)


if __name__ == "__main__":
    main()

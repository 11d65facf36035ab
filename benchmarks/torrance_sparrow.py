"""The Torrance-Sparrow nodes in Cycles against eq. 12 integrated in numpy, on balls of gold: the figures of docs/paper.md.

    .venv/bin/python benchmarks/torrance_sparrow.py [-o out/] [--size 96] [--samples 128]

A ball fills the picture, seen without perspective, lit by a smooth light and by a dim room with five lamps of 6 to 12 degrees
radius. Its lobe has the albedo 0.8 times that of gold at every gamma, nothing else reflects. Both take twelve wavelengths, 410
to 685 nm. Stated by rings of viewing angle: Cycles' mean luminance over the paper's, less one; over the ball: RMS difference of
luminance over its mean, and dE2000 (both images blurred by 1 pixel, D65 white at the 95th percentile of the paper's image). The
last column is the Beckmann lobe's own residual (`render.beckmann`). The picture has the paper's balls above Cycles' of each
light, gamma from left to right.
"""

from __future__ import annotations

import argparse
import json
import math
import shutil
import sys
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from extension import ROOT, core, load_extension
from pictures import colour_errors, exposure, write_preview

GAMMAS_DEG = (3.0, 8.0, 15.0, 25.0)
RINGS_DEG = ((0, 30), (30, 50), (50, 70), (70, 82))
ALBEDO = 0.8
LAMPS = ((200, 45, 9, 20), (130, 20, 6, 30), (250, -20, 12, 8), (60, 30, 8, 25), (180, -50, 10, 10))
"""Lamps of the spotty light: bearing, elevation and radius in degrees, weight."""

type Array = np.ndarray[Any, Any]


def plan() -> Any:
    """Four passes of three wavelengths; each stands for five samples of the spectrum."""
    grid = np.arange(400.0, 701.0, 5.0)
    index = np.arange(2, 61, 5).reshape(3, 4).T
    reconstruction = np.zeros((4, 3, 61))
    reconstruction[(*np.indices(index.shape), index)] = 5.0
    return core("spectral_probe.render_model").PassPlan(
        kind="wavelength",
        wavelengths_nm=grid[index],
        reconstruction=reconstruction,
        grid_nm=grid,
        sample_shares=np.ones(4),
        references=(0, 1, 2, 3),
        light_sets=(0,) * 4,
    )


def light(kind: str, height: int = 128) -> Any:
    """A panorama of filament light and daylight, smooth or spotty."""
    frames, library = core("spectral_probe.geometry.frames"), core("spectral_probe.spectra.library")
    directions = frames.panorama_directions(height, 2 * height)
    weights = np.zeros((height, 2 * height, 2), np.float32)
    if kind == "smooth":
        weights[..., 0] = 0.6 + 0.5 * directions[..., 2]
        weights[..., 1] = 0.3 * (1.0 + 0.9 * directions[..., 0])
    else:
        weights[..., 1] = 0.1
        for azimuth, elevation, radius, power in LAMPS:
            towards = frames.bearing_to_direction(azimuth, elevation)
            weights[..., 0] += power * (directions @ towards > math.cos(math.radians(radius)))
    return core("spectral_probe.model").SpectralPanorama(
        weights=weights,
        bases=np.stack([library.planck(2856.0), library.daylight(6500.0)])[None],
        basis_index=np.zeros(weights.shape[:2], np.uint8),
        wavelengths_nm=np.arange(400.0, 701.0, 5.0),
        valid=np.ones(weights.shape[:2], bool),
        confidence=np.ones(weights.shape[:2], np.float32),
    )


def build_scene(size_px: int) -> bpy.types.Scene:
    """A ball of radius 1 that fills the picture of an orthographic camera looking along +Y."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.pixel_filter_type = "CYCLES", "BOX"
    scene.cycles.use_denoising = False
    scene.render.resolution_x = scene.render.resolution_y = size_px
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.0, -5.0, 0.0), (math.pi / 2, 0.0, 0.0)
    camera.data.type, camera.data.ortho_scale = "ORTHO", 2.0
    scene.collection.objects.link(camera)
    scene.camera = camera
    bpy.ops.mesh.primitive_uv_sphere_add(segments=256, ring_count=128)
    bpy.ops.object.shade_smooth()
    return scene


def in_cycles(
    scene: bpy.types.Scene, panorama: Any, folder: Path, samples: int, **parameters: float
) -> Array:
    """XYZ image of the ball with the node group."""
    nodes = core("operators.bridge.torrance_sparrow")
    ball = next(thing for thing in scene.objects if thing.type == "MESH")
    ball.data.materials.clear()
    ball.data.materials.append(nodes.torrance_sparrow_material("Surface", metal="Au", **parameters))
    shutil.rmtree(folder, ignore_errors=True)  # finished passes would be taken over
    job = core("operators.bridge.cycles").spectral_render(
        scene, panorama, plan(), folder, samples=samples, rgb_twin=False
    )
    result = core("spectral_probe.model").finish(job)
    return core("spectral_probe.files.image_exr").read_rgb(result.xyz, ("X", "Y", "Z"))


def figures(cycles: Array, paper: Array) -> dict[str, Any]:
    """How far Cycles' image is from the paper's."""
    size = len(paper)
    across, along = (np.mgrid[:size, :size] + 0.5) / size * 2.0 - 1.0
    sine = np.hypot(across, along)
    rings = {}
    for least, most in RINGS_DEG:
        ring = (sine >= math.sin(math.radians(least))) & (sine < math.sin(math.radians(most)))
        ratio = cycles[ring, 1].mean(dtype=float) / paper[ring, 1].mean()
        rings[f"{least}-{most} deg"] = round(float(ratio) - 1.0, 4)
    ball = sine < math.sin(math.radians(82))
    error = colour_errors(np.where(ball[..., None], cycles, paper), paper, blur_px=1.0)[ball]
    rms = np.sqrt(((cycles - paper)[ball, 1] ** 2).mean()) / paper[ball, 1].mean()
    return {
        "luminance_by_viewing_angle": rings,
        "rms_luminance": round(float(rms), 4),
        "de2000_mean": round(float(error.mean()), 2),
        "de2000_p99": round(float(np.percentile(error, 99)), 2),
    }


def main() -> None:
    """Render all balls; prints one JSON object and leaves it, with the picture, in the output folder."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "out" / "torrance_sparrow")
    parser.add_argument("--size", type=int, default=96, help="pixels across the ball")
    parser.add_argument("--samples", type=int, default=128)
    options = parser.parse_args()
    load_extension()
    options.output.mkdir(parents=True, exist_ok=True)
    reference = core("spectral_probe.render.torrance_sparrow")
    colorimetry = core("spectral_probe.spectra.colorimetry")
    scene = build_scene(options.size)
    results: dict[str, Any] = {}
    rows = []
    for kind in ("smooth", "spotty"):
        panorama, balls = light(kind), []
        for gamma_deg in GAMMAS_DEG:
            gamma = math.radians(gamma_deg)
            lobe = {"beta": ALBEDO * math.log(2.0) / (4.0 * math.pi * gamma**2), "gamma_rad": gamma}
            surface = reference.TorranceSparrowSurface.metal("Au", **lobe)
            radiance = reference.sphere_image(panorama, surface, options.size).radiance
            paper = colorimetry.spectra_to_xyz(radiance * plan().reconstruction.sum((0, 1)))
            cycles = in_cycles(scene, panorama, options.output / "render", options.samples, **lobe)
            fit = core("spectral_probe.render.beckmann").beckmann_alpha(gamma)
            name = f"{kind}, gamma {gamma_deg:g}"
            results[name] = figures(cycles, paper) | {"beckmann_residual": round(fit.residual, 4)}
            balls.append(np.concatenate([paper, cycles]) * exposure(paper))
        rows.append(np.concatenate(balls, axis=1))
    write_preview(options.output / "balls.png", np.concatenate(rows), 1.0)
    text = json.dumps(results, indent=2) + "\n"
    (options.output / "torrance_sparrow.json").write_text(text)
    sys.stdout.write(text)


if __name__ == "__main__":
    main()

"""Peak memory of a spectral render over that of a plain RGB render of the same scene.

    .venv/bin/python benchmarks/render_memory.py FOLDER [-o out/] [--width 1280] [--samples 4] [--panorama 1024]

FOLDER holds the metals' `scene.json`. Each render runs in a process of its own, whose peak resident memory the system tells:
Blender with the scene built and nothing rendered; plain Cycles with the panorama as an ordinary world image; the spectral
render with the plan that it makes itself, and with the 61 wavelengths. The limit is 1.3 times the plain render's peak plus the
images: four floats a pixel of the XYZ image, the RGB image and the picture in Blender, and of the panorama's three layers and
its weights. `stages` is the peak after each stage of the spectral process, which says what needs it.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
from pathlib import Path
from typing import Any

MODES = ("start", "rgb", "spectral", "all")
BYTES_A_PIXEL = 16
IMAGES = 3
"""XYZ, scene-linear RGB, and the image in Blender."""

PANORAMAS = 2
"""The light layers and the probe's weights, beside the world's image that a plain render has, too."""


def peak_mib() -> float:
    """Peak resident memory of this process so far."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / 2**20 if sys.platform == "darwin" else peak / 2**10


def arguments() -> argparse.Namespace:
    """What the command line asks for; `mode` is for the processes started here."""
    root = Path(__file__).resolve().parents[1]
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="folder with scene.json")
    parser.add_argument("-o", "--output", type=Path, default=root / "out" / "render_memory")
    parser.add_argument("--width", type=int, default=1280)
    parser.add_argument("--samples", type=int, default=4)
    parser.add_argument("--panorama", type=int, default=1024, help="height of the panorama in pixels")
    parser.add_argument("--mode", choices=MODES, help=argparse.SUPPRESS)
    return parser.parse_args()


def plain_render(scene: Any, world: Any, folder: Path, samples: int) -> None:
    """What an artist without the extension would do: the panorama as the world's image, one render to EXR."""
    import bpy
    import numpy as np

    height, width = world.shape[:2]
    image = bpy.data.images.new("Panorama", width, height, float_buffer=True, is_data=True)
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = world[::-1]
    image.pixels.foreach_set(pixels.ravel())
    scene.world = bpy.data.worlds.new("World")
    tree = scene.world.node_tree
    tree.nodes.clear()
    texture, background, output = (
        tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexEnvironment", "Background", "OutputWorld")
    )
    texture.image = image
    tree.links.new(texture.outputs[0], background.inputs["Color"])
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    scene.cycles.samples = samples
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = str(folder / "plain.exr")
    bpy.ops.render.render(write_still=True, scene=scene.name)


def measured(options: argparse.Namespace) -> dict[str, float]:
    """Render in this process as `mode` says; the peaks in MiB after each stage."""
    from extension import core, load_extension
    from metals_scene import build_scene, panorama, read_description

    folder = options.output / options.mode
    folder.mkdir(parents=True, exist_ok=True)
    stages = {}
    if options.mode != "rgb":
        stages["imports"] = peak_mib()
    load_extension()
    description = read_description(options.folder, width=options.width)
    scene = build_scene(description, folder)
    stages["scene"] = peak_mib()
    probe = panorama(description, height=options.panorama, fine=1)
    if options.mode == "rgb":
        world = core("operators.bridge.light").panorama_rec709(probe)
        del probe
        plain_render(scene, world, folder, options.samples)
    elif options.mode != "start":
        stages["panorama"] = peak_mib()
        passes = "all" if options.mode == "all" else None
        job = core("operators.bridge.cycles").spectral_render(
            scene, probe, None, folder, samples=options.samples, passes=passes, rgb_twin=False
        )
        for progress in job:
            stages[f"before: {progress.message}"] = peak_mib()
    stages["end"] = peak_mib()
    return {stage: round(mib, 1) for stage, mib in stages.items()}


def in_own_process(mode: str) -> dict[str, float]:
    """The peaks of a process that renders in a mode."""
    command = [sys.executable, *sys.argv, "--mode", mode]
    told = subprocess.run(command, check=True, capture_output=True, text=True)  # noqa: S603  (this script)
    return json.loads(told.stdout.splitlines()[-1])


def main() -> None:
    """Measure all modes; prints one JSON object and leaves it in the output folder."""
    options = arguments()
    if options.mode:
        sys.stdout.write("\n" + json.dumps(measured(options)) + "\n")
        return
    options.output.mkdir(parents=True, exist_ok=True)
    stages = {mode: in_own_process(mode) for mode in MODES}
    peaks = {mode: told["end"] for mode, told in stages.items()}
    size = json.loads((options.folder / "scene.json").read_text())["size"]
    pixels = options.width**2 * size[1] / size[0]
    texels = 2 * options.panorama**2
    images = (IMAGES * pixels + PANORAMAS * texels) * BYTES_A_PIXEL / 2**20
    limit = 1.3 * peaks["rgb"] + images
    results = {
        "peak_mib": peaks,
        "images_mib": round(images, 1),
        "limit_mib": round(limit, 1),
        "spectral_over_rgb": round(peaks["spectral"] / peaks["rgb"], 3),
        "within_limit": {mode: peaks[mode] <= limit for mode in ("spectral", "all")},
        "stages": stages,
    }
    text = json.dumps(results, indent=2) + "\n"
    (options.output / "render_memory.json").write_text(text)
    sys.stdout.write(text)


if __name__ == "__main__":
    main()

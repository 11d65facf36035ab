"""From photographs of a mirrored ball to a spectral render, without a window.

    blender --background --python sample_scenes/batch_render.py -- CAPTURE.toml OUT [--samples N] [--width PIXELS]

The extension must be installed and enabled. OUT gets probe/, render/ with the comparison in it, and scene.blend.
"""

import argparse
import sys
from math import radians
from pathlib import Path

import bpy

# The silver ball stands on the pedestal, which is half a metre high, the copper ball beside it.
OBJECTS = {
    "GOLD_PEDESTAL": (-0.10, 0.05, 0.0),
    "SILVER_BALL": (-0.10, 0.05, 0.5),
    "COPPER_BALL": (0.27, -0.16, 0.0),
}


def main(words: list[str]) -> None:
    """Do it all, each step by the operator that the panels call."""
    parser = argparse.ArgumentParser(prog="batch_render.py", description=__doc__.splitlines()[0])
    parser.add_argument("capture", type=Path, metavar="CAPTURE.toml")
    parser.add_argument("output", type=Path, metavar="OUT")
    parser.add_argument("--samples", type=int, default=32)
    parser.add_argument("--width", type=int, default=512, help="width of the panorama in pixels")
    parser.add_argument(
        "--size", type=int, nargs=2, default=(320, 240), help="width and height of the render"
    )
    arguments = parser.parse_args(words)
    output = arguments.output.resolve()

    scene = new_scene(arguments.size)
    settings = scene.spectral_probe
    bpy.ops.spectral_probe.import_capture(filepath=str(arguments.capture.resolve()))
    settings.probe_directory, settings.render_directory = str(output / "probe"), str(output / "render")
    settings.probe_width, settings.samples = arguments.width, arguments.samples
    bpy.ops.spectral_probe.build_probe()
    bpy.ops.spectral_probe.light_world()
    for kind, location_m in OBJECTS.items():
        scene.cursor.location = location_m
        bpy.ops.spectral_probe.add_object(kind=kind)
    bpy.ops.spectral_probe.render_spectral()
    bpy.ops.spectral_probe.compare()
    bpy.ops.wm.save_as_mainfile(filepath=str(output / "scene.blend"))
    sys.stdout.write(
        f"Probe: {settings.probe.blind_fraction:.1%} of all directions unseen\n"
        f"Render: {settings.render.passes} passes in {settings.render.seconds:.1f} s, "
        f"RGB in {settings.render.rgb_seconds:.1f} s\n"
        f"RGB differs from spectral by dE2000 {settings.comparison.mean_de2000:.2f} on average\n"
    )


def new_scene(size_px: tuple[int, int]) -> bpy.types.Scene:
    """An empty Cycles scene with a camera that looks at the origin from the south."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = size_px
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.05, -1.9, 0.55), (radians(82), 0.0, 0.0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    return scene


if __name__ == "__main__":
    if not hasattr(bpy.types.Scene, "spectral_probe"):
        sys.exit("Install and enable the Spectral Probe extension first.")
    try:
        main(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else [])
    except RuntimeError as report:  # what an operator reports in the window, a script gets so
        sys.stderr.write(f"{report}")
        sys.exit(2)

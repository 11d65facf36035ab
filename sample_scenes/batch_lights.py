"""One scene in the light of several probes, rendered spectrally and in RGB, without a window.

    blender --background --python sample_scenes/batch_lights.py -- SCENE.blend OUT PROBE_FOLDER... [--samples N]

The extension must be installed and enabled. A probe folder is what Build Probe or `spectral-probe probe` wrote. OUT gets a folder
for each, named after it, with the render, the comparison and the scene, and lights.csv with how far RGB is off in each light.
"""

import argparse
import csv
import sys
from pathlib import Path

import bpy


def main(words: list[str]) -> None:
    """Each light in turn, each step by the operator that the panels call."""
    parser = argparse.ArgumentParser(prog="batch_lights.py", description=__doc__.splitlines()[0])
    parser.add_argument("scene", type=Path, metavar="SCENE.blend")
    parser.add_argument("output", type=Path, metavar="OUT")
    parser.add_argument("probes", type=Path, nargs="+", metavar="PROBE_FOLDER")
    parser.add_argument("--samples", type=int, default=32)
    parser.add_argument("--size", type=int, nargs=2, help="width and height, instead of the scene's")
    arguments = parser.parse_args(words)
    output = arguments.output.resolve()
    folders = folders_for(arguments.probes, output)

    rows = []
    for probe, folder in folders.items():
        bpy.ops.wm.open_mainfile(filepath=str(arguments.scene.resolve()), load_ui=False, use_scripts=False)
        settings = prepare(arguments.samples, arguments.size)
        settings.probe_directory, settings.render_directory = str(probe), str(folder)
        bpy.ops.spectral_probe.light_world()
        bpy.ops.spectral_probe.render_spectral()
        bpy.ops.spectral_probe.compare()
        bpy.ops.wm.save_as_mainfile(filepath=str(folder / "scene.blend"), copy=True)
        rows.append(
            (folder.name, settings.render.passes, settings.render.seconds, settings.comparison.mean_de2000)
        )
        sys.stdout.write(
            f"{folder.name}: RGB differs by dE2000 {settings.comparison.mean_de2000:.2f} on average\n"
        )
    with (output / "lights.csv").open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(("light", "passes", "seconds", "mean_de2000"))
        table.writerows(rows)


def folders_for(probes: list[Path], output: Path) -> dict[Path, Path]:
    """A folder in `output` for each probe's folder, named after it; two of one name are numbered."""
    folders: dict[Path, Path] = {}
    for probe in probes:
        path = probe.resolve()
        name = path.parent.name if path.name == "probe" else path.name
        taken = sum(
            folder.name.rpartition("-")[0] == name or folder.name == name for folder in folders.values()
        )
        folders[path] = output / (f"{name}-{taken + 1}" if taken else name)
    return folders


def prepare(samples: int, size_px: list[int] | None) -> bpy.types.PropertyGroup:
    """The open scene's settings for this batch; Cycles alone renders spectrally."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    if size_px is not None:
        scene.render.resolution_x, scene.render.resolution_y = size_px
        scene.render.resolution_percentage = 100
    settings = scene.spectral_probe
    settings.samples = samples
    return settings


if __name__ == "__main__":
    if not hasattr(bpy.types.Scene, "spectral_probe"):
        sys.exit("Install and enable the Spectral Probe extension first.")
    try:
        main(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else [])
    except RuntimeError as report:  # what an operator reports in the window, a script gets so
        sys.stderr.write(f"{report}")
        sys.exit(2)

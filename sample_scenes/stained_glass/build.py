"""Make the picture of the README: gold, silver and copper in the sample's gym, with stained glass before its windows.

    .venv/bin/python sample_scenes/stained_glass/build.py -o out/stained_glass

The output folder gets probe/ (the gym's light), stained.exr (the same behind red, yellow and green glass), render/ (spectral and
RGB), scene.blend and metals.png; the last also goes, as JPEG, where --jpeg says. Started again it goes on where it was.
"""

import argparse
import sys
from pathlib import Path
from typing import Any

import bpy
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "benchmarks"))

from extension import core, load_extension  # noqa: E402  (not before its folder is on the path)

BEARING_DEG = 18.0  # towards the windows: a red, a yellow and a green one stand behind the objects
PANORAMA_WIDTH = 1024
D65 = np.array([0.9505, 1.0, 1.0891])


def main() -> None:
    """Do it all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "out" / "stained_glass")
    parser.add_argument("--size", type=int, nargs=2, default=(880, 500), help="width and height in pixels")
    parser.add_argument("--samples", type=int, default=48)
    parser.add_argument("--probe", type=Path, help="probe.exr of the gym, where there is one already")
    parser.add_argument("--jpeg", type=Path, help="where to write the picture as JPEG too")
    words = parser.parse_args()
    load_extension()
    stained = stained_light(words.output, words.probe)
    render = words.output / "render"
    seconds = render_metals(words.output, render, stained, words.size, words.samples)
    write_picture(words.output / "metals.png", render, stained, words.jpeg)
    sys.stdout.write(
        f"Spectral render {seconds['spectral']:.0f} s, RGB {seconds['rgb']:.0f} s; {words.output}\n"
    )


def stained_light(output: Path, known: Path | None) -> Any:
    """The gym's light behind glass, from its photographs."""
    probe_exr, sample = core("spectral_probe.files.probe_exr"), core("spectral_probe.sample")
    path = known or output / "probe" / "probe.exr"
    if not path.is_file():
        capture = sample.GYM / "capture.toml"
        core("spectral_probe.model").finish(
            core("spectral_probe.commands").probe(capture, path.parent, PANORAMA_WIDTH)
        )
    stained = sample.stained_gym(probe_exr.read_probe(path))
    output.mkdir(parents=True, exist_ok=True)
    probe_exr.write_probe(output / "stained.exr", stained)
    return stained


def render_metals(
    output: Path, directory: Path, light: Any, size_px: tuple[int, int], samples: int
) -> dict[str, float]:
    """Gold pedestal, silver ball and copper ball on a table, spectrally and in RGB; the seconds of each."""
    import json

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    core("operators.bridge.objects").demo_scene(scene, BEARING_DEG)
    scene.render.resolution_x, scene.render.resolution_y = size_px
    bpy.ops.wm.save_as_mainfile(filepath=str(output / "scene.blend"), copy=True, compress=True)
    job = core("operators.bridge.cycles").spectral_render(scene, light, None, directory, samples=samples)
    core("spectral_probe.model").finish(job)
    return dict(json.loads((directory / "report.json").read_text("utf-8"))["seconds"])


def write_picture(path: Path, render: Path, light: Any, jpeg: Path | None) -> None:
    """Both renders denoised alike, in one exposure and white balance, and the light itself."""
    figures, colorimetry = (
        core("spectral_probe.figures.stained_glass"),
        core("spectral_probe.spectra.colorimetry"),
    )
    display, read_xyz = core("spectral_probe.figures.display"), core("spectral_probe.commands").read_xyz
    denoised = core("operators.bridge.denoise").denoised
    panorama = colorimetry.panorama_xyz(light)
    # Halfway: the eye adapts to a room only partly, and lamps and glass keep their own colours.
    white = np.sqrt(panorama.mean((0, 1)) / panorama[..., 1].mean() * D65)
    pictures = [
        colorimetry.adapted_to_d65(denoised(read_xyz(render / name)), white)
        for name in ("xyz.exr", "rgb.exr")
    ]
    exposure = display.exposure_for_white(float(np.percentile(pictures[0][..., 1], 88)))
    key = display.exposure_for_key(panorama[..., 1], light.valid)
    content = figures.StainedGlassSheet(
        display.tone_map(pictures[0], exposure),
        display.tone_map(pictures[1], exposure),
        display.tone_map(colorimetry.adapted_to_d65(panorama, white), key),
        "Gold, silver and copper in the light of a gym with stained glass before its windows, rendered spectrally",
        "The same in RGB",
        "The light, from photographs of a mirrored ball, behind the glass",
    )
    save_figure = core("spectral_probe.figures.style").save_figure
    save_figure(figures.stained_glass_figure(content), path)
    if jpeg is not None:
        from PIL import Image

        Image.open(path).convert("RGB").save(jpeg, quality=88, optimize=True, progressive=True)


if __name__ == "__main__":
    main()

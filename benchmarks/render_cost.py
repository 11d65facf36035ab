"""What the default spectral render costs over one plain Cycles render of the same scene, and how noisy both are.

Two scenes: `metals`, the demo's gold, silver and copper in the light of the sample gym, and `glass`, the room with
stained-glass windows of `stained_glass.py`. For each, in turn, as often as asked: one plain RGB render of the scene (a process
that opens it, switches off what biases, renders and writes an EXR) and one spectral render by the command line
(`spectral-probe render --no-rgb`), whole processes. Usage, from the repository:

    .venv/bin/python benchmarks/render_cost.py [--scenes metals glass] [--size 1280 720] [--samples 128] [--rounds 2]
        [--converged 2048] [-o out/render_cost]

Prints one JSON object: seconds of each process and of rendering alone, their ratios (the figure to quote is the median over
rounds), and with --converged the noise of both renders (`spectral_probe.render.noise`) against renders of the same kind
with so many samples. Pictures are kept. Nothing else should run meanwhile.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from extension import ROOT, core, load_extension
from pictures import write_preview, write_sheet
from stained_glass import room, sky

GYM_WIDTH = 1024

type Array = np.ndarray[Any, Any]

PLAIN = """
import sys, time, json
import bpy
scene_file, image, samples = sys.argv[1:4]
bpy.ops.wm.open_mainfile(filepath=scene_file, load_ui=False, use_scripts=False)
scene = bpy.context.scene
cycles, render = scene.cycles, scene.render
cycles.samples = int(samples)
cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
cycles.use_adaptive_sampling = cycles.use_denoising = cycles.use_fast_gi = False
render.image_settings.file_format = "OPEN_EXR"
render.image_settings.color_depth = "32"
render.filepath = image
start = time.perf_counter()
bpy.ops.render.render(write_still=True)
print(json.dumps({"render": time.perf_counter() - start}))
"""

SPECTRAL = "import sys; from spectral_probe.cli import main; sys.exit(main())"


def prepared(name: str, folder: Path, size: tuple[int, int]) -> tuple[Path, Path]:
    """The scene as a .blend lit by its panorama in RGB, and its probe.exr."""
    folder.mkdir(parents=True, exist_ok=True)
    files, finish = core("spectral_probe.files.probe_exr"), core("spectral_probe.model").finish
    probe = folder / "probe.exr"
    if name == "metals":
        sample = ROOT / "sample_scenes" / "gym" / "capture.toml"
        if not probe.is_file():
            finish(core("spectral_probe.commands").probe(sample, folder, GYM_WIDTH))
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        scene = bpy.context.scene
        core("operators.bridge.objects").demo_scene(scene)
    else:
        files.write_probe(probe, sky())
        scene = room()
    rgb = core("spectral_probe.spectra.colorimetry").panorama_rec709(files.read_probe(probe))
    core("spectral_probe.files.image_exr").write_rgb(folder / "world.exr", rgb)
    core("operators.bridge.world").light_world(scene, folder / "world.exr")
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene_file = folder / "scene.blend"
    scene_file.unlink(missing_ok=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(scene_file), copy=True, compress=True)
    return scene_file, probe


def timed(words: list[str]) -> tuple[float, str]:
    """Seconds of a whole process, and what it printed."""
    start = time.perf_counter()
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONWARNINGS": "ignore"}
    done = subprocess.run(  # noqa: S603  (our own words)
        [sys.executable, *words], cwd=ROOT, env=environment, capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise SystemExit(done.stderr or done.stdout)
    return time.perf_counter() - start, done.stdout


def plain_render(scene: Path, image: Path, samples: int) -> dict[str, float]:
    """Seconds of one RGB render by Cycles: the process, and rendering alone."""
    image.parent.mkdir(parents=True, exist_ok=True)
    process, printed = timed(["-c", PLAIN, str(scene), str(image), str(samples)])
    line = next(line for line in reversed(printed.splitlines()) if line.startswith("{"))
    return {"process": process, **json.loads(line)}


def spectral_render(scene: Path, probe: Path, folder: Path, samples: int) -> dict[str, float]:
    """Seconds of one spectral render by the command line: the process, and rendering alone."""
    words = [str(scene), "--probe", str(probe), "-o", str(folder), "--samples", str(samples), "--no-rgb"]
    for stale in (folder / "passes").glob("*"):  # a finished render would only be read again
        stale.unlink()
    process, _ = timed(["-c", SPECTRAL, "render", *words])
    report = json.loads((folder / "report.json").read_text("utf-8"))
    return {"process": process, "render": report["seconds"]["spectral"]}


def noise_figures(rendered: dict[str, Array], converged: dict[str, Array]) -> dict[str, Any]:
    """Noise of both renders, each against a converged render of its own kind."""
    measure = core("spectral_probe.render.noise").noise
    figures = {kind: asdict(measure(rendered[kind], converged[kind])) for kind in rendered}
    spectral, rgb = figures["spectral"], figures["rgb"]
    return {
        **figures,
        "luminance RMS, spectral over RGB": spectral["luminance_rms"] / rgb["luminance_rms"],
        "chroma p95 over luminance RMS, spectral": spectral["chroma_p95"] / spectral["luminance_rms"],
        "chroma p95 over luminance RMS, RGB": rgb["chroma_p95"] / rgb["luminance_rms"],
    }


def measured(name: str, options: argparse.Namespace) -> dict[str, Any]:
    """All figures of one scene."""
    folder = options.output / name
    scene, probe = prepared(name, folder, tuple(options.size))
    seconds: dict[str, list[dict[str, float]]] = {"rgb": [], "spectral": []}
    for _ in range(options.rounds):
        seconds["rgb"].append(plain_render(scene, folder / "rgb" / "rgb.exr", options.samples))
        seconds["spectral"].append(spectral_render(scene, probe, folder / "spectral", options.samples))
    result: dict[str, Any] = {"seconds": seconds}
    for what in ("process", "render"):
        ratios = [s[what] / r[what] for s, r in zip(seconds["spectral"], seconds["rgb"], strict=True)]
        result[f"spectral over RGB, {what}"] = statistics.median(ratios)
    read = core("spectral_probe.commands").read_xyz
    rendered = {"rgb": read(folder / "rgb" / "rgb.exr"), "spectral": read(folder / "spectral" / "xyz.exr")}
    pictures = dict(rendered)
    if options.converged:
        plain_render(scene, folder / "rgb" / "converged.exr", options.converged)
        spectral_render(scene, probe, folder / "spectral_converged", options.converged)
        converged = {
            "rgb": read(folder / "rgb" / "converged.exr"),
            "spectral": read(folder / "spectral_converged" / "xyz.exr"),
        }
        result["noise"] = noise_figures(rendered, converged)
        pictures |= {f"{kind}_converged": xyz for kind, xyz in converged.items()}
    scale = 1.0 / np.percentile(rendered["spectral"][..., 1], 95)
    write_sheet(folder / "sheet.png", pictures, scale)
    for kind, xyz in pictures.items():
        write_preview(folder / f"{kind}.png", xyz, scale)
    plan = json.loads((folder / "spectral" / "report.json").read_text("utf-8"))
    return {**result, "passes": plan["passes"], "predicted_de2000": plan["predicted_de2000"]}


def main() -> None:
    """Measure; prints one JSON object and leaves it, with pictures, in the output folder."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "out" / "render_cost")
    parser.add_argument("--scenes", nargs="+", choices=("metals", "glass"), default=("metals", "glass"))
    parser.add_argument("--size", type=int, nargs=2, default=(1280, 720), metavar=("WIDTH", "HEIGHT"))
    parser.add_argument("--samples", type=int, default=128)
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument(
        "--converged", type=int, default=0, help="samples of the renders noise is measured against; 0: none"
    )
    options = parser.parse_args()
    options.output = options.output.resolve()
    load_extension()
    results: dict[str, Any] = {"size": list(options.size), "samples": options.samples}
    for name in options.scenes:
        results[name] = measured(name, options)
    text = json.dumps(results, indent=2) + "\n"
    (options.output / "render_cost.json").write_text(text)
    sys.stdout.write(text)


if __name__ == "__main__":
    main()

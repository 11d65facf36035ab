"""Our default spectral render against Mitsuba 3 (`scalar_spectral`) at equal time, on the metals of a reference folder.

    .venv/bin/python benchmarks/mitsuba.py FOLDER --mitsuba-python PYTHON [-o out/] [--samples 64] [--converged 512] [--width 160]

Mitsuba needs a Python of its own: make an environment, `pip install mitsuba numpy` in it, and give its Python. Our render is made
first and its time taken (the passes, the plan and the assembling, without starting Blender or building the scene); Mitsuba then
takes as many samples as fit into that time (`mitsuba_render.py`; without starting or loading either). Both use all cores, so
nothing else should run. Each image is compared with the reference's, and each also with the converged image of its own renderer
(ours: 61 wavelengths), which leaves out what the two scenes differ in. Colour differences are those of `pictures.py`: as
rendered, and after a Gaussian blur of 3 pixels.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

type Array = np.ndarray[Any, Any]

SCRIPT = Path(__file__).with_name("mitsuba_render.py")


def arguments() -> argparse.Namespace:
    """What the command line asks for."""
    root = Path(__file__).resolve().parents[1]
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="folder with scene.json and reference_xyz.npz")
    parser.add_argument(
        "--mitsuba-python", default=sys.executable, help="a Python that has Mitsuba 3 and numpy"
    )
    parser.add_argument("-o", "--output", type=Path, default=root / "out" / "mitsuba")
    parser.add_argument("--samples", type=int, default=64, help="samples of our render")
    parser.add_argument("--converged", type=int, default=512, help="samples of our converged image")
    parser.add_argument(
        "--mitsuba-converged", type=int, default=4096, help="samples of Mitsuba's converged image"
    )
    parser.add_argument("--width", type=int, help="width of the pictures; default: the scene's own")
    return parser.parse_args()


def require_mitsuba(python: str) -> None:
    """End with what to do where that Python has no Mitsuba."""
    try:
        found = subprocess.run(  # noqa: S603  (the Python that the user names)
            [python, "-I", "-c", "import mitsuba, numpy"], check=False, capture_output=True
        )
        missing = found.returncode != 0
    except OSError:
        missing = True
    if missing:
        sys.exit(
            f"{python} cannot import mitsuba: make an environment, `pip install mitsuba numpy` in it, and name its "
            "Python with --mitsuba-python."
        )


def in_mitsuba(python: str, scene: Path, output: Path, *words: str) -> dict[str, Any]:
    """Image, seconds and samples of a render in Mitsuba."""
    subprocess.run([python, "-I", str(SCRIPT), str(scene), str(output), *words], check=True)  # noqa: S603  (as above)
    with np.load(output) as stored:
        return {
            "xyz": stored["xyz"],
            "seconds": float(stored["seconds"]),
            "samples": int(stored["samples"]),
            "version": str(stored["version"]),
        }


def in_cycles(scene: Any, probe: Any, folder: Path, samples: int, passes: Any) -> tuple[Array, float]:
    """XYZ image of ours and the seconds from the call to the finished image."""
    from extension import core

    shutil.rmtree(folder, ignore_errors=True)  # finished passes would be taken over
    start = time.perf_counter()
    job = core("operators.bridge.cycles").spectral_render(
        scene, probe, None, folder, samples=samples, passes=passes, rgb_twin=False
    )
    result = core("spectral_probe.model").finish(job)
    seconds = time.perf_counter() - start
    return core("spectral_probe.files.image_exr").read_rgb(result.xyz, ("X", "Y", "Z")), seconds


def main() -> None:
    """Render and compare; prints one JSON object and leaves it, with pictures, in the output folder."""
    options = arguments()
    require_mitsuba(options.mitsuba_python)
    from extension import load_extension
    from metals_scene import build_scene, panorama, read_description, read_reference
    from pictures import differences, exposure, write_sheet

    load_extension()
    options.output.mkdir(parents=True, exist_ok=True)
    description = read_description(options.folder, width=options.width)
    described = options.output / "scene.json"
    described.write_text(json.dumps(description))
    scene, probe = build_scene(description, options.output), panorama(description)
    reference = read_reference(options.folder, tuple(description["size"]))

    in_cycles(scene, probe, options.output / "warm_up", 1, 3)  # loads Cycles' kernels and our data
    ours, seconds = in_cycles(scene, probe, options.output / "spectral", options.samples, None)
    python, output = options.mitsuba_python, options.output
    theirs = in_mitsuba(python, described, output / "mitsuba.npz", "--seconds", f"{seconds:.3f}")
    scene.cycles.seed = 1
    own_truth, _ = in_cycles(scene, probe, output / "converged", options.converged, "all")
    words = ("--samples", str(options.mitsuba_converged), "--seed", "1")
    their_truth = in_mitsuba(python, described, output / "mitsuba_converged.npz", *words)["xyz"]

    results: dict[str, Any] = {
        "size": description["size"],
        "seconds": {"spectral_probe": round(seconds, 2), "mitsuba": round(theirs["seconds"], 2)},
        "samples": {"spectral_probe": options.samples, "mitsuba": theirs["samples"]},
        "mitsuba_version": theirs["version"],
        "converged_images_differ": differences(own_truth, their_truth),
    }
    for name, xyz, truth in (("spectral_probe", ours, own_truth), ("mitsuba", theirs["xyz"], their_truth)):
        truths = {"against_own_converged": truth} | (
            {} if reference is None else {"against_reference": reference}
        )
        results[name] = {
            f"{against}, {label}": differences(xyz, compared, blur)
            for against, compared in truths.items()
            for label, blur in (("as rendered", 0.0), ("blurred", 3.0))
        }
    pictures = {"Spectral Probe": ours, "Mitsuba 3": theirs["xyz"], "61, converged": own_truth}
    pictures |= {} if reference is None else {"reference": reference}
    write_sheet(output / "side_by_side.png", pictures, exposure(own_truth))
    text = json.dumps(results, indent=2) + "\n"
    (output / "mitsuba.json").write_text(text)
    sys.stdout.write(text)


if __name__ == "__main__":
    main()

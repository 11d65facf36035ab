"""Gold, silver and copper balls against an independent spectral renderer, and against our own 61 wavelengths.

Renders `scene.json` of a reference folder by the 61-wavelength plan and by light-basis plans, and compares the XYZ images with
`reference_xyz.npz` and with each other. Usage, from the repository:

    .venv/bin/python benchmarks/metals_reference.py FOLDER [-o out/] [--samples 64] [--passes 4 5 7] [--light FL11+HP1]
        [--converged 512] [--width 160]

`--light` puts spiky lamps into the same scene at the same luminances (there is no reference image then): all light of FL11 or
HP1, or the room in FL11 and the patches in HP1. `--converged` renders the 61 wavelengths once more with that many samples and
another seed, and compares all others with it. Colour differences are taken after a Gaussian blur of sigma 3 pixels on both
images; the white is D65 with Y = 1 at the reference's 95th percentile, and values are clipped at 3.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from pathlib import Path
from typing import Any

import numpy as np
from extension import ROOT, core, load_extension
from metals_scene import LIGHTS, build_scene, panorama, read_description, read_reference
from pictures import differences, exposure, write_preview, write_sheet

type Array = np.ndarray[Any, Any]


def arguments() -> argparse.Namespace:
    """What the command line asks for."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="folder with scene.json and reference_xyz.npz")
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "out" / "metals_reference")
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument(
        "--passes",
        type=int,
        nargs="*",
        default=[0],
        help="numbers of light-basis passes to try; 0: the default plan",
    )
    parser.add_argument("--no-reference-plan", action="store_true", help="skip the 61 wavelengths")
    parser.add_argument("--light", choices=LIGHTS, default="own")
    parser.add_argument("--converged", type=int, metavar="SAMPLES", help="samples of our own converged image")
    parser.add_argument("--width", type=int, help="width of the pictures; default: the scene's own")
    return parser.parse_args()


def rendered(scene: Any, probe: Any, folder: Path, **words: Any) -> tuple[Any, Array]:
    """A spectral render into an empty folder: its result and its XYZ image."""
    shutil.rmtree(folder, ignore_errors=True)  # finished passes would be taken over
    job = core("operators.bridge.cycles").spectral_render(scene, probe, None, folder, **words)
    result = core("spectral_probe.model").finish(job)
    return result, core("spectral_probe.files.image_exr").read_rgb(result.xyz, ("X", "Y", "Z"))


def main() -> None:
    """Render and compare; prints one JSON object and leaves it, with pictures, in the output folder."""
    options = arguments()
    load_extension()
    options.output.mkdir(parents=True, exist_ok=True)
    description = read_description(options.folder, width=options.width, light=options.light)
    scene, probe = build_scene(description, options.output), panorama(description)

    references: dict[str, Array] = {}
    stored = read_reference(options.folder, tuple(description["size"]))
    if options.light == "own" and stored is not None:
        references["against_reference"] = stored
    results: dict[str, Any] = {
        "light": options.light,
        "size": description["size"],
        "samples": options.samples,
    }
    if options.converged:
        scene.cycles.seed = 1
        _, references["against_own_61"] = rendered(
            scene,
            probe,
            options.output / "converged",
            samples=options.converged,
            passes="all",
            rgb_twin=False,
        )
        scene.cycles.seed = 0
    pictures = {
        "reference" if name == "against_reference" else "61, converged": xyz
        for name, xyz in references.items()
    }
    plans: list[int | str] = [*([] if options.no_reference_plan else ["all"]), *options.passes]
    for passes in plans:
        folder = options.output / f"passes_{passes}"
        result, xyz = rendered(
            scene, probe, folder, samples=options.samples, passes=passes, rgb_twin=passes == 0
        )
        pictures["61 wavelengths" if passes == "all" else f"{result.plan.passes} passes"] = xyz
        results[str(passes)] = {
            "passes": result.plan.passes,
            "kind": result.plan.kind,
            "seconds": round(result.seconds_spectral, 2),
            "seconds_rgb": result.seconds_rgb,
            "predicted_de2000": result.plan.predicted_de2000,
            "predicted_cost": result.plan.predicted_cost,
            **{name: differences(xyz, reference) for name, reference in references.items()},
        }
        if passes == "all":
            references.setdefault("against_own_61", xyz)
    scale = exposure(next(iter(pictures.values())))
    for name, xyz in pictures.items():
        write_preview(options.output / f"{name.replace(' ', '_')}.png", xyz, scale)
    write_sheet(options.output / "side_by_side.png", pictures, scale)
    text = json.dumps(results, indent=2) + "\n"
    (options.output / "metals_reference.json").write_text(text)
    sys.stdout.write(text)


if __name__ == "__main__":
    main()

"""How time and peak memory grow with the panorama, the views, the render's size and the frames.

    .venv/bin/python benchmarks/scale.py [-o out/scale] [--only panorama views render frames] [--largest 16384]
    .venv/bin/python benchmarks/scale.py --plot out/scale/scale.json -o docs    (draws again)

Every point runs in a process of its own, whose peak resident memory the system tells (`ru_maxrss`). What is measured:

- panorama: the verb `probe` on the bundled gym, three views, all its files, for widths 512 ... 16384;
- views: the same at 2048, with the gym's views once, twice and more often over;
- render: `combine`'s work on made-up passes, so that no time of Cycles enters: 640 x 360 ... 3840 x 2160, with all 61 bands,
  of 21 passes, and of five of which four are ratios;
- frames: that of 640 x 360 with 21 passes, 1 ... 16 times in one process.

`seconds` are those of the whole process. `seconds_fixed` of them do not depend on what is varied, and are measured apart: for
panoramas imports, photographs, bases and registration; for views and renders imports and bases. Exponents are fitted by least
squares to the logarithms of `seconds - seconds_fixed`; memory is fitted as a straight line.
"""

from __future__ import annotations

import argparse
import csv
import json
import resource
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

START = time.perf_counter()
ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

WIDTHS = (512, 1024, 2048, 4096, 8192, 16384)
VIEW_WIDTH = 2048
VIEWS = (1, 2, 3, 6, 9)
RENDERS = ((640, 360), (960, 540), (1280, 720), (1920, 1080), (2560, 1440), (3840, 2160))
FRAMES = (1, 2, 4, 8, 16)
LIMIT_GB = 8.0
KINDS = ("panorama", "views", "render 21", "render 5", "frames")
_FIXED_STAGES = ("spectra", "photographs", "registration")


def peak_gb() -> float:
    """Peak resident memory of this process so far."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak * (1 if sys.platform == "darwin" else 1024) / 1e9


# ---------------------------------------------------------------- points, each in its own process


def probe_point(kind: str, width: int, views: int, folder: Path) -> dict[str, Any]:
    """The verb `probe`, with all its files."""
    from spectral_probe.files.capture import load_capture
    from spectral_probe.model import finish
    from spectral_probe.probe import build_probe, write_outputs

    imports = time.perf_counter() - START
    capture = load_capture(ROOT / "sample_scenes" / "gym" / "capture.toml")
    repeated = [capture.views[number % len(capture.views)] for number in range(views)]
    probe = finish(build_probe(replace(capture, views=tuple(repeated)), width))
    finish(write_outputs(probe, folder))
    stages = json.loads((folder / "report.json").read_text())["seconds"]
    size = sum(file.stat().st_size for file in folder.iterdir())
    fixed = _FIXED_STAGES if kind == "panorama" else ("spectra",)
    return {
        "seconds_fixed": imports + sum(stages[name] for name in fixed),
        "stages": stages,
        "bytes_written": size,
    }


def plan_of(kind: str) -> tuple[Any, Any]:
    """A plan and its steps: 21 passes of three wavelengths, or five of which four are ratios of the first."""
    import numpy as np

    from spectral_probe.render.pass_folder import render_steps
    from spectral_probe.render.plan import reference_plan
    from spectral_probe.spectra.grid import WAVELENGTHS_NM

    plan = reference_plan()
    if kind == "5":
        nodes = np.linspace(430.0, 650.0, 5)
        weights = np.stack([np.interp(WAVELENGTHS_NM, nodes, unit) for unit in np.eye(5)])
        plan = replace(
            plan,
            kind="light-basis",
            wavelengths_nm=np.repeat(nodes[:, None], 3, axis=1),
            reconstruction=weights[:, None, :] * np.ones((1, 3, 1)),
            sample_shares=np.array([1.0, 0.125, 0.125, 0.125, 0.125]),
            references=(0,) * 5,
            light_sets=(0,) * 5,
            interpolation=weights,
        )
    return plan, render_steps(plan, 64)


def make_passes(kind: str, width: int, height: int, folder: Path) -> int:
    """Made-up passes as Blender leaves them, uncompressed float; returns their bytes."""
    import numpy as np
    import OpenEXR

    from spectral_probe.files.image_exr import write_rows

    names = [f"0.world.{letter}" for letter in "RGB"]
    guide = (
        [f"0.guide albedo.{c}" for c in "RGB"] + [f"0.guide normal.{c}" for c in "XYZ"] + ["0.guide index.V"]
    )

    def rows_of(rows: slice, wanted: list[str], number: int) -> dict[str, Any]:
        rng = np.random.default_rng([number, rows.start])
        shape = (rows.stop - rows.start, width)
        return {name: rng.exponential(size=shape).astype(np.float32) for name in wanted}

    folder.mkdir(parents=True, exist_ok=True)
    for number, step in enumerate(plan_of(kind)[1]):
        wanted = names + (guide if step.guide else [])
        write_rows(
            folder / f"{step.name}.exr",
            (height, width),
            lambda rows, wanted=wanted, number=number: rows_of(rows, wanted, number),
            {"compression": OpenEXR.NO_COMPRESSION},
        )
    return sum(file.stat().st_size for file in folder.iterdir())


def combine_point(kind: str, folder: Path, frames: int) -> dict[str, Any]:
    """What `combine` does with the passes in a folder, all 61 bands, some times over."""
    from spectral_probe.render.assemble import assemble
    from spectral_probe.render.outputs import bands_wanted, output_settings, write_outputs
    from spectral_probe.render.pass_folder import read_pass

    plan, steps = plan_of(kind)
    settings = output_settings(spectral=True)
    fixed = time.perf_counter() - START
    written = folder / "written"
    for _ in range(frames):
        assembled = assemble(
            plan,
            steps,
            lambda step: read_pass(folder / f"{step.name}.exr"),
            bands_nm=bands_wanted(plan, settings),
        )
        written.mkdir(exist_ok=True)
        files = write_outputs(written, plan, assembled, settings)
        size = sum(file.stat().st_size for file in files.values())
        shutil.rmtree(written)
    return {"seconds_fixed": fixed, "bytes_written": size * frames}


def point(options: argparse.Namespace) -> dict[str, Any]:
    """Measure one point in this process."""
    width, height, views, frames = options.size
    kind = options.point
    if kind.startswith("make"):
        return {"bytes": make_passes(kind.split()[1], width, height, options.output)}
    if kind in ("panorama", "views"):
        told = probe_point(kind, width, views, options.output)
    else:
        told = combine_point(kind.split()[1], options.output, frames)
    seconds = time.perf_counter() - START
    used = resource.getrusage(resource.RUSAGE_SELF)
    processor = round(used.ru_utime + used.ru_stime, 2)
    return {
        "seconds": round(seconds, 2),
        "seconds_processor": processor,
        "peak_gb": round(peak_gb(), 3),
        **told,
    }


def in_own_process(kind: str, size: tuple[int, int, int, int], folder: Path) -> dict[str, Any]:
    """The numbers of a point."""
    words = ["--point", kind, "--size", *map(str, size), "-o", str(folder)]
    told = subprocess.run(  # noqa: S603  (this script)
        [sys.executable, str(Path(__file__).resolve()), *words], check=True, stdout=subprocess.PIPE, text=True
    )
    return json.loads(told.stdout.splitlines()[-1])


# ---------------------------------------------------------------- all points


def probe_rows(kind: str, points: list[tuple[int, int]], scratch: Path) -> Iterator[dict[str, Any]]:
    """Rows of the table for probes of (width, views)."""
    for width, views in points:
        told = in_own_process(kind, (width, width // 2, views, 1), scratch)
        shutil.rmtree(scratch)
        stages = told.pop("stages")
        amount = views if kind == "views" else width * width // 2
        row = {"kind": kind, "width": width, "height": width // 2, "views": views, "amount": amount, **told}
        yield row | {f"seconds_{name}": value for name, value in stages.items()}


def combine_rows(
    kind: str, plan: str, points: list[tuple[int, int, int]], scratch: Path
) -> Iterator[dict[str, Any]]:
    """Rows for combines of (width, height, frames)."""
    for width, height, frames in points:
        made = in_own_process(f"make {plan}", (width, height, 0, 0), scratch)
        told = in_own_process(f"combine {plan}", (width, height, 0, frames), scratch)
        shutil.rmtree(scratch)
        amount = frames if kind == "frames" else width * height
        row = {"kind": kind, "width": width, "height": height, "frames": frames, "amount": amount}
        yield row | {**told, "bytes_read": made["bytes"] * frames}


def tell(row: dict[str, Any]) -> None:
    """One line for whoever waits."""
    size = f"{row['width']} x {row['height']}, {row.get('views', '-')} views, {row.get('frames', 1)} frames"
    sys.stdout.write(f"{row['kind']:10s} {size}: {row['seconds']:.1f} s, {row['peak_gb']:.2f} GB\n")
    sys.stdout.flush()


def measured(options: argparse.Namespace) -> Iterator[dict[str, Any]]:
    """All rows that were asked for, one after the other."""
    scratch = options.output / "scratch"
    if "panorama" in options.only:
        widths = [width for width in WIDTHS if width <= options.largest]
        yield from probe_rows("panorama", [(width, 3) for width in widths], scratch)
    if "views" in options.only:
        yield from probe_rows("views", [(VIEW_WIDTH, views) for views in VIEWS], scratch)
    if "render" in options.only:
        for plan in ("21", "5"):
            yield from combine_rows(f"render {plan}", plan, [(*size, 1) for size in RENDERS], scratch)
    if "frames" in options.only:
        yield from combine_rows("frames", "21", [(*RENDERS[0], count) for count in FRAMES], scratch)


def fitted(rows: list[dict[str, Any]]) -> dict[str, dict[str, float]]:
    """For each kind the exponent of time over the amount, and the line of memory: GB at nothing, and bytes a unit."""
    import numpy as np

    found = {}
    for kind in dict.fromkeys(row["kind"] for row in rows):
        own = [row for row in rows if row["kind"] == kind]
        if len(own) < 2:
            continue
        amount = np.array([row["amount"] for row in own], float)
        seconds = np.array([row["seconds"] - row["seconds_fixed"] for row in own])
        memory = np.array([row["peak_gb"] for row in own])
        exponent = np.polyfit(np.log(amount), np.log(np.maximum(seconds, 1e-3)), 1)[0]
        slope, start = np.polyfit(amount, memory, 1)
        found[kind] = {
            "exponent": round(float(exponent), 3),
            "exponent_largest_two": round(
                float(np.log(seconds[-1] / seconds[-2]) / np.log(amount[-1] / amount[-2])), 3
            ),
            "memory_start_gb": round(float(start), 3),
            "memory_bytes_a_unit": round(float(slope * 1e9), 2),
            "largest_peak_gb": float(memory.max()),
        }
    return found


def draw(rows: list[dict[str, Any]], fits: dict[str, dict[str, float]], path: Path) -> None:
    """Time above, memory below, a column for each kind."""
    from matplotlib.figure import Figure

    kinds = list(fits)
    figure = Figure(figsize=(2.6 * len(kinds), 4.6), layout="constrained")
    axes = figure.subplots(2, len(kinds), squeeze=False)
    units = {"panorama": "million texels", "views": "views", "frames": "frames"}
    for column, kind in enumerate(kinds):
        own = [row for row in rows if row["kind"] == kind]
        unit = units.get(kind, "million pixels")
        amount = [row["amount"] / (1e6 if unit.startswith("million") else 1) for row in own]
        upper, lower = axes[:, column]
        upper.loglog(amount, [row["seconds"] - row["seconds_fixed"] for row in own], "o-", color="#2a6f97")
        upper.set_title(f"{kind}: exponent {fits[kind]['exponent']:.2f}", fontsize=9)
        lower.semilogx(amount, [row["peak_gb"] for row in own], "o-", color="#a4508b")
        lower.axhline(LIMIT_GB, color="0.6", linewidth=1, linestyle="--")
        lower.set_ylim(0, LIMIT_GB * 1.1)
        lower.set_xlabel(unit, fontsize=8)
        for one in (upper, lower):
            one.tick_params(labelsize=7)
            one.grid(alpha=0.25)
            readable(one.xaxis, amount)
        readable(upper.yaxis, [row["seconds"] for row in own])
    axes[0, 0].set_ylabel("seconds, start-up taken off", fontsize=8)
    axes[1, 0].set_ylabel("peak memory in GB", fontsize=8)
    figure.savefig(path, dpi=110)


def readable(axis: Any, values: list[float]) -> None:
    """Plain numbers along a logarithmic axis: 1, 10, 100 ..., and 2 and 5 between them where there is room."""
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    wide = max(values) / min(values) > 100
    axis.set_major_locator(LogLocator(subs=(1.0,) if wide else (1.0, 2.0, 5.0)))
    axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def arguments() -> argparse.Namespace:
    """What the command line asks for; `point` and `size` are for the processes started here."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "out" / "scale")
    choices = ("panorama", "views", "render", "frames")
    parser.add_argument("--only", nargs="+", choices=choices, default=list(choices))
    parser.add_argument("--largest", type=int, default=WIDTHS[-1], help="widest panorama")
    parser.add_argument("--plot", type=Path, nargs="+", help="scale.json files to draw, without measuring")
    parser.add_argument("--point", help=argparse.SUPPRESS)
    parser.add_argument("--size", nargs=4, type=int, help=argparse.SUPPRESS)
    return parser.parse_args()


def main() -> None:
    """Measure what was asked for, and leave scale.csv, scale.json and scale.png in the output folder."""
    options = arguments()
    if options.point:
        sys.stdout.write("\n" + json.dumps(point(options)) + "\n")
        return
    options.output.mkdir(parents=True, exist_ok=True)
    rows = [row for path in options.plot or () for row in json.loads(path.read_text())["points"]]
    if not rows:
        for row in measured(options):  # what is measured is kept, whatever becomes of the rest
            tell(row)
            rows.append(row)
            save(rows, options.output)
    fits = save(rows, options.output)
    draw(rows, fits, options.output / "scale.png")
    sys.stdout.write(json.dumps(fits, indent=1) + "\n")


def save(rows: list[dict[str, Any]], folder: Path) -> dict[str, dict[str, float]]:
    """Leave scale.csv and scale.json in a folder; what was fitted to the rows."""
    fits = fitted(rows)
    names = list(dict.fromkeys(name for row in rows for name in row))
    with (folder / "scale.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, names)
        writer.writeheader()
        writer.writerows(rows)
    (folder / "scale.json").write_text(json.dumps({"fits": fits, "points": rows}, indent=1) + "\n")
    return fits


if __name__ == "__main__":
    main()

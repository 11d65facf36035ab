"""Exchanging lights of a finished render: reads its folder, writes the images anew, and remembers what was exchanged."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR

from .errors import FileFormatError
from .files.atomic import remove_leftovers, written_together, written_whole
from .files.image_exr import read_channels, write_channels
from .files.json_object import UNREADABLE, numbers, read_object
from .files.lock import folder_lock
from .model import FloatArray, Job, Progress
from .render.outputs import IMAGE_ORIGIN, WHITE_ATTRIBUTE, picture_header, picture_rgb
from .render.plan_file import load_plan
from .render.swap import (
    SWAPPABLE_STEM,
    Swap,
    SwapKeeps,
    SwapKind,
    checked_name,
    light_names,
    swapped_xyz,
    told,
)
from .render_model import PassPlan
from .spectra.edits import lamp_spectrum
from .spectra.glass import glass_transmittance
from .spectra.grid import WAVELENGTHS_NM
from .spectra.white import parse_white
from .spectra.working_space import space_of_header

type Numbers = dict[str, Any]

SWAPS_NAME = "swaps.json"
"""Beside the images: which lights they show exchanged."""

REPORT_NAME = "report.json"
_FORMAT = "spectral-probe-swaps-1"


def swap_light(
    render_dir: Path,
    light: str,
    *,
    lamp: str | Path | None = None,
    glass: str | Path | None = None,
    keeps: SwapKeeps = "luminance",
    output: Path | None = None,
) -> Job[Numbers]:
    """Exchange a light of a finished render and write its images, of every view layer.

    Parameters
    ----------
    render_dir
        Folder of the render.
    light
        Name of a swappable region or lamp.
    lamp, glass
        A name of the library or a file; neither puts the light back as it was rendered.
    keeps
        What of the light stays under another lamp.
    output
        Folder to write xyz.exr, image.exr and report.json to; None writes over those of the render.

    Returns
    -------
    dict
        `lights`, what each is now, and `written`, the folder.

    Raises
    ------
    SpectralProbeError
        If there is no such light, lamp or glass, or a file is missing.
    """
    source, target = Path(render_dir), Path(output or render_dir)
    with folder_lock(target):
        yield Progress(0.0, "Reading the plan")
        remove_leftovers(source)
        plan = load_plan(source / "plan.json")
        swaps = _exchanged(source, plan, light, lamp, glass, keeps)
        lights = told(swaps, light_names(plan))
        with written_together(target, last=REPORT_NAME) as folder:
            for suffix in _layer_suffixes(source):
                yield Progress(0.1, "Adding up the light")
                xyz = swapped_xyz(source, plan, swaps, suffix)
                yield Progress(0.6, "Writing the images")
                _write_images(source, folder, xyz, suffix)
            _write_swaps(folder / SWAPS_NAME, swaps)
            _write_report(source, folder, lights)
    return {"lights": lights, "written": str(target)}


def _exchanged(
    source: Path,
    plan: PassPlan,
    light: str,
    lamp: str | Path | None,
    glass: str | Path | None,
    keeps: SwapKeeps,
) -> dict[str, Swap]:
    """Which lights of a render are exchanged with this one."""
    name = checked_name(plan, light)
    swaps = read_swaps(source)
    if lamp is not None:
        swaps[name] = Swap("lamp", _label(lamp), lamp_spectrum(lamp), keeps)
    elif glass is not None:
        swaps[name] = Swap("glass", _label(glass), glass_transmittance(glass))
    else:
        swaps.pop(name, None)
    return swaps


def list_lights(render_dir: Path) -> Job[Numbers]:
    """The lights of a render that can be exchanged, and what each is now."""
    yield Progress(0.0, "Reading the plan")
    plan = load_plan(Path(render_dir) / "plan.json")
    return {"lights": told(read_swaps(Path(render_dir)), light_names(plan))}


def read_swaps(render_dir: Path) -> dict[str, Swap]:
    """Which lights of a render are exchanged now; none where nothing was.

    Raises
    ------
    FileFormatError
        If the file that says so is damaged.
    """
    path = render_dir / SWAPS_NAME
    if not path.is_file():
        return {}
    wrong = FileFormatError(
        f"{path} is damaged. Delete it: the render is then as it was, swap its lights again."
    )
    try:
        content = read_object(path)
        if content["format"] != _FORMAT:
            raise wrong
        return {str(name): _swap_from(kept) for name, kept in content["swaps"].items()}
    except UNREADABLE:
        raise wrong from None


def _swap_from(kept: Mapping[str, Any]) -> Swap:
    kinds: dict[str, SwapKind] = {"lamp": "lamp", "glass": "glass"}
    keeps: dict[str, SwapKeeps] = {"luminance": "luminance", "power": "power"}
    return Swap(
        kinds[kept["kind"]],
        str(kept["label"]),
        np.array(numbers(kept["spectrum"], len(WAVELENGTHS_NM))),
        keeps[kept["keeps"]],
    )


def _label(thing: str | Path) -> str:
    path = Path(thing).expanduser()
    return path.name if path.is_file() else str(thing)


def _layer_suffixes(source: Path) -> list[str]:
    """What the names of the view layers' files end with; nothing for the first."""
    stored = sorted(source.glob(f"{SWAPPABLE_STEM}*.exr"))
    return [path.stem.removeprefix(SWAPPABLE_STEM) for path in stored] or [""]


def _write_images(source: Path, target: Path, xyz: FloatArray, suffix: str) -> None:
    """Write xyz.exr and image.exr, uncompressed (that is what is fast).

    Alpha, colour space and adaptation stay those of the render; the image is not denoised, which takes Blender.
    """
    for name, axes in ((f"xyz{suffix}.exr", "XYZ"), (f"image{suffix}.exr", "RGB")):
        channels, header = read_channels(source / name)
        kept = {"comments": header["comments"]} if "comments" in header else {}
        values = xyz
        if axes == "RGB":
            white = parse_white(str(header.get(WHITE_ATTRIBUTE, "")))
            space = space_of_header(header, name)
            values = picture_rgb(xyz, space, white)
            kept = picture_header(space, white, IMAGE_ORIGIN)
        planes = {axis: np.ascontiguousarray(values[..., index]) for index, axis in enumerate(axes)}
        for further, plane in channels.items():
            planes.setdefault(further, plane)
        write_channels(target / name, planes, {**kept, "compression": OpenEXR.NO_COMPRESSION})


def _write_report(source: Path, target: Path, lights: Mapping[str, str]) -> None:
    """The render's report, with a note of what its lights are now."""
    try:
        report = read_object(source / REPORT_NAME)
    except UNREADABLE:
        raise FileFormatError(f"{source / 'report.json'} cannot be read. Render again.") from None
    report["lights"] = dict(lights)
    with written_whole(target / REPORT_NAME) as temporary:
        temporary.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")


def _write_swaps(path: Path, swaps: Mapping[str, Swap]) -> None:
    content = {
        name: {"kind": one.kind, "label": one.label, "keeps": one.keeps, "spectrum": one.spectrum.tolist()}
        for name, one in swaps.items()
    }
    with written_whole(path) as temporary:
        temporary.write_text(json.dumps({"format": _FORMAT, "swaps": content}) + "\n", encoding="utf-8")

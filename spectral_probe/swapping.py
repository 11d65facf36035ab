"""Exchanging lights of a finished render: reads its folder, writes the images anew, and remembers what was exchanged."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR

from .errors import FileFormatError
from .files.atomic import check_folder, written_whole
from .files.image_exr import read_channels, write_channels
from .model import FloatArray, Job, Progress
from .render.outputs import picture_header, picture_rgb
from .render.plan_file import load_plan
from .render.swap import Swap, SwapKeeps, SwapKind, checked_name, light_names, swapped_xyz, told
from .spectra.edits import lamp_spectrum
from .spectra.glass import glass_transmittance
from .spectra.white import white_of_note
from .spectra.working_space import space_of_header

type Numbers = dict[str, Any]

SWAPS_NAME = "swaps.json"
"""Beside the images: which lights they show exchanged."""

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
    """Exchange a light of a finished render and write its images.

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
    check_folder(target)
    yield Progress(0.0, "Reading the plan")
    plan = load_plan(source / "plan.json")
    name = checked_name(plan, light)
    swaps = read_swaps(source)
    if lamp is not None:
        swaps[name] = Swap("lamp", _label(lamp), lamp_spectrum(lamp), keeps)
    elif glass is not None:
        swaps[name] = Swap("glass", _label(glass), glass_transmittance(glass))
    else:
        swaps.pop(name, None)
    yield Progress(0.1, "Adding up the light")
    xyz = swapped_xyz(source, plan, swaps)
    yield Progress(0.6, "Writing the images")
    lights = told(swaps, light_names(plan))
    _write_images(source, target, xyz)
    _write_report(source, target, lights)
    _write_swaps(target / SWAPS_NAME, swaps)
    return {"lights": lights, "written": str(target)}


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
        content = json.loads(path.read_text(encoding="utf-8"))
        if content["format"] != _FORMAT:
            raise wrong
        return {str(name): _swap_from(kept) for name, kept in content["swaps"].items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise wrong from None


def _swap_from(kept: Mapping[str, Any]) -> Swap:
    kinds: dict[str, SwapKind] = {"lamp": "lamp", "glass": "glass"}
    keeps: dict[str, SwapKeeps] = {"luminance": "luminance", "power": "power"}
    return Swap(
        kinds[kept["kind"]], str(kept["label"]), np.array(kept["spectrum"], float), keeps[kept["keeps"]]
    )


def _label(thing: str | Path) -> str:
    path = Path(thing).expanduser()
    return path.name if path.is_file() else str(thing)


def _write_images(source: Path, target: Path, xyz: FloatArray) -> None:
    """Write xyz.exr and image.exr, uncompressed (that is what is fast); alpha stays, and so do space and white of the picture.

    The picture is not denoised.
    """
    channels, header = read_channels(source / "xyz.exr")
    notes = {"comments": header["comments"]} if "comments" in header else {}
    _write_planes(target / "xyz.exr", channels, "XYZ", xyz, notes)
    channels, header = read_channels(source / "image.exr")
    space, white = space_of_header(header, "image.exr"), white_of_note(str(header.get("comments", "")))
    notes = picture_header(space, white, "from XYZ as in xyz.exr without normalisation")
    _write_planes(target / "image.exr", channels, "RGB", picture_rgb(xyz, space, white), notes)


def _write_planes(
    path: Path, channels: Mapping[str, FloatArray], axes: str, values: FloatArray, header: Mapping[str, Any]
) -> None:
    """Write an image's channels with some of them replaced by values (H, W, 3)."""
    planes = {axis: np.ascontiguousarray(values[..., index]) for index, axis in enumerate(axes)}
    write_channels(path, {**channels, **planes}, {**header, "compression": OpenEXR.NO_COMPRESSION})


def _write_report(source: Path, target: Path, lights: Mapping[str, str]) -> None:
    """The render's report, with a note of what its lights are now."""
    try:
        report = json.loads((source / "report.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        raise FileFormatError(f"{source / 'report.json'} cannot be read. Render again.") from None
    report["lights"] = dict(lights)
    with written_whole(target / "report.json") as temporary:
        temporary.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")


def _write_swaps(path: Path, swaps: Mapping[str, Swap]) -> None:
    content = {
        name: {"kind": one.kind, "label": one.label, "keeps": one.keeps, "spectrum": one.spectrum.tolist()}
        for name, one in swaps.items()
    }
    with written_whole(path) as temporary:
        temporary.write_text(json.dumps({"format": _FORMAT, "swaps": content}) + "\n", encoding="utf-8")

"""What the verb `filter` does: edit a probe's light, list its edits, take one back.

Each is a job: it yields progress, writes its file, and returns the numbers worth telling.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from .commands import check_folder
from .errors import FileFormatError
from .files.probe_exr import read_probe, write_probe
from .files.region_json import read_region
from .geometry.frames import panorama_solid_angles
from .model import BoolArray, Edit, Job, Progress, Region, SpectralPanorama
from .spectra.colorimetry import chromaticity, spectra_to_xyz
from .spectra.edits import (
    apply_edit,
    edited_mask,
    glass_edit,
    lamp_edit,
    remove_all_edits,
    remove_edit,
)
from .spectra.grid import resample
from .spectra.regions import describe, mean_spectrum, region_mask

type Numbers = dict[str, Any]

ALL: Literal["all"] = "all"
"""The word that stands for every edit."""


@dataclass(frozen=True)
class Change:
    """What a new edit shall be: a glass by name or file, or a lamp by name or file and what it keeps."""

    kind: Literal["glass", "lamp"]
    name: str
    keeps: Literal["luminance", "power"] = "luminance"


def changed_panorama(
    panorama: SpectralPanorama, change: Change, region: Region
) -> tuple[SpectralPanorama, BoolArray]:
    """A panorama with a change made in a region, and the region's texels (H, W).

    Raises
    ------
    SpectralProbeError
        If there is no such glass or lamp, or the region selects nothing.
    """
    where = describe(region)
    edit: Edit
    if change.kind == "glass":
        edit = glass_edit(panorama, change.name, where)
    else:
        edit = lamp_edit(panorama, change.name, where, change.keeps)
    mask = region_mask(region, panorama)
    return apply_edit(panorama, edit, mask), mask


def add_edit(probe_path: Path, change: Change, region_path: Path, output: Path) -> Job[Numbers]:
    """Put a glass before a region of a probe, or another lamp into it, and write the edited probe."""
    _check_output(output)
    region = read_region(region_path)
    yield Progress(0.05, "Reading the probe")
    before = read_probe(probe_path)
    yield Progress(0.4, "Finding the region")
    after, mask = changed_panorama(before, change, region)
    numbers = {
        "edit": len(after.edits),
        "kind": change.kind,
        "name": after.edits[-1].name,
        "region": after.edits[-1].region,
        "solid_angle_sr": solid_angle(mask),
        "before": light_in(before, mask),
        "after": light_in(after, mask),
        "edits": list_of(after),
        "written": str(output),
    }
    yield Progress(0.6, f"Writing {output.name}")
    write_probe(output, after)
    return numbers


def take_back(probe_path: Path, number: int | Literal["all"], output: Path) -> Job[Numbers]:
    """Take one edit back, counted from 1, or all, and write the probe as it is without."""
    _check_output(output)
    yield Progress(0.05, "Reading the probe")
    before = read_probe(probe_path)
    after = remove_all_edits(before) if number == ALL else remove_edit(before, number - 1)
    removed = before.edits if number == ALL else before.edits[number - 1 : number]
    yield Progress(0.6, f"Writing {output.name}")
    write_probe(output, after)
    return {
        "removed": [f"{edit.kind} {edit.name}, {edit.region}" for edit in removed],
        "edits": list_of(after),
        "written": str(output),
    }


def list_edits(probe_path: Path) -> Job[Numbers]:
    """The edits of a probe."""
    yield Progress(0.05, "Reading the probe")
    edits = list_of(read_probe(probe_path))
    return {"count": len(edits), "edits": edits}


def list_of(panorama: SpectralPanorama) -> list[Numbers]:
    """The edits of a panorama, numbered from 1, with the solid angle of their regions."""
    return [
        {
            "number": number + 1,
            "kind": edit.kind,
            "name": edit.name,
            **({"keeps": edit.keeps} if edit.kind == "lamp" else {}),
            "region": edit.region,
            "solid_angle_sr": solid_angle(edited_mask(panorama, number)),
        }
        for number, edit in enumerate(panorama.edits)
    ]


def solid_angle(mask: BoolArray) -> float:
    """Solid angle of some texels (H, W), in steradians."""
    return float((panorama_solid_angles(*mask.shape)[:, 0] * mask.sum(1)).sum())


def light_in(panorama: SpectralPanorama, mask: BoolArray) -> Numbers:
    """Chromaticity and luminance (radiance times CIE y-bar summed over nm, relative) of a region's mean light."""
    spectrum = resample(panorama.wavelengths_nm, mean_spectrum(panorama, mask), name="the panorama")
    xyz = spectra_to_xyz(np.asarray(spectrum))
    return {"xy": chromaticity(xyz).tolist(), "luminance": float(xyz[1])}


def _check_output(output: Path) -> None:
    if output.suffix.lower() != ".exr" or output.is_dir():
        raise FileFormatError(f"{output} is no file to write a probe to. Give a name such as edited.exr.")
    check_folder(output.parent)

"""What the verb `filter` does: edit a probe's light, list its edits, take one back.

Each is a job: it yields progress, writes its file, and returns the numbers worth telling.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

from .errors import FileFormatError
from .files.atomic import check_folder, folder_written_whole
from .files.probe_exr import read_probe, write_layers, write_probe, write_world
from .files.region_json import read_region
from .geometry.frames import panorama_solid_angles
from .model import BoolArray, Edit, Job, Keeps, Progress, SpectralPanorama, part
from .render.layers import light_layers
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

EDITS_FOLDER = "edits"
"""Folder beside a probe in which Blender keeps its edited light."""


@dataclass(frozen=True)
class Change:
    """What a new edit shall be: a glass by name or file, or a lamp by name or file, what it keeps, and which lamp it was."""

    kind: Literal["glass", "lamp"]
    name: str
    keeps: Keeps = "luminance"
    was: str | None = None

    def of(self, panorama: SpectralPanorama, where: str) -> Edit:
        """The edit of a panorama, `where` in words.

        Raises
        ------
        SpectralDataError
            If there is no such glass or lamp.
        """
        if self.kind == "glass":
            return glass_edit(panorama, self.name, where)
        return lamp_edit(panorama, self.name, where, self.keeps, self.was)


def add_edit(
    probe_path: Path, change: Change, region_path: Path, output: Path, preview: Path | None = None
) -> Job[Numbers]:
    """Put a glass before a region of a probe, or another lamp into it, and write the edited probe, and a picture of it."""
    _check_output(output, preview)
    region = read_region(region_path)
    yield Progress(0.05, "Reading the probe")
    before = read_probe(probe_path)
    yield Progress(0.4, "Finding the region")
    edit = change.of(
        before, describe(region)
    )  # before the region is looked for: wrong names must fail at once
    mask = region_mask(region, before)
    after = apply_edit(before, edit, mask)
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
    yield from part(_write(after, output, preview), 0.6, 1.0)
    return numbers


def take_back(
    probe_path: Path, number: int | Literal["all"], output: Path, preview: Path | None = None
) -> Job[Numbers]:
    """Take one edit back, counted from 1, or all, and write the probe as it is without, and a picture of it."""
    _check_output(output, preview)
    yield Progress(0.05, "Reading the probe")
    before = read_probe(probe_path)
    after = remove_all_edits(before) if number == ALL else remove_edit(before, number - 1)
    removed = before.edits if number == ALL else before.edits[number - 1 : number]
    yield from part(_write(after, output, preview), 0.6, 1.0)
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


# ---------------------------------------------------------------- edited light beside the probe's, for Blender


@dataclass(frozen=True)
class EditedLight:
    """The files of an edited probe: their folder, the edits as `list_of` tells them, and the panorama."""

    directory: Path
    edits: list[Numbers]
    panorama: SpectralPanorama = field(compare=False)


def edit_light(
    directory: Path, base: Path, edit: Callable[[SpectralPanorama], SpectralPanorama]
) -> Job[EditedLight]:
    """Edit the probe in a folder and write what lights a scene into a folder of its own.

    Nothing that is there is changed. Every state of the light has a folder named after its content, so that undoing and redoing
    finds the files of each; the light without edits is the one in `base`.

    Parameters
    ----------
    directory
        Folder of the probe as it is now.
    base
        Folder of the probe as it was built; edited light goes to `base`/edits/NAME.
    edit
        What to do to the panorama.
    """
    yield Progress(0.0, "Reading the probe")
    before = read_probe(directory / "probe.exr")
    yield Progress(0.15, "Editing the light")
    after = edit(before)
    if not after.edits and directory != base:
        before = read_probe(base / "probe.exr")
    if _same_light(after, before):
        return EditedLight(base if not after.edits else directory, list_of(after), after)
    target = base / EDITS_FOLDER / _content(after)
    if not target.is_dir():
        yield from part(_write_light(after, target), 0.3, 1.0)
    return EditedLight(target, list_of(after), after)


def _same_light(a: SpectralPanorama, b: SpectralPanorama) -> bool:
    return len(a.edits) == len(b.edits) and _content(a) == _content(b)


def _content(panorama: SpectralPanorama) -> str:
    """A short name that only this light has."""
    digest = hashlib.blake2b(digest_size=8)
    for array in (panorama.weights, panorama.bases, panorama.basis_index, panorama.confidence):
        digest.update(np.ascontiguousarray(array))
    digest.update(repr([(edit.kind, edit.name, edit.region, edit.keeps) for edit in panorama.edits]).encode())
    return digest.hexdigest()


def _write_light(panorama: SpectralPanorama, directory: Path) -> Job[None]:
    """Write probe.exr, layers.exr, world.exr and preview.png into a new folder, whole or not at all."""
    from .figures.panorama import panorama_preview, write_png

    layers = light_layers(panorama)  # refuses a panorama without light before anything is made
    with folder_written_whole(directory) as folder:
        yield Progress(0.1, "Writing probe.exr")
        write_probe(folder / "probe.exr", panorama)
        yield Progress(0.5, "Writing layers.exr")
        write_layers(folder / "layers.exr", layers)
        yield Progress(0.7, "Writing world.exr")
        write_world(folder / "world.exr", panorama)
        yield Progress(0.9, "Writing preview.png")
        write_png(folder / "preview.png", panorama_preview(panorama))


def _check_output(output: Path, preview: Path | None) -> None:
    if output.suffix.lower() != ".exr" or output.is_dir():
        raise FileFormatError(f"{output} is no file to write a probe to. Give a name such as edited.exr.")
    if preview is not None and (preview.suffix.lower() != ".png" or preview.is_dir()):
        raise FileFormatError(f"{preview} is no file to write a picture to. Give a name such as edited.png.")
    for file in filter(None, (output, preview)):
        check_folder(file.parent)


def _write(panorama: SpectralPanorama, output: Path, preview: Path | None) -> Job[None]:
    yield Progress(0.0, f"Writing {output.name}")
    write_probe(output, panorama)
    if preview is not None:
        from .figures.panorama import panorama_preview, write_png

        yield Progress(0.8, f"Writing {preview.name}")
        write_png(preview, panorama_preview(panorama))

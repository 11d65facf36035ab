"""Finished steps of a spectral render put together into its files, for every view layer."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...spectral_probe.composite_model import BACKPLATE_NAME, OBJECTS_NAME
from ...spectral_probe.files.atomic import not_written
from ...spectral_probe.files.objects_exr import write_objects
from ...spectral_probe.model import Job, Progress
from ...spectral_probe.render.assemble import assemble
from ...spectral_probe.render.frame_record import FrameRecord
from ...spectral_probe.render.frame_steps import TWIN_STEP
from ...spectral_probe.render.outputs import OutputSettings, bands_wanted, write_outputs, write_rgb_twin
from ...spectral_probe.render.pass_folder import PassFolder, read_pass
from ...spectral_probe.render_model import WORLD, PassImage, PassPlan, RenderStep
from ...spectral_probe.spectra.working_space import working_space
from ...spectral_probe.work import worked
from .denoise import denoising
from .object_coverage import coverage_in
from .render_report import REPORT_NAME

type Array = np.ndarray[Any, Any]

PLAN_NAME = "plan.json"

_PICTURES = ("xyz", "image", "render", "rgb", "swappable", "spectral", "objects")


@contextmanager
def told_where_not_written(directory: Path) -> Iterator[None]:
    """Files are removed and written in the block: where they cannot be, that is one sentence.

    Raises
    ------
    FileFormatError
        If they cannot.
    """
    try:
        yield
    except OSError as problem:
        raise not_written(directory, problem) from None


def picture_names(view_layers: Sequence[str]) -> list[str]:
    """Names of the files that a render of these view layers may leave beside its passes and plan."""
    layers = [f"{picture}{suffix}.exr" for suffix in layer_suffixes(view_layers) for picture in _PICTURES]
    return [REPORT_NAME, BACKPLATE_NAME, "swaps.json", *layers]


def remove_pictures(directory: Path, view_layers: Sequence[str]) -> None:
    """Remove the files of an earlier render of these view layers, lest they be taken for those of this one."""
    for name in picture_names(view_layers):
        (directory / name).unlink(missing_ok=True)


def write_pictures(
    progress: Progress,
    folder: PassFolder,
    plan: PassPlan,
    steps: Sequence[RenderStep],
    settings: OutputSettings,
    directory: Path,
) -> Job[None]:
    """Put the steps of every view layer together and write the files of `render.outputs`.

    `settings` say whether the picture is denoised. Files of the first view layer have their plain names; those of others the
    layer's name after an underscore.
    """
    space = working_space(folder.record.to_rec709)
    for number, suffix in enumerate(layer_suffixes(folder.view_layers)):
        bands_nm = bands_wanted(plan, settings)
        assembled = yield from worked(
            progress, partial(assemble, plan, steps, _reader(folder, number), bands_nm=bands_nm)
        )
        smooth = None
        if settings.denoise:
            denoise = replace(progress, message="Denoising")
            smooth = yield from denoising(denoise, assembled.xyz, assembled.guide)
        write = partial(
            write_outputs,
            directory,
            plan,
            assembled,
            settings,
            space=space,
            denoised_xyz=smooth,
            suffix=suffix,
        )
        yield from worked(progress, write)


def write_twin(
    progress: Progress, folder: PassFolder, level: float, settings: OutputSettings, directory: Path
) -> Job[None]:
    """Write rgb.exr of every view layer in the unit of image.exr; the twin was rendered at the level of its light."""
    to_rec709 = folder.record.to_rec709
    space = working_space(to_rec709)

    def write(number: int, path: Path) -> None:
        image = read_pass(folder.path(TWIN_STEP), number)
        rgb = image.groups[WORLD] @ to_rec709.T.astype(np.float32) * level
        write_rgb_twin(path, rgb, image.alpha, settings, space)

    for number, suffix in enumerate(layer_suffixes(folder.view_layers)):
        yield from worked(progress, partial(write, number, directory / f"rgb{suffix}.exr"))


def write_objects_of(
    progress: Progress, folder: PassFolder, steps: Sequence[RenderStep], directory: Path
) -> Job[None]:
    """Write objects.exr of every view layer, which pixels show which object, by the steps that know."""
    record: FrameRecord = folder.record
    files = [(folder.path(step.name), step.samples) for step in steps]
    for number, suffix in enumerate(layer_suffixes(folder.view_layers)):
        coverage = yield from worked(
            progress, partial(coverage_in, files, number, record.catchers, record.virtual)
        )
        write_objects(directory / f"{Path(OBJECTS_NAME).stem}{suffix}.exr", coverage)


def layer_suffixes(names: Sequence[str]) -> list[str]:
    """What tells the files of view layers apart: nothing for the first, the layer's name for the others."""
    suffixes = [""]
    for name in names[1:]:
        suffix, taken = f"_{bpy.path.clean_name(name)}", {one.lower() for one in suffixes}
        while suffix.lower() in taken:
            suffix += f"_{len(suffixes) + 1}"
        suffixes.append(suffix)
    return suffixes


def _reader(folder: PassFolder, layer: int) -> Callable[[RenderStep], PassImage]:
    return lambda step: read_pass(folder.path(step.name), layer)

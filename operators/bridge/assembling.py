"""Finished steps of a spectral render put together into its files, for every view layer."""

from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import bpy
import numpy as np

from ...spectral_probe.composite_model import BACKPLATE_NAME, OBJECTS_NAME
from ...spectral_probe.files.atomic import UNFINISHED
from ...spectral_probe.files.objects_exr import write_objects
from ...spectral_probe.render.assemble import assemble
from ...spectral_probe.render.outputs import OutputSettings, bands_wanted, write_outputs, write_rgb_twin
from ...spectral_probe.render.pass_folder import PassFolder, read_pass
from ...spectral_probe.render_model import WORLD, PassImage, PassPlan, RenderStep
from ...spectral_probe.spectra.working_space import working_space
from .catchers import Surfaces
from .denoise import denoised, wants_denoising
from .object_coverage import coverage_in
from .render_report import REPORT_NAME
from .translation import working_to_rec709

type Array = np.ndarray[Any, Any]

TWIN_STEP = "rgb"
_PICTURES = ("xyz", "image", "render", "rgb", "swappable", "spectral", "objects")


def remove_pictures(directory: Path, view_layers: Sequence[str]) -> None:
    """Remove the files of an earlier render of these view layers, lest they be taken for those of this one."""
    for name in (REPORT_NAME, BACKPLATE_NAME, "swaps.json"):
        (directory / name).unlink(missing_ok=True)
    for suffix in layer_suffixes(view_layers):
        for picture in _PICTURES:
            (directory / f"{picture}{suffix}.exr").unlink(missing_ok=True)


def write_pictures(
    scene: bpy.types.Scene,
    folder: PassFolder,
    plan: PassPlan,
    steps: Sequence[RenderStep],
    settings: OutputSettings,
    directory: Path,
) -> None:
    """Put the steps of every view layer together and write the files of `render.outputs`.

    Those of the first view layer have their plain names; those of others the layer's name after an underscore.
    """
    space = working_space(working_to_rec709())
    for number, suffix in enumerate(layer_suffixes(folder.view_layers)):
        assembled = assemble(plan, steps, _reader(folder, number), bands_nm=bands_wanted(plan, settings))
        smooth = None
        if wants_denoising(scene, settings.denoise):
            smooth = denoised(assembled.xyz, assembled.guide)
        with TemporaryDirectory(prefix=UNFINISHED, dir=directory) as temporary:
            files = write_outputs(
                Path(temporary), plan, assembled, settings, space=space, denoised_xyz=smooth
            )
            for path in files.values():
                path.replace(directory / f"{path.stem}{suffix}{path.suffix}")


def write_twin(folder: PassFolder, level: float, settings: OutputSettings, directory: Path) -> None:
    """Write rgb.exr of every view layer in the unit of image.exr; the twin was rendered at the level of its light."""
    to_rec709 = working_to_rec709()
    space = working_space(to_rec709)
    for number, suffix in enumerate(layer_suffixes(folder.view_layers)):
        image = read_pass(folder.path(TWIN_STEP), number)
        rgb = image.groups[WORLD] @ to_rec709.T.astype(np.float32) * level
        write_rgb_twin(directory / f"rgb{suffix}.exr", rgb, image.alpha, settings, space)


def write_objects_of(
    folder: PassFolder, steps: Sequence[RenderStep], found: Surfaces, directory: Path
) -> None:
    """Write objects.exr of every view layer, which pixels show which object, by the steps that know."""
    files = [(folder.path(step.name), step.samples) for step in steps]
    for number, suffix in enumerate(layer_suffixes(folder.view_layers)):
        coverage = coverage_in(files, number, found)
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

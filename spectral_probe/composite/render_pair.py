"""The renders that a composite is made of: with the virtual objects and without, as the plate's lens would have shown them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..composite_model import BACKPLATE_NAME, OBJECTS_NAME, WITHOUT_NAME, Backplate, ObjectCoverage
from ..errors import RenderError
from ..files.image_exr import read_channels
from ..files.objects_exr import read_objects
from ..model import FloatArray
from ..spectra.colorimetry import xyz_to_rec709
from .backplate_file import load_backplate
from .camera_colour import camera_rgb, read_xyz, render_xyz
from .denoised_objects import denoised_xyz
from .distortion import Lens
from .picture import picture_xyz

_LEAST_COVERED = 0.02
"""Share of a pixel that may be neither object nor ground before a render without alpha counts as showing its world: less is what
the pixel filter leaves."""

type Pair = tuple[FloatArray, FloatArray | None]
"""A render (H, W, 3) with the objects, and without them; None where nothing real is in the scene."""


@dataclass(frozen=True)
class RenderPair:
    """A render's folder, that of the render without the objects, and what both show.

    `coverage` and `without_alpha` (H, W), how much of each pixel the ground covers alone, are in the picture of the plate;
    `without` is None where nothing real is in the scene.
    """

    directory: Path
    without: Path | None
    coverage: ObjectCoverage
    lens: Lens
    without_alpha: FloatArray | None

    def camera_rgb(self, sensitivities: FloatArray) -> Pair:
        """In a camera's linear RGB, in the probe's unit."""
        rgb, _ = camera_rgb(self.directory, sensitivities)
        if self.without is None:
            return self.lens.picture(rgb), None
        alone, _ = camera_rgb(self.without, sensitivities, lights_of=self.directory)
        return self.lens.picture(rgb), self.lens.picture(alone)

    def xyz(self) -> Pair:
        """In tristimulus values."""
        xyz = self.lens.picture(render_xyz(self.directory))
        if self.without is None:
            return xyz, None
        return xyz, self.lens.picture(render_xyz(self.without, lights_of=self.directory))

    def denoised_xyz(self) -> FloatArray | None:
        """The render with the objects in tristimulus values without its noise; None where it was not denoised."""
        found = denoised_xyz(self.directory)
        return None if found is None else self.lens.picture(found)

    @property
    def has_rgb(self) -> bool:
        """Whether there is an ordinary RGB render of each."""
        folders = [self.directory, *([] if self.without is None else [self.without])]
        return all((folder / "rgb.exr").is_file() for folder in folders)

    def rgb(self) -> Pair:
        """The ordinary RGB renders in linear Rec.709, not adapted from any white."""
        rgb = self.lens.picture(_read_rgb(self.directory / "rgb.exr"))
        return rgb, None if self.without is None else self.lens.picture(_read_rgb(self.without / "rgb.exr"))


def read_backplate(render_dir: Path) -> Backplate | None:
    """The backplate in a render's folder; None where there is none."""
    path = render_dir / BACKPLATE_NAME
    return load_backplate(path) if path.is_file() else None


def render_pair(render_dir: Path, backplate: Backplate | None) -> RenderPair:
    """What of the render a composite needs, looked at before anything is computed.

    Raises
    ------
    RenderError
        If the render is not finished, or was made without what a composite needs.
    """
    if not render_dir.is_dir():
        raise RenderError(f"There is no folder {render_dir}. Give the folder of a spectral render.")
    xyz, alpha = read_xyz(render_dir)
    objects = render_dir / OBJECTS_NAME
    if not objects.is_file():
        raise RenderError(
            f"{render_dir} has no {OBJECTS_NAME}, which says which pixels show the objects. Render the scene again."
        )
    coverage = read_objects(objects)
    if coverage.coverage.shape != xyz.shape[:2]:
        raise RenderError(
            f"{OBJECTS_NAME} and xyz.exr of {render_dir} differ in size. Render the scene again."
        )
    _check_covered(coverage, alpha)
    lens = Lens(backplate)
    alone, alone_alpha = render_dir / WITHOUT_NAME, None
    if coverage.ground.any():
        if not (alone / "xyz.exr").is_file():
            raise RenderError(
                f"{alone} holds no finished render without the objects, though the scene has shadow catchers. Render the "
                "scene again: it goes on where it was."
            )
        other, alone_alpha = read_xyz(alone)
        if other.shape != xyz.shape:
            raise RenderError(
                f"The renders with and without the objects in {render_dir} differ in size. Render again."
            )
    bent = ObjectCoverage(
        {name: lens.picture(plane) for name, plane in coverage.objects.items()},
        lens.picture(coverage.coverage),
        lens.picture(coverage.ground),
    )
    return RenderPair(
        render_dir,
        alone if coverage.ground.any() else None,
        bent,
        lens,
        None if alone_alpha is None else lens.picture(alone_alpha),
    )


def _check_covered(coverage: ObjectCoverage, alpha: FloatArray | None) -> None:
    """Refuse a render that shows no object, or has its world behind the objects."""
    if not (coverage.coverage > 0).any():
        raise RenderError(
            "No virtual object is in the picture: only shadow catchers, or nothing at all. Add an object that the camera sees."
        )
    total = coverage.coverage + coverage.ground
    if alpha is None and float(np.mean(total < 1 - _LEAST_COVERED)) > 0:
        raise RenderError(
            "The render shows its world behind the objects. Switch on Render Properties > Film > Transparent and render again."
        )


def _read_rgb(path: Path) -> FloatArray:
    """rgb.exr of a render in linear Rec.709, not adapted from any white."""
    channels, header = read_channels(path)
    return np.asarray(xyz_to_rec709(picture_xyz(channels, header, path)), np.float32)

"""The files of a spectral render: tristimulus values, scene-linear pictures, one multilayer EXR, the whole spectrum.

- `xyz.exr`: X, Y, Z as they came; never adapted, never denoised.
- `image.exr`: R, G, B in the working space; adapted and denoised where that was asked for.
- `render.exr`: X, Y, Z; R, G, B as in image.exr; spectral radiance at the wavelengths rendered, as channels
  `S0.550,000000nm` (`files.spectral_exr`); A where the film is transparent.
- `spectral.exr`: all wavelengths of the grid, on demand.
- `swappable.exr`: what `render.swap` needs, where something is swappable.

The headers say what was done.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR

from ..errors import RenderError
from ..files.image_exr import write_channels, write_rows
from ..files.spectral_channels import channel_name
from ..files.spectral_exr import EMISSIVE_HEADER
from ..model import FloatArray
from ..render_model import PassPlan
from ..spectra.white import White, parse_white
from ..spectra.working_space import WorkingSpace, working_space
from .assemble import AssembledRender, rendered_wavelengths_nm

XYZ_NOTE = (
    "CIE 1931 2 degree tristimulus values: spectral radiance times colour-matching functions, summed over nm"
)
IMAGE_ORIGIN = "from XYZ as in xyz.exr without normalisation"
"""Where the colours of image.exr come from, for `picture_header`."""

WHITE_ATTRIBUTE = "adaptedFromWhite"
"""Header attribute of a picture: the white that was stated."""

DENOISED_NOTE = "denoised by Open Image Denoise"
"""In the header's comments of a picture that was."""

_HALF_LIMIT = 6.0e4
"""Brightest value that a 16-bit float holds, with room."""


@dataclass(frozen=True)
class OutputSettings:
    """What is written besides xyz.exr, image.exr and render.exr, and how pictures are finished.

    Parameters
    ----------
    spectral
        Also write all wavelengths: spectral.exr.
    white
        The white from which image.exr and rgb.exr are adapted to D65; None for no adaptation.
    denoise
        Whether image.exr is denoised; None as the scene's own render settings say.
    """

    spectral: bool = False
    white: White | None = None
    denoise: bool | None = None


def output_settings(
    *, spectral: bool = False, white: str = "", denoise: bool | None = None
) -> OutputSettings:
    """Output settings of what a person stated; see `parse_white` for `white`.

    Examples
    --------
    >>> output_settings(white="A").white.stated
    'A'
    """
    return OutputSettings(spectral, parse_white(white), denoise)


def bands_wanted(plan: PassPlan, settings: OutputSettings) -> FloatArray:
    """Wavelengths (N,) at which `assemble` is to give the spectrum for these outputs."""
    return np.asarray(plan.grid_nm) if settings.spectral else rendered_wavelengths_nm(plan)


def write_outputs(
    directory: Path,
    plan: PassPlan,
    assembled: AssembledRender,
    settings: OutputSettings,
    *,
    space: WorkingSpace | None = None,
    denoised_xyz: FloatArray | None = None,
    suffix: str = "",
) -> dict[str, Path]:
    """Write the files of a render.

    Parameters
    ----------
    directory
        Where to write.
    plan
        The plan that was rendered.
    assembled
        The render, with the bands of `bands_wanted`.
    settings
        What was asked for.
    space
        The file's working space; None is Rec.709.
    denoised_xyz
        (H, W, 3) tristimulus values for the pictures, where they were denoised.
    suffix
        What tells the files of a further view layer apart: `xyz_SUFFIX.exr` where it is "_SUFFIX".

    Returns
    -------
    dict
        The files by name: "xyz", "image", "render", and "spectral" and "swappable" where they were written.

    Raises
    ------
    RenderError
        If the bands are not there.
    """
    space = space or working_space()
    if assembled.bands is None:
        raise RenderError("The render was assembled without its bands. Assemble it with bands_wanted.")
    alpha = {} if assembled.alpha is None else {"A": assembled.alpha}
    picture = assembled.xyz if denoised_xyz is None else denoised_xyz
    rgb = picture_rgb(picture, space, settings.white)
    xyz_planes, rgb_planes = _planes("XYZ", assembled.xyz), _planes("RGB", rgb) | alpha
    header = picture_header(space, settings.white, IMAGE_ORIGIN)
    if denoised_xyz is not None:
        header["comments"] += f"; {DENOISED_NOTE}"
    files = {name: Path(directory) / f"{name}{suffix}.exr" for name in ("xyz", "image", "render")}
    write_channels(files["xyz"], xyz_planes | alpha, {"comments": XYZ_NOTE})
    write_channels(files["image"], rgb_planes, header)
    bands = dict(zip(assembled.bands_nm.tolist(), assembled.bands, strict=True))
    rendered = {channel_name(nm): bands[nm] for nm in rendered_wavelengths_nm(plan).tolist() if nm in bands}
    write_channels(
        files["render"],
        xyz_planes | rgb_planes | rendered,
        header | EMISSIVE_HEADER | {"comments": f"X, Y, Z: {XYZ_NOTE}. R, G, B: {header['comments']}"},
    )
    if settings.spectral:
        files["spectral"] = Path(directory) / f"spectral{suffix}.exr"
        _write_spectrum(files["spectral"], bands, rgb_planes, header)
    if assembled.swappable:
        files["swappable"] = Path(directory) / f"swappable{suffix}.exr"
        write_channels(
            files["swappable"], assembled.swappable, {"compression": OpenEXR.NO_COMPRESSION}
        )  # read in a hurry
    return files


def picture_rgb(xyz: FloatArray, space: WorkingSpace, white: White | None) -> FloatArray:
    """Scene-linear colours (H, W, 3) of a picture: adapted where a white was stated, in the working space."""
    return np.asarray(space.of_xyz(xyz if white is None else white.adapted(xyz)), np.float32)


def picture_header(space: WorkingSpace, white: White | None, origin: str) -> dict[str, Any]:
    """Header attributes of a picture; `origin` says where its colours come from."""
    adaptation = "no chromatic adaptation" if white is None else white.note
    return {
        "comments": f"scene-linear {space.name.removeprefix('Linear ')}, {origin}; {adaptation}",
        "chromaticities": tuple(float(value) for value in space.chromaticities),
        **({} if white is None else {WHITE_ATTRIBUTE: white.stated}),
    }


def write_rgb_twin(
    path: Path, rgb: FloatArray, alpha: FloatArray | None, settings: OutputSettings, space: WorkingSpace
) -> None:
    """Write the RGB render (H, W, 3), scene-linear Rec.709 in the unit of image.exr, in the manner of image.exr."""
    from ..spectra.colorimetry import rec709_to_xyz

    planes = _planes("RGB", picture_rgb(rec709_to_xyz(rgb), space, settings.white))
    header = picture_header(space, settings.white, "rendered in RGB, in the unit of image.exr")
    write_channels(path, planes | ({} if alpha is None else {"A": alpha}), header)


def _planes(names: str, image: FloatArray) -> dict[str, FloatArray]:
    return {name: np.asarray(image[..., index], np.float32) for index, name in enumerate(names)}


def _write_spectrum(
    path: Path,
    bands: Mapping[float, FloatArray],
    preview: Mapping[str, FloatArray],
    header: Mapping[str, Any],
) -> None:
    """16-bit channels where they hold the range, else 32-bit; R, G, B are the preview."""
    brightest = max(float(max(plane.max(), -plane.min())) for plane in bands.values())
    kind = np.float16 if 1.0 < brightest < _HALF_LIMIT else np.float32

    def rows_of(rows: slice) -> dict[str, Any]:
        planes: dict[str, Any] = {channel_name(nm): plane[rows].astype(kind) for nm, plane in bands.items()}
        return planes | {name: plane[rows].astype(np.float32) for name, plane in preview.items()}

    height, width = next(iter(preview.values())).shape
    write_rows(path, (height, width), rows_of, {**header, **EMISSIVE_HEADER})

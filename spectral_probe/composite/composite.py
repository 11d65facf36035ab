"""The verb `composite`: a finished render put into its photograph."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..composite_model import Backplate, ObjectCoverage
from ..errors import RenderError
from ..figures.display import Picture, write_png
from ..files.atomic import written_together
from ..files.image_exr import write_rgb
from ..files.lock import folder_lock
from ..model import FloatArray, Job, Progress
from ..spectra.colorimetry import rec709_to_xyz, xyz_to_rec709
from .camera_colour import camera_to_xyz, is_rec709
from .denoised_objects import denoised_in_camera
from .differential import Composite, differential
from .outputs import display_exposure, picture_of, write_difference, write_linear, write_numbers
from .panorama_plate import is_probe, panorama_plate
from .plate_photo import Plate, PlateSettings, read_plate
from .render_pair import Pair, RenderPair, read_backplate, render_pair

type Numbers = dict[str, Any]

NUMBERS_NAME = "composite.json"

_RGB_NAMES = ("composite_rgb.exr", "composite_rgb.png")
_RGB_NOT_DENOISED = (
    "The objects are denoised, those of composite_rgb are not: rgb.exr never is. "
    "Compose as rendered for like with like."
)

_MANY_CLIPPED, _MANY_HELD = 0.01, 0.05
"""Shares of what the objects change that are worth a remark: saturated in the photograph, and held back from black."""


@dataclass(frozen=True)
class CompositeSettings:
    """How a composite is made.

    Parameters
    ----------
    plate
        What is known of the plate.
    rgb
        Whether the ordinary RGB render is composed as well.
    denoised
        Whether the objects are taken without their noise, where the render was denoised.
    """

    plate: PlateSettings = field(default_factory=PlateSettings)
    rgb: bool = True
    denoised: bool = True


@dataclass(frozen=True)
class _Colours:
    """How the plate's linear pixels become tristimulus values in the unit of the render, and how those are shown.

    `to_xyz` (3, 3); `plate_xyz` (H, W, 3); `white` (3,) that the camera was balanced for, None where it does not say.
    """

    to_xyz: FloatArray
    plate_xyz: FloatArray
    white: FloatArray | None
    exposure: float


def composite(
    render_dir: Path, plate_path: Path | None, directory: Path, settings: CompositeSettings | None = None
) -> Job[Numbers]:
    """Put a finished render into a photograph, or before a panorama.

    Parameters
    ----------
    render_dir
        Folder of the render; a scene with shadow catchers has left its render without the objects in a folder within.
    plate_path
        The photograph, or probe.exr; None for the photograph of the scene's backplate.
    directory
        Folder for the files of `composite.outputs`.
    settings
        What is known of the plate besides.

    Returns
    -------
    dict
        The numbers of composite.json, and where it was written.

    Raises
    ------
    SpectralProbeError
        If the render or the plate cannot be used; the message says what to do.
    """
    directory = Path(directory)
    with folder_lock(directory):
        return (yield from _compose(Path(render_dir), plate_path, directory, settings or CompositeSettings()))


def _compose(
    render_dir: Path, plate_path: Path | None, directory: Path, settings: CompositeSettings
) -> Job[Numbers]:
    yield Progress(0.0, "Reading the render")
    backplate = read_backplate(render_dir)
    renders = render_pair(render_dir, backplate)
    plate_path = _plate_path(plate_path, backplate)
    yield Progress(0.1, f"Reading {plate_path.name}")
    panorama = is_probe(plate_path)
    plate = (
        panorama_plate(plate_path, backplate)
        if panorama
        else read_plate(plate_path, settings.plate, backplate)
    )
    _check_size(plate, renders, plate_path)
    yield Progress(0.2, "Projecting the render through the camera")
    seen = renders.camera_rgb(plate.sensitivities)
    _check_lit(seen, renders.coverage)
    yield Progress(0.4, "Composing")
    in_eye = renders.xyz()
    colours = _colours(plate, seen, in_eye)
    calm = renders.denoised_xyz() if settings.denoised else None
    calm_seen = None if calm is None else _denoised_seen(calm, plate, seen[0], in_eye[0], renders, colours)
    found = _composed(renders, plate.pixels, _scaled(seen, plate.scale), calm_seen)
    yield Progress(0.6, "Composing tristimulus values")
    xyz = (
        _in_xyz(found.pixels, plate, colours.to_xyz)
        if is_rec709(plate.sensitivities)
        else _composed(renders, colours.plate_xyz, in_eye, calm).pixels
    )
    yield Progress(0.75, "Writing the composite")
    with written_together(directory, last=NUMBERS_NAME, stale=_RGB_NAMES) as folder:
        write_linear(folder / "plate.exr", plate.pixels, plate.camera, "the photograph")
        write_linear(folder / "composite.exr", found.pixels, plate.camera, "photograph and virtual objects")
        write_rgb(folder / "composite_xyz.exr", xyz, ("X", "Y", "Z"))
        write_png(folder / "composite.png", _picture(plate, found, xyz, colours))
        write_difference(folder, plate, found)
        yield Progress(0.85, "Composing the RGB render")
        remarks = [*plate.remarks, *_remarks(plate, found, renders)]
        if settings.rgb and renders.has_rgb:
            _rgb_composite(folder, renders, plate, colours)
            if calm is not None:
                remarks.append(_RGB_NOT_DENOISED)
        numbers = _numbers(plate, found, renders) | {
            "denoised_objects": calm is not None,
            "display_exposure": None if plate.converted else colours.exposure,
            "remarks": remarks,
        }
        write_numbers(folder / NUMBERS_NAME, numbers)
    return {**numbers, "written": str(directory)}


# ---------------------------------------------------------------- what must fit


def _plate_path(given: Path | None, backplate: Backplate | None) -> Path:
    if given is not None:
        return Path(given)
    if backplate is None or backplate.photo == Path():
        raise RenderError(
            "The scene has no backplate, so nothing says which photograph is meant. Give one: --plate PHOTO, or Photograph in "
            "the Composite panel."
        )
    return backplate.photo


def _check_size(plate: Plate, renders: RenderPair, path: Path) -> None:
    height, width = renders.coverage.coverage.shape
    own_height, own_width = plate.pixels.shape[:2]
    if (own_width, own_height) != (width, height):
        raise RenderError(
            f"{path.name} is {own_width} x {own_height} pixels, the render {width} x {height}. Render at the size of the "
            "plate, or make a backplate, which may be reduced in size."
        )


def _check_lit(seen: Pair, coverage: ObjectCoverage) -> None:
    if any(image is not None and not np.isfinite(image).all() for image in seen):
        raise RenderError("The render holds values that are not numbers. Render the scene again.")
    if not (seen[0][coverage.coverage > 0] > 0).any():
        raise RenderError("The render is black where the objects are. Check the light, and render again.")


# ---------------------------------------------------------------- colours


def _scaled(pair: Pair, scale: FloatArray) -> Pair:
    with_, without = pair
    factor = np.asarray(scale, np.float32)
    return with_ * factor, None if without is None else without * factor


def _composed(
    renders: RenderPair, plate: FloatArray, pair: Pair, denoised: FloatArray | None = None
) -> Composite:
    return differential(
        plate, *pair, renders.coverage, without_alpha=renders.without_alpha, denoised=denoised
    )


def _denoised_seen(
    calm: FloatArray, plate: Plate, seen: FloatArray, xyz: FloatArray, renders: RenderPair, colours: _Colours
) -> FloatArray:
    """Denoised tristimulus values (H, W, 3) in the plate's linear pixels; of Rec.709 exactly, of others as near as can be."""
    if is_rec709(plate.sensitivities):
        rgb = xyz_to_rec709(calm)
    else:
        rgb = denoised_in_camera(calm, xyz, seen, renders.coverage, np.linalg.inv(colours.to_xyz))
    return np.asarray(rgb * np.asarray(plate.scale, np.float32), np.float32)


def _in_xyz(pixels: FloatArray, plate: Plate, to_xyz: FloatArray) -> FloatArray:
    """Linear pixels (H, W, 3) of the plate as tristimulus values in the unit of the render."""
    return np.asarray(pixels @ (to_xyz / plate.scale).T.astype(np.float32), np.float32)


def _colours(plate: Plate, seen: Pair, in_eye: Pair) -> _Colours:
    # The ground without objects tells of the light what coloured objects do not.
    rgb, xyz = (pair[0] if pair[1] is None else pair[1] for pair in (seen, in_eye))
    to_xyz = camera_to_xyz(plate.sensitivities, rgb, xyz)
    plate_xyz = _in_xyz(plate.pixels, plate, to_xyz)
    white = None if plate.neutral is None else np.asarray(to_xyz @ (plate.neutral / plate.scale))
    if white is not None and not white.min() > 0:
        white = None
    return _Colours(to_xyz, plate_xyz, white, display_exposure(plate_xyz))


def _picture(plate: Plate, found: Composite, xyz: FloatArray, colours: _Colours) -> Picture:
    return picture_of(plate, found, xyz, colours.white, colours.exposure)


def _rgb_composite(directory: Path, renders: RenderPair, plate: Plate, colours: _Colours) -> None:
    """Write the composite of the ordinary RGB render, linear Rec.709 in the unit of image.exr."""
    found = _composed(renders, xyz_to_rec709(colours.plate_xyz), renders.rgb())
    linear, picture = (directory / name for name in _RGB_NAMES)
    write_linear(linear, found.pixels, "Rec.709", "photograph and RGB render")
    xyz = np.asarray(rec709_to_xyz(found.pixels), np.float32)
    back = np.linalg.inv(colours.to_xyz / plate.scale)
    shown = replace(found, pixels=np.asarray(xyz @ back.T.astype(np.float32), np.float32))
    write_png(picture, _picture(plate, shown, xyz, colours))


# ---------------------------------------------------------------- what is told


def _remarks(plate: Plate, found: Composite, renders: RenderPair) -> list[str]:
    """Sentences on what in the composite is less than right."""
    told, shaded = [], found.weight > 0
    lost = float(np.mean(plate.clipped[shaded])) if shaded.any() else 0.0
    if lost > _MANY_CLIPPED:
        told.append(
            f"{lost:.0%} of what the objects change is saturated in the photograph: shadows come out too dark there. "
            "Expose it shorter."
        )
    held = float(np.mean(found.limited[shaded])) if shaded.any() else 0.0
    if held > _MANY_HELD:
        told.append(
            f"In {held:.0%} of what the objects change the photograph is far darker than the ground as rendered: the shadow was "
            "held back. Check the ground's reflectance and the exposure."
        )
    if renders.without is None:
        told.append("The scene has no shadow catcher: the objects cast no shadow on the photograph.")
    return told


def _numbers(plate: Plate, found: Composite, renders: RenderPair) -> Numbers:
    height, width = found.weight.shape
    measured = "sRGB" if plate.log_gain is None else "measured"
    return {
        "size": [width, height],
        "camera": plate.camera,
        "response": measured if plate.converted else "linear",
        "pixels_per_unit": [float(value) for value in plate.scale],
        "objects": {name: float(plane.mean()) for name, plane in renders.coverage.objects.items()},
        "changed_fraction": float(found.changed.mean()),
        "shadow_held_fraction": float(found.limited.mean()),
        "clipped_fraction": float(plate.clipped.mean()),
        "lens_distortion": renders.lens.bends,
    }

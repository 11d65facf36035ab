"""The verb `compare`: a spectral and an RGB render beside each other in pictures and numbers, and fig. 13 of the paper."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .commands import TristimulusImage, read_tristimulus
from .composite_model import OBJECTS_NAME
from .errors import FileFormatError
from .files.atomic import written_together
from .files.json_object import UNREADABLE, read_object
from .files.lock import folder_lock
from .files.objects_exr import read_objects
from .light_choice import REPORT_NAME, NamedLight, chosen_light, light_of_render
from .model import BoolArray, Job, Progress
from .render.compare import Comparison, compare_images, comparison_report, write_comparison
from .render.rgb_ways import compare_rgb_ways, metal_reflectances, ways_report
from .spectra.colorimetry import spectra_to_xyz

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .figures.sheet import SheetContent

type Numbers = dict[str, Any]

DEFAULT_METALS = ("gold", "silver", "copper")
DEFAULT_LIGHT = "D65"

_COVERED = 0.5
"""A pixel belongs to the object that covers more than this share of it."""

_SUFFIXES = (".png", ".svg")


@dataclass(frozen=True)
class CompareSettings:
    """What a comparison shows.

    Parameters
    ----------
    blur_px
        Standard deviation of a Gaussian blur of both images against noise.
    light, at, region_path
        The light of the four ways of RGB, as in `chosen_light`; empty: the mean light of the render, or D65 where its folder
        does not tell.
    metals
        Names of the metals in it.
    split
        Where the wipe changes from spectral to RGB, 0..1 of the width.
    """

    blur_px: float = 0.0
    light: str = ""
    at: tuple[float, float] | None = None
    region_path: Path | None = None
    metals: tuple[str, ...] = DEFAULT_METALS
    split: float = 0.5


def compare(
    spectral_path: Path, rgb_path: Path, directory: Path, settings: CompareSettings | None = None
) -> Job[Numbers]:
    """Two renders of one scene to a folder: sheet, wipe, dE2000 map, xy diagrams (PNG and SVG), and compare.json.

    objects.exr beside the spectral render tells which pixels show which object.

    Raises
    ------
    FileFormatError
        If an image cannot be read, shows nothing, or has another size than the other.
    SpectralDataError
        If the light or a metal is not known.
    """
    with folder_lock(directory):
        return (yield from _compare(spectral_path, rgb_path, directory, settings or CompareSettings()))


def _compare(spectral_path: Path, rgb_path: Path, directory: Path, settings: CompareSettings) -> Job[Numbers]:
    from .figures.sheet import SheetContent

    yield Progress(0.02, "Reading the renders")
    pair = read_pair(spectral_path, rgb_path)
    spectral, rgb = (image.xyz for image in pair)
    light, adapted_white = _light(settings, spectral_path.parent)
    ways = compare_rgb_ways(metal_reflectances(settings.metals), light.spectrum, light.name)
    yield Progress(0.1, "Computing colour differences")
    comparison, remarks = compare_pair(pair, (spectral_path, rgb_path), settings.blur_px)
    further = {"rgb_ways": ways_report(ways), "split": settings.split, "remarks": remarks}
    content = SheetContent(
        comparison,
        spectral,
        rgb,
        ways,
        split=settings.split,
        adapted_white=adapted_white,
        numbers=_render_numbers(spectral_path.parent, spectral.shape),
    )
    with written_together(directory, last="compare.json") as folder:
        write_comparison(folder / "compare.json", comparison, further)
        yield from draw_comparison(folder, content)
    return {**comparison_report(comparison), **further, "written": str(directory)}


def read_pair(spectral_path: Path, rgb_path: Path) -> tuple[TristimulusImage, TristimulusImage]:
    """The spectral and the RGB render of one scene.

    Raises
    ------
    FileFormatError
        If one cannot be read, or has another size than the other.
    """
    pair = read_tristimulus(spectral_path), read_tristimulus(rgb_path)
    spectral, rgb = (image.xyz for image in pair)
    if spectral.shape != rgb.shape:
        raise FileFormatError(
            f"{spectral_path.name} is {spectral.shape[1]} x {spectral.shape[0]} pixels, {rgb_path.name} is "
            f"{rgb.shape[1]} x {rgb.shape[0]} pixels. Compare renders of one size."
        )
    return pair


def compare_pair(
    pair: tuple[TristimulusImage, TristimulusImage], paths: tuple[Path, Path], blur_px: float
) -> tuple[Comparison, list[str]]:
    """The comparison of two renders read from files, and what is to be said of it.

    objects.exr beside the first tells which pixels show which object.

    Raises
    ------
    FileFormatError
        If an image shows nothing.
    """
    spectral, rgb = (image.xyz for image in pair)
    masks, told = object_masks(paths[0].parent, spectral.shape[:2])
    comparison = compare_images(spectral, rgb, object_masks=masks, blur_px=blur_px)
    return comparison, [
        *(remark for image in pair for remark in image.remarks),
        *told,
        *_not_finite(comparison, (paths[0].name, paths[1].name)),
    ]


def draw_comparison(directory: Path, content: SheetContent) -> Job[None]:
    """Draw everything about a comparison into a folder.

    sheet, delta_e, chromaticity and rgb_ways as PNG and SVG; spectral.png, rgb.png and wipe.png as large as the renders.
    """
    from .figures.chromaticity import chromaticity_figure, shifts_of
    from .figures.difference import delta_e_figure
    from .figures.display import write_png
    from .figures.pair import shown_pair, wipe_picture
    from .figures.rgb_ways import rgb_ways_figure
    from .figures.sheet import comparison_sheet
    from .figures.style import save_figure

    comparison = content.comparison
    yield Progress(0.3, "Drawing the wipe")
    spectral, rgb = shown_pair(comparison, content.xyz_spectral, content.xyz_rgb, content.adapted_white)
    pictures = {"spectral": spectral, "rgb": rgb, "wipe": wipe_picture(spectral, rgb, content.split)}
    for name, picture in pictures.items():
        write_png(directory / f"{name}.png", picture, quick=True)
    figures: Mapping[str, Callable[[], Figure]] = {
        "delta_e": lambda: delta_e_figure(comparison),
        "chromaticity": lambda: chromaticity_figure(shifts_of(comparison)),
        "rgb_ways": lambda: rgb_ways_figure(content.ways),
        "sheet": lambda: comparison_sheet(content),
    }
    for index, (name, drawn) in enumerate(figures.items()):
        yield Progress(0.4 + 0.15 * index, f"Drawing {name}")
        figure = drawn()
        for suffix in _SUFFIXES:
            save_figure(figure, directory / f"{name}{suffix}")


def write_wipe(directory: Path, split: float) -> Path:
    """Write wipe.png of a comparison's folder anew, divided at a share of the width; returns its path.

    Raises
    ------
    FileFormatError
        If the folder has no comparison.
    """
    from .figures.display import read_png, write_png
    from .figures.pair import wipe_picture

    left, right = (read_png(directory / f"{name}.png") for name in ("spectral", "rgb"))
    write_png(directory / "wipe.png", wipe_picture(left, right, split), quick=True)
    return directory / "wipe.png"


def object_masks(directory: Path, size: tuple[int, ...]) -> tuple[dict[str, BoolArray], list[str]]:
    """Masks (H, W) of the objects in a render's folder by name, and sentences on why there are none.

    A pixel belongs to an object that covers more than half of it.
    """
    path = directory / OBJECTS_NAME
    if not path.is_file():
        return {}, []
    found = read_objects(path)
    if found.coverage.shape != size:
        height, width = found.coverage.shape
        return {}, [
            f"{OBJECTS_NAME} is {width} x {height} pixels, the renders {size[1]} x {size[0]}: there are no numbers by object."
        ]
    return {name: plane > _COVERED for name, plane in found.objects.items()}, []


def _light(settings: CompareSettings, directory: Path) -> tuple[NamedLight, Any]:
    """The light of the four ways; and, where it is the render's own, its XYZ to white-balance the pictures by, else None."""
    own = light_of_render(directory)
    white = None if own is None else spectra_to_xyz(own.spectrum)
    if settings.light:
        return chosen_light(settings.light, settings.at, settings.region_path), white
    return own or chosen_light(DEFAULT_LIGHT, settings.at, settings.region_path), white


def _not_finite(comparison: Comparison, names: tuple[str, str]) -> list[str]:
    """A sentence for each image with pixels that are not numbers."""
    return [
        f"{count} pixel{'s' if count > 1 else ''} of {name} {'are not numbers' if count > 1 else 'is not a number'} and left "
        "out: hatched in the map."
        for name, count in zip(names, comparison.not_finite, strict=True)
        if count
    ]


def _render_numbers(directory: Path, size: tuple[int, ...]) -> dict[str, str]:
    """What the sheet says of the renders: their size, and what report.json beside them tells of time and samples."""
    numbers = {"size": f"{size[1]} x {size[0]} px"}
    try:
        report = read_object(directory / REPORT_NAME)
        seconds = report["seconds"]
        numbers["spectral render"] = f"{seconds['spectral']:.1f} s, {report['passes']} passes"
        numbers["RGB render"] = f"{seconds['rgb']:.1f} s"
        numbers["samples"] = str(report["samples"])
    except UNREADABLE:  # images may lie in any folder, beside any report.json
        return numbers
    return numbers

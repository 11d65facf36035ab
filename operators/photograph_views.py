"""Photographs in views, in the settings of a scene: put there, placed round the ball, and told of in words."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..spectral_probe.geometry.bearings import are_even, bearings_between_deg, even_bearings_deg
from .settings import add_photos

if TYPE_CHECKING:  # heavy: imported where it is used
    from ..spectral_probe.photo.grouping import Grouping, ViewGroup
    from ..spectral_probe.photo.metadata import PhotoRecord

_NAMED = 4  # so many files, views or bearings are named in a sentence, the others counted


def paths_in(settings: bpy.types.PropertyGroup) -> set[Path]:
    """The photographs that the scene has already."""
    return {
        Path(bpy.path.abspath(photo.path)).resolve()
        for view in settings.views
        for photo in view.photos
        if photo.path
    }


_FULL_FRAME_MM = 36.0
_TELEPHONE_MM = 9.0
"""A shorter lens belongs to a telephone or a compact camera, whose small sensor sees as much as..."""
_EQUIVALENT_MM = 27.0
"""...this lens does on full frame."""


def add_views(settings: bpy.types.PropertyGroup, groups: Sequence[ViewGroup]) -> None:
    """Append views, make the first of them active, and give them bearings."""
    before = len(settings.views)
    for group in groups:
        add_photos(settings.views.add(), [record.path for record in group.photos])
    place_views(settings, range(before, len(settings.views)))
    settings.active_view = before if groups else settings.active_view


def name_view(view: bpy.types.PropertyGroup) -> None:
    """Name a view that has no name after its first photograph."""
    if not view.name and view.photos:
        view.name = Path(view.photos[0].path).stem


def place_views(settings: bpy.types.PropertyGroup, new: range) -> None:
    """Give new views bearings: all views evenly where nobody has set any, else the new ones in the widest gaps."""
    views = settings.views
    known_deg = [math.degrees(view.azimuth) for number, view in enumerate(views) if number not in new]
    if are_even(known_deg) and not settings.capture_path:
        placed = list(zip(views, even_bearings_deg(len(views)), strict=True))
    else:
        bearings_deg = bearings_between_deg(known_deg, len(new))
        placed = [(views[number], bearing_deg) for number, bearing_deg in zip(new, bearings_deg, strict=True)]
    for view, bearing_deg in placed:
        view.azimuth = math.radians(bearing_deg)


def assume_equal_exposures(settings: bpy.types.PropertyGroup, groups: Sequence[ViewGroup]) -> bool:
    """Give views of one photograph each, none of which says its exposure, the same one; whether that was so."""
    records = [record for group in groups for record in group.photos]
    if len(records) != len(groups) or any(not _unexposed(record) for record in records):
        return False
    if len(settings.views) > len(groups):  # others are there, whose exposures mean something
        return False
    for view in settings.views:
        view.photos[0].exposure_s = 1.0
    return bool(records)


def choose_camera(settings: bpy.types.PropertyGroup, model: str) -> None:
    """Choose the camera that took the photographs, unless one was chosen already."""
    camera = settings.camera
    if model and not camera.model and not camera.sensitivities:
        camera.model = model


def folders_beside(settings: bpy.types.PropertyGroup, folder: Path) -> None:
    """Write probe and render beside the photographs while there is no .blend to write beside."""
    if bpy.data.filepath:
        return
    for name in ("probe", "render"):
        # Only what still stands at its default, which is relative to the .blend.
        if getattr(settings, f"{name}_directory").startswith("//"):
            parent = folder if os.access(folder, os.W_OK) else Path(bpy.app.tempdir)
            setattr(settings, f"{name}_directory", str(parent / name))


def assume_lens(settings: bpy.types.PropertyGroup, groups: Sequence[ViewGroup]) -> list[str]:
    """Where nothing says how wide the sensor is, or how long the lens, put what is usual into the camera's settings.

    Returns
    -------
    list of str
        A sentence on what was assumed and what it does; none where nothing was.
    """
    camera = settings.camera
    records = [record for group in groups for record in group.photos]
    if camera.focal_source != "EXIF" or camera.sensor_width_mm or any(r.has_sensor_width for r in records):
        return []
    lenses_mm = [record.focal_mm for record in records if record.focal_mm]
    camera.sensor_width_mm = _FULL_FRAME_MM
    if lenses_mm and max(lenses_mm) < _TELEPHONE_MM:
        camera.sensor_width_mm = round(_FULL_FRAME_MM * lenses_mm[0] / _EQUIVALENT_MM, 1)
    if len(lenses_mm) == len(records):
        text = rpt_(
            "The photographs do not say how wide the sensor is: {sensor:.3g} mm is assumed. If it is smaller or they "
            "are cut, directions near the ball's rim are off by degrees: correct it in World > Capture > Camera"
        )
    else:
        camera.focal_source = "MM"
        text = rpt_(
            "The photographs do not say their lens: {focal:g} mm on a sensor {sensor:.3g} mm wide is assumed. If it is another, "
            "or they are cut, directions near the ball's rim are off by degrees: correct it in World > Capture > Camera"
        )
    return [text.format(focal=camera.focal_mm, sensor=camera.sensor_width_mm)]


def summary(settings: bpy.types.PropertyGroup, photographs: int) -> str:
    """How many views of how many photographs there are now, and from where they are taken to look."""
    views = len(settings.views)
    if views == 1:
        return rpt_("{photographs} photographs in one view").format(photographs=photographs)
    bearings = ", ".join(f"{math.degrees(view.azimuth):.4g}°" for view in settings.views[:_NAMED])
    bearings += ", ..." if views > _NAMED else ""
    return rpt_(
        "{photographs} photographs in {views} views, taken to look at bearings {bearings}: correct them in World > Capture"
    ).format(photographs=photographs, views=views, bearings=bearings)


def remarks(grouping: Grouping, first: int, equal: bool, camera_model: str) -> list[str]:
    """What the user should look at: one sentence for each kind of doubt; views are numbered from `first`."""
    told = []
    views = grouping.views
    if len(grouping.cameras) > 1:
        told.append(
            rpt_(
                "These are of {count} cameras ({names}), a capture is of one: remove the views of the others"
            ).format(count=len(grouping.cameras), names=", ".join(grouping.cameras))
        )
    if grouping.beside_raw:
        told.append(
            rpt_("{files} left out: the raw file of the same photograph is there").format(
                files=named([record.name for record in grouping.beside_raw])
            )
        )
    numbers = [first + number for number, view in enumerate(views) if "uneven" in view.hints]
    if numbers and len(views) > 1:
        text = rpt_("{views} with another number of exposures than most: move photographs where they belong")
        told.append(text.format(views=numbered(numbers)))
    unexposed = [record.name for view in views for record in view.photos if _unexposed(record)]
    if equal:
        told.append(rpt_("No exposure is stated: all photographs are taken to be exposed alike"))
    elif unexposed:
        told.append(
            rpt_(
                "Told apart by names, for want of an exposure time: {files}. Give the times in Photographs"
            ).format(files=named(unexposed))
        )
    records = [record for view in views for record in view.photos]
    if any(record.encoding == "raw" for record in records) and not camera_model:
        told.append(rpt_("Choose the camera: raw photographs need its spectral sensitivities"))
    return told


def named(names: Sequence[str]) -> str:
    """Some file names in a sentence, the rest counted.

    Examples
    --------
    >>> named(["a.jpg", "b.jpg"]), named(["a.jpg", "b.jpg", "c.jpg", "d.jpg", "e.jpg", "f.jpg"])
    ('a.jpg, b.jpg', 'a.jpg, b.jpg, c.jpg, d.jpg and 2 more')
    """
    text = ", ".join(names[:_NAMED])
    if len(names) <= _NAMED:
        return text
    return rpt_("{names} and {count} more").format(names=text, count=len(names) - _NAMED)


def numbered(numbers: Sequence[int]) -> str:
    """Some views in a sentence, by number.

    Examples
    --------
    >>> numbered([2]), numbered([1, 2, 3, 4, 5])
    ('View 2', 'Views 1, 2, 3, 4 and 1 more')
    """
    form = rpt_("View {numbers}") if len(numbers) == 1 else rpt_("Views {numbers}")
    return form.format(numbers=named([str(number) for number in numbers]))


def _unexposed(record: PhotoRecord) -> bool:
    return record.exposure is None and record.encoding != "radiance"

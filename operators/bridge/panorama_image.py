"""The panorama's picture in the Image Editor: the image, and which direction lies under the mouse."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy

from ..settings import probe_folder
from .image_space import ImageSpace
from .opened_probe import MEMORY

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    type Array = NDArray[np.floating[Any]]

NAME = "Spectral Probe Panorama"
_MARK = "spectral_probe_panorama"
"""Custom property of the image: which picture it shows."""

PICTURES = {"LIGHT": "preview.png", "CONFIDENCE": "confidence.png", "KINDS": "kinds.png"}
"""Pictures of a panorama, and their files in the probe's folder. Some have a legend below."""


def picture_of(image: bpy.types.Image | None) -> str:
    """Which picture of a panorama an image shows; empty where it is another image."""
    kind = image.get(_MARK, "") if image is not None else ""
    return kind if kind in PICTURES else ""


def load_picture(folder: Path, kind: str) -> bpy.types.Image:
    """The image with a picture of the probe in a folder, in place of the one it showed."""
    path = folder / PICTURES[kind]
    image = bpy.data.images.get(NAME)
    if image is None:
        image = bpy.data.images.load(str(path))
        image.name = NAME
    else:
        image.filepath = str(path)
        image.reload()
    image[_MARK] = kind
    MEMORY.picture = path
    return image


def follow_picture(settings: bpy.types.PropertyGroup) -> None:
    """Show the light as it is now in the panorama's image, where there is one."""
    image = bpy.data.images.get(NAME)
    kind = picture_of(image)
    if not kind or not settings.probe_directory:
        return
    folder = probe_folder(settings)
    kind = kind if (folder / PICTURES[kind]).is_file() else "LIGHT"
    path = folder / PICTURES[kind]
    shown = Path(bpy.path.abspath(image.filepath))
    if path.is_file() and not (shown == path == MEMORY.picture):
        load_picture(folder, kind)


@bpy.app.handlers.persistent
def follow_undo(scene: bpy.types.Scene, *_: Any) -> None:
    """Undo and redo bring back the image's path, not its pixels."""
    if scene is not None and MEMORY.picture is not None:
        follow_picture(scene.spectral_probe)


@dataclass(frozen=True)
class PanoramaView:
    """Where a panorama's picture lies in a region: `left`, `bottom`, and its `width` and `height` without legend, in pixels."""

    left: float
    bottom: float
    width: float
    height: float

    def bearing_at(self, x: float, y: float) -> tuple[float, float] | None:
        """Bearing and elevation in degrees under a point of the region; None beside the picture."""
        from ...spectral_probe.geometry.arcs import picture_to_bearing

        across, up = (x - self.left) / self.width, (y - self.bottom) / self.height
        if not (0.0 <= across <= 1.0 and 0.0 <= up <= 1.0):
            return None
        azimuth, elevation = picture_to_bearing([across, up])
        return float(azimuth), float(elevation)

    def placed(self, points: Array) -> Array:
        """Points (..., 2) of the picture in pixels of the region."""
        import numpy as np

        return np.asarray(
            points * np.array([self.width, self.height]) + [self.left, self.bottom], dtype=np.float32
        )


def view_in(region: bpy.types.Region, image: bpy.types.Image) -> PanoramaView | None:
    """Where the panorama of an image lies in a region of an Image Editor; None where it has no pixels."""
    columns, rows = image.size
    if not columns or rows < columns // 2 or min(region.width, region.height) < 2:
        return None
    space, panorama_rows = ImageSpace.of(region, (columns, rows)), columns // 2  # a legend is below
    left, bottom = space.to_region(0, panorama_rows)
    return PanoramaView(left, bottom, columns * space.scale_x, panorama_rows * space.scale_y)


def panorama_regions(window: bpy.types.Window | None) -> Iterator[tuple[bpy.types.Region, PanoramaView]]:
    """The regions of a window in which the panorama is shown."""
    for area in window.screen.areas if window is not None else ():
        if area.type != "IMAGE_EDITOR" or not picture_of(area.spaces.active.image):
            continue
        region = next(region for region in area.regions if region.type == "WINDOW")
        view = view_in(region, area.spaces.active.image)
        if view is not None:
            yield region, view


def region_under(
    window: bpy.types.Window | None, x: int, y: int
) -> tuple[bpy.types.Region, PanoramaView] | None:
    """The region with the panorama under a point of a window, not under its sidebar; None where there is none."""
    for region, view in panorama_regions(window):
        area = next(area for area in window.screen.areas if region in area.regions[:])
        over = [other for other in area.regions if other.type != "WINDOW" and _inside(other, x, y)]
        if _inside(region, x, y) and not over:
            return region, view
    return None


def _inside(region: bpy.types.Region, x: int, y: int) -> bool:
    return 0 <= x - region.x < region.width and 0 <= y - region.y < region.height and region.width > 1


def redraw_panoramas(window_manager: bpy.types.WindowManager) -> None:
    """Draw all Image Editors anew."""
    for window in window_manager.windows:
        for area in window.screen.areas:
            if area.type == "IMAGE_EDITOR":
                area.tag_redraw()

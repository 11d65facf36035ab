"""Between pixels of a photograph and pixels of an Image Editor's region.

A photograph's origin is its top left corner and y points down, its pixel centres lie at integer + 0.5. A region's origin is its
bottom left corner and y points up, and so it is in Blender's image space, where an image spans 0 to 1 in both directions.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import bpy


@dataclass(frozen=True)
class ImageSpace:
    """Where a photograph lies in a region: its left upper corner, and region pixels for each of its pixels."""

    left: float
    top: float
    scale_x: float
    scale_y: float

    @classmethod
    def of(cls, region: bpy.types.Region, size_px: Iterable[int]) -> ImageSpace:
        """The space of an Image Editor's main region that shows a photograph of (width, height), now.

        Blender's view shows the part of image space between two corners. `region_to_view` puts the second one at the last
        pixel's index, where drawing puts it at the region's edge: corners are asked for there, and used as drawing does.
        """
        width, height = size_px
        low = region.view2d.region_to_view(0, 0)
        high = region.view2d.region_to_view(region.width - 1, region.height - 1)
        return cls.of_view((low[0], low[1], high[0], high[1]), (region.width, region.height), (width, height))

    @classmethod
    def of_view(
        cls,
        view: tuple[float, float, float, float],
        region_px: tuple[int, int],
        size_px: tuple[int, int],
    ) -> ImageSpace:
        """The space where a region of (width, height) shows image space from (left, bottom) to (right, top).

        Examples
        --------
        >>> space = ImageSpace.of_view((0.0, 0.0, 1.0, 1.0), (800, 400), (400, 200))  # the whole photograph, twice as large
        >>> space.to_region(0.0, 0.0), space.to_region(400.0, 200.0), space.to_photograph(1.0, 399.0)
        ((0.0, 400.0), (800.0, 0.0), (0.5, 0.5))
        """
        left, bottom, right, top = view
        across, up = (
            region_px[0] / (right - left),
            region_px[1] / (top - bottom),
        )  # region pixels for the image's width
        return cls(-left * across, (1.0 - bottom) * up, across / size_px[0], up / size_px[1])

    def moved(self, shift_px: tuple[float, float]) -> ImageSpace:
        """The space of pixels that lie `shift_px` (x, y) further in the photograph."""
        left, top = self.to_region(*shift_px)
        return ImageSpace(left, top, self.scale_x, self.scale_y)

    def to_region(self, x_px: float, y_px: float) -> tuple[float, float]:
        """A place in the photograph in region pixels."""
        return self.left + x_px * self.scale_x, self.top - y_px * self.scale_y

    def to_photograph(self, region_x: float, region_y: float) -> tuple[float, float]:
        """A place in the region in pixels of the photograph: the inverse of `to_region`."""
        return (region_x - self.left) / self.scale_x, (self.top - region_y) / self.scale_y

    def of_mouse(self, event: bpy.types.Event, region: bpy.types.Region) -> tuple[float, float]:
        """Where the mouse points in the photograph: the middle of the region's pixel that it is on."""
        return self.to_photograph(event.mouse_x - region.x + 0.5, event.mouse_y - region.y + 0.5)

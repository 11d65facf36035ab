"""From the pinhole frame that Blender renders to the picture that the plate's lens made."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from ..composite_model import Backplate
from ..errors import RenderError
from ..geometry.camera import pixel_rays, project
from ..model import FloatArray

_ROWS_AT_ONCE = 128


class Lens:
    """Bends renders of a backplate's frame as the lens bends: the inverse of undistorting the plate.

    Without distortion, and with the frame being the picture, renders come back as they are.
    """

    def __init__(self, backplate: Backplate | None) -> None:
        self._maps: tuple[FloatArray, FloatArray] | None = None
        self._frame: tuple[int, int] | None = None
        if backplate is None:
            return
        left, top, width, height = backplate.frame_px
        self._frame = (width, height)
        if any(backplate.camera.distortion) or (left, top, (width, height)) != (
            0.0,
            0.0,
            backplate.camera.size_px,
        ):
            self._maps = _frame_places(backplate)

    @property
    def bends(self) -> bool:
        """Whether renders are resampled."""
        return self._maps is not None

    def picture(self, render: FloatArray) -> FloatArray:
        """A render (H, W) or (H, W, C) of the frame, premultiplied, as the plate's picture would show it.

        Raises
        ------
        RenderError
            If the render is not of the frame's size.
        """
        if self._frame is not None and render.shape[1::-1] != self._frame:
            raise RenderError(
                f"The render has {render.shape[1]} x {render.shape[0]} pixels, its backplate asks for {self._frame[0]} x "
                f"{self._frame[1]}. Render at the resolution that the backplate set."
            )
        if self._maps is None:
            return render
        columns, rows = self._maps
        return np.asarray(
            cv2.remap(
                np.asarray(render, np.float32),
                columns,
                rows,
                cv2.INTER_LINEAR,
                borderMode=cv2.BORDER_REPLICATE,
            )
        )


def _frame_places(backplate: Backplate) -> tuple[FloatArray, FloatArray]:
    """Column and row (H, W) float32 in the frame, counted from the centre of its first pixel, of each pixel of the picture."""
    camera = backplate.camera
    straight = replace(camera, distortion=(0.0,) * 5)
    width, height = camera.size_px
    left, top, _, _ = backplate.frame_px
    places = np.empty((height, width, 2), np.float32)
    for start in range(0, height, _ROWS_AT_ONCE):
        rows = np.arange(start, min(start + _ROWS_AT_ONCE, height)) + 0.5
        points = np.stack(np.meshgrid(np.arange(width) + 0.5, rows), -1)
        places[start : start + len(rows)] = project(straight, pixel_rays(camera, points))
    return (
        np.ascontiguousarray(places[..., 0] - np.float32(left + 0.5)),
        np.ascontiguousarray(places[..., 1] - np.float32(top + 0.5)),
    )

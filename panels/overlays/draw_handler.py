"""A function that draws over the Image Editor's main region."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy


class DrawHandler:
    """Lets Blender call a function whenever it draws the Image Editor's main region; without a window nothing is drawn."""

    def __init__(self, draw: Callable[[], None]) -> None:
        self._draw = draw
        self._handle: Any = None

    def add(self) -> None:
        """Begin to draw; once, however often it is called."""
        if self._handle is None and not bpy.app.background:
            space = bpy.types.SpaceImageEditor
            self._handle = space.draw_handler_add(self._draw, (), "WINDOW", "POST_PIXEL")

    def remove(self) -> None:
        """Draw no more."""
        if self._handle is not None:
            bpy.types.SpaceImageEditor.draw_handler_remove(self._handle, "WINDOW")
            self._handle = None

"""What the panorama's tools do when Blender undoes, redoes or opens a file."""

import bpy

from .bridge.opened_probe import MEMORY, forget_probe
from .bridge.panorama_image import follow_undo

_HANDLERS = (("load_post", forget_probe), ("undo_post", follow_undo), ("redo_post", follow_undo))


def register() -> None:
    """Be told; once, however often it is called."""
    for name, handler in _HANDLERS:
        known = getattr(bpy.app.handlers, name)
        if handler not in known:
            known.append(handler)


def unregister() -> None:
    """Be told no more, and hold no probe."""
    for name, handler in _HANDLERS:
        known = getattr(bpy.app.handlers, name)
        if handler in known:
            known.remove(handler)
    MEMORY.forget()

"""What is drawn over pictures in the Image Editor. It draws, it never computes; editing is the operators'."""

import bpy

from .ball import draw_ball
from .ball_handles import SPECTRAL_PROBE_GGT_outline, SPECTRAL_PROBE_GT_handle
from .draw_handler import DrawHandler
from .panorama import draw_panorama

_CLASSES = (SPECTRAL_PROBE_GT_handle, SPECTRAL_PROBE_GGT_outline)
_OVERLAYS = (DrawHandler(draw_ball), DrawHandler(draw_panorama))


def register() -> None:
    """Add draw handlers and gizmos."""
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    for overlay in _OVERLAYS:
        overlay.add()


def unregister() -> None:
    """Take them away."""
    for overlay in _OVERLAYS:
        overlay.remove()
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)

"""What is drawn over pictures in the Image Editor. It draws, it never computes; editing is the operators'."""

import bpy

from .ball import BallOverlay
from .ball_handles import SPECTRAL_PROBE_GGT_outline, SPECTRAL_PROBE_GT_handle
from .panorama import PanoramaOverlay

_CLASSES = (SPECTRAL_PROBE_GT_handle, SPECTRAL_PROBE_GGT_outline)


def register() -> None:
    """Add draw handlers and gizmos."""
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    BallOverlay.add()
    PanoramaOverlay.add()


def unregister() -> None:
    """Take them away."""
    PanoramaOverlay.remove()
    BallOverlay.remove()
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)

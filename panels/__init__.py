"""Panels in the order of the pipeline. They draw, they never compute."""

import bpy

from . import overlays
from .backplate import SPECTRAL_PROBE_PT_backplate, SPECTRAL_PROBE_PT_ground
from .capture import (
    SPECTRAL_PROBE_PT_ball,
    SPECTRAL_PROBE_PT_camera,
    SPECTRAL_PROBE_PT_capture,
    SPECTRAL_PROBE_PT_lamps,
    SPECTRAL_PROBE_PT_photographs,
)
from .compare import SPECTRAL_PROBE_PT_compare
from .composite import SPECTRAL_PROBE_PT_composite
from .edits import SPECTRAL_PROBE_PT_edits, SPECTRAL_PROBE_UL_edits
from .image_ball import SPECTRAL_PROBE_PT_image_ball, SPECTRAL_PROBE_PT_image_overlay
from .known_light import SPECTRAL_PROBE_PT_calibration, SPECTRAL_PROBE_PT_region_lights
from .lists import (
    SPECTRAL_PROBE_UL_own_lights,
    SPECTRAL_PROBE_UL_photos,
    SPECTRAL_PROBE_UL_region_lights,
    SPECTRAL_PROBE_UL_views,
)
from .main import SPECTRAL_PROBE_PT_main
from .material import SPECTRAL_PROBE_PT_light, SPECTRAL_PROBE_PT_material
from .plots import SPECTRAL_PROBE_PT_plots
from .probe import SPECTRAL_PROBE_PT_probe, SPECTRAL_PROBE_PT_world
from .render import SPECTRAL_PROBE_PT_objects, SPECTRAL_PROBE_PT_render
from .swap import SPECTRAL_PROBE_PT_swap, SPECTRAL_PROBE_UL_swappable
from .torrance_sparrow import SPECTRAL_PROBE_PT_torrance_sparrow

_register_classes, _unregister_classes = bpy.utils.register_classes_factory(
    (
        SPECTRAL_PROBE_UL_views,
        SPECTRAL_PROBE_UL_photos,
        SPECTRAL_PROBE_UL_edits,
        SPECTRAL_PROBE_UL_own_lights,
        SPECTRAL_PROBE_UL_region_lights,
        SPECTRAL_PROBE_PT_main,
        SPECTRAL_PROBE_PT_capture,
        SPECTRAL_PROBE_PT_photographs,
        SPECTRAL_PROBE_PT_camera,
        SPECTRAL_PROBE_PT_lamps,
        SPECTRAL_PROBE_PT_region_lights,
        SPECTRAL_PROBE_PT_calibration,
        SPECTRAL_PROBE_PT_ball,
        SPECTRAL_PROBE_PT_probe,
        SPECTRAL_PROBE_PT_plots,
        SPECTRAL_PROBE_PT_edits,
        SPECTRAL_PROBE_PT_world,
        SPECTRAL_PROBE_PT_backplate,
        SPECTRAL_PROBE_PT_ground,
        SPECTRAL_PROBE_PT_objects,
        SPECTRAL_PROBE_PT_render,
        SPECTRAL_PROBE_UL_swappable,
        SPECTRAL_PROBE_PT_swap,
        SPECTRAL_PROBE_PT_composite,
        SPECTRAL_PROBE_PT_compare,
        SPECTRAL_PROBE_PT_material,
        SPECTRAL_PROBE_PT_light,
        SPECTRAL_PROBE_PT_torrance_sparrow,
        SPECTRAL_PROBE_PT_image_ball,
        SPECTRAL_PROBE_PT_image_overlay,
    )
)


def register() -> None:
    """Add the panels, and what is drawn over pictures."""
    _register_classes()
    overlays.register()


def unregister() -> None:
    """Take them away."""
    overlays.unregister()
    _unregister_classes()

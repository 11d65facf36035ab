"""Panels in the order of the pipeline, and entries of Blender's menus. They draw, they never compute."""

import bpy

from . import add_menu, import_menu, main_menu, overlays, preset_menus
from .add_menu import SPECTRAL_PROBE_MT_add_metal
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
from .files import SPECTRAL_PROBE_PT_files, draw_external_data
from .guide import SPECTRAL_PROBE_PT_main
from .image_ball import SPECTRAL_PROBE_PT_image_ball, SPECTRAL_PROBE_PT_image_overlay
from .known_light import SPECTRAL_PROBE_PT_calibration, SPECTRAL_PROBE_PT_region_lights
from .light_probe import SPECTRAL_PROBE_PT_light_probe
from .lists import (
    SPECTRAL_PROBE_UL_own_lights,
    SPECTRAL_PROBE_UL_photos,
    SPECTRAL_PROBE_UL_region_lights,
    SPECTRAL_PROBE_UL_views,
)
from .main_menu import STAGES, SPECTRAL_PROBE_MT_main
from .material import SPECTRAL_PROBE_PT_light, SPECTRAL_PROBE_PT_material
from .objects import SPECTRAL_PROBE_PT_objects
from .panorama import (
    SPECTRAL_PROBE_PT_other_regions,
    SPECTRAL_PROBE_PT_panorama,
    SPECTRAL_PROBE_PT_pick,
    SPECTRAL_PROBE_PT_region,
)
from .photo_menus import SPECTRAL_PROBE_MT_photos, SPECTRAL_PROBE_MT_views
from .plots import SPECTRAL_PROBE_PT_plots
from .preset_menus import (
    SPECTRAL_PROBE_PT_capture_presets,
    SPECTRAL_PROBE_PT_lamps_presets,
    SPECTRAL_PROBE_PT_render_presets,
)
from .probe import SPECTRAL_PROBE_PT_probe, SPECTRAL_PROBE_PT_world
from .render import SPECTRAL_PROBE_PT_render, draw_render_menu
from .swap import SPECTRAL_PROBE_PT_swap, SPECTRAL_PROBE_UL_swappable
from .swatches import (
    SPECTRAL_PROBE_PT_light_swatches,
    SPECTRAL_PROBE_PT_material_swatches,
    SPECTRAL_PROBE_UL_swatches,
)
from .torrance_sparrow import SPECTRAL_PROBE_PT_torrance_sparrow

_register_classes, _unregister_classes = bpy.utils.register_classes_factory(
    (
        SPECTRAL_PROBE_UL_views,
        SPECTRAL_PROBE_UL_photos,
        SPECTRAL_PROBE_UL_edits,
        SPECTRAL_PROBE_UL_own_lights,
        SPECTRAL_PROBE_UL_region_lights,
        SPECTRAL_PROBE_PT_main,
        SPECTRAL_PROBE_PT_light_probe,
        SPECTRAL_PROBE_PT_capture,
        SPECTRAL_PROBE_PT_photographs,
        SPECTRAL_PROBE_MT_views,
        SPECTRAL_PROBE_MT_photos,
        SPECTRAL_PROBE_PT_capture_presets,
        SPECTRAL_PROBE_PT_lamps_presets,
        SPECTRAL_PROBE_PT_render_presets,
        SPECTRAL_PROBE_PT_camera,
        SPECTRAL_PROBE_PT_lamps,
        SPECTRAL_PROBE_PT_region_lights,
        SPECTRAL_PROBE_PT_calibration,
        SPECTRAL_PROBE_PT_ball,
        SPECTRAL_PROBE_PT_probe,
        SPECTRAL_PROBE_PT_plots,
        SPECTRAL_PROBE_PT_world,
        SPECTRAL_PROBE_PT_edits,
        SPECTRAL_PROBE_PT_files,
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
        SPECTRAL_PROBE_UL_swatches,
        SPECTRAL_PROBE_PT_material_swatches,
        SPECTRAL_PROBE_PT_light_swatches,
        SPECTRAL_PROBE_MT_add_metal,
        *STAGES,
        SPECTRAL_PROBE_MT_main,
        SPECTRAL_PROBE_PT_torrance_sparrow,
        SPECTRAL_PROBE_PT_image_ball,
        SPECTRAL_PROBE_PT_image_overlay,
        SPECTRAL_PROBE_PT_panorama,
        SPECTRAL_PROBE_PT_pick,
        SPECTRAL_PROBE_PT_region,
        SPECTRAL_PROBE_PT_other_regions,
    )
)


def register() -> None:
    """Make panels, menu entries and what is drawn over pictures known to Blender."""
    _register_classes()
    bpy.types.TOPBAR_MT_render.append(draw_render_menu)
    bpy.types.TOPBAR_MT_file_external_data.append(draw_external_data)
    add_menu.register()
    import_menu.register()
    main_menu.register()
    preset_menus.register()
    overlays.register()


def unregister() -> None:
    """Take them back."""
    preset_menus.unregister()
    main_menu.unregister()
    import_menu.unregister()
    overlays.unregister()
    add_menu.unregister()
    bpy.types.TOPBAR_MT_file_external_data.remove(draw_external_data)
    bpy.types.TOPBAR_MT_render.remove(draw_render_menu)
    _unregister_classes()

"""Operators, one verb a file: each reads the settings, calls a function, keeps the result and reports."""

import bpy

from . import add_asset_library, command_line, open_modals, panorama_handlers, running_job
from .add_asset_library import (
    SPECTRAL_PROBE_OT_add_asset_library,
    SPECTRAL_PROBE_OT_remove_asset_library,
)
from .add_glass import SPECTRAL_PROBE_OT_add_glass
from .add_mask import SPECTRAL_PROBE_OT_add_mask
from .add_object import SPECTRAL_PROBE_OT_add_object
from .add_own_light import SPECTRAL_PROBE_OT_add_own_light, SPECTRAL_PROBE_OT_remove_own_light
from .add_region_light import SPECTRAL_PROBE_OT_add_region_light, SPECTRAL_PROBE_OT_remove_region_light
from .add_swappable import SPECTRAL_PROBE_OT_add_swappable, SPECTRAL_PROBE_OT_remove_swappable
from .add_torrance_sparrow import SPECTRAL_PROBE_OT_add_torrance_sparrow
from .add_view import SPECTRAL_PROBE_OT_add_view, SPECTRAL_PROBE_OT_remove_view
from .bridge.swatches import SwatchShelf
from .build_probe import SPECTRAL_PROBE_OT_build_probe
from .calibrate import SPECTRAL_PROBE_OT_calibrate
from .choose_glass import SPECTRAL_PROBE_OT_choose_glass, SPECTRAL_PROBE_OT_choose_lamp
from .choose_spectrum import SPECTRAL_PROBE_OT_choose_spectrum
from .compare import SPECTRAL_PROBE_OT_compare
from .composite import SPECTRAL_PROBE_OT_composite
from .copy_report import SPECTRAL_PROBE_OT_copy_report
from .detect_ball import SPECTRAL_PROBE_OT_detect_ball
from .draw_region import SPECTRAL_PROBE_OT_draw_region
from .edit_outline import SPECTRAL_PROBE_OT_edit_outline
from .edit_region import SPECTRAL_PROBE_OT_edit_region
from .export_farm_job import SPECTRAL_PROBE_OT_export_farm_job
from .find_files import SPECTRAL_PROBE_OT_find_files, SPECTRAL_PROBE_OT_make_paths
from .import_capture import SPECTRAL_PROBE_OT_import_capture
from .import_photographs import SPECTRAL_PROBE_FH_photographs, SPECTRAL_PROBE_OT_import_photographs
from .light_from_photographs import SPECTRAL_PROBE_OT_light_from_photographs
from .light_world import SPECTRAL_PROBE_OT_light_world
from .match_backplate import SPECTRAL_PROBE_OT_add_ground, SPECTRAL_PROBE_OT_match_backplate
from .move_photo import (
    SPECTRAL_PROBE_OT_add_photos,
    SPECTRAL_PROBE_OT_join_views,
    SPECTRAL_PROBE_OT_move_photo,
    SPECTRAL_PROBE_OT_remove_photo,
    SPECTRAL_PROBE_OT_spread_views,
)
from .pack_probe import SPECTRAL_PROBE_OT_pack_probe, SPECTRAL_PROBE_OT_unpack_probe
from .pick_direction import SPECTRAL_PROBE_OT_pick_direction
from .plan_render import SPECTRAL_PROBE_OT_plan_render
from .preset import SPECTRAL_PROBE_OT_load_preset, SPECTRAL_PROBE_OT_save_preset
from .remove_edit import SPECTRAL_PROBE_OT_remove_edit
from .render_and_compare import SPECTRAL_PROBE_OT_render_and_compare
from .render_folder import SPECTRAL_PROBE_OT_own_render_folder
from .render_spectral import SPECTRAL_PROBE_OT_render_animation, SPECTRAL_PROBE_OT_render_spectral
from .replace_lamp import SPECTRAL_PROBE_OT_replace_lamp
from .save_capture import SPECTRAL_PROBE_OT_save_capture
from .seed_from_view import SPECTRAL_PROBE_OT_seed_from_view
from .show_basis import SPECTRAL_PROBE_OT_show_basis
from .show_comparison import SPECTRAL_PROBE_OT_show_comparison
from .show_confidence import SPECTRAL_PROBE_OT_show_confidence
from .show_panorama import SPECTRAL_PROBE_OT_show_panorama
from .show_photograph import SPECTRAL_PROBE_OT_show_photograph
from .show_sensitivities import SPECTRAL_PROBE_OT_show_sensitivities
from .show_spectrum import SPECTRAL_PROBE_OT_show_spectrum
from .show_swatches import SPECTRAL_PROBE_OT_show_swatches
from .swap_light import SPECTRAL_PROBE_OT_swap_light
from .use_cycles import SPECTRAL_PROBE_OT_use_cycles

_register_classes, _unregister_classes = bpy.utils.register_classes_factory(
    (
        SPECTRAL_PROBE_OT_import_capture,
        SPECTRAL_PROBE_OT_import_photographs,
        SPECTRAL_PROBE_FH_photographs,
        SPECTRAL_PROBE_OT_save_capture,
        SPECTRAL_PROBE_OT_load_preset,
        SPECTRAL_PROBE_OT_save_preset,
        SPECTRAL_PROBE_OT_add_view,
        SPECTRAL_PROBE_OT_remove_view,
        SPECTRAL_PROBE_OT_add_photos,
        SPECTRAL_PROBE_OT_move_photo,
        SPECTRAL_PROBE_OT_remove_photo,
        SPECTRAL_PROBE_OT_join_views,
        SPECTRAL_PROBE_OT_spread_views,
        SPECTRAL_PROBE_OT_add_own_light,
        SPECTRAL_PROBE_OT_remove_own_light,
        SPECTRAL_PROBE_OT_add_region_light,
        SPECTRAL_PROBE_OT_remove_region_light,
        SPECTRAL_PROBE_OT_find_files,
        SPECTRAL_PROBE_OT_make_paths,
        SPECTRAL_PROBE_OT_pack_probe,
        SPECTRAL_PROBE_OT_own_render_folder,
        SPECTRAL_PROBE_OT_unpack_probe,
        SPECTRAL_PROBE_OT_calibrate,
        SPECTRAL_PROBE_OT_detect_ball,
        SPECTRAL_PROBE_OT_show_photograph,
        SPECTRAL_PROBE_OT_edit_outline,
        SPECTRAL_PROBE_OT_build_probe,
        SPECTRAL_PROBE_OT_show_spectrum,
        SPECTRAL_PROBE_OT_show_basis,
        SPECTRAL_PROBE_OT_show_sensitivities,
        SPECTRAL_PROBE_OT_show_confidence,
        SPECTRAL_PROBE_OT_add_glass,
        SPECTRAL_PROBE_OT_replace_lamp,
        SPECTRAL_PROBE_OT_remove_edit,
        SPECTRAL_PROBE_OT_choose_glass,
        SPECTRAL_PROBE_OT_choose_lamp,
        SPECTRAL_PROBE_OT_draw_region,
        SPECTRAL_PROBE_OT_edit_region,
        SPECTRAL_PROBE_OT_pick_direction,
        SPECTRAL_PROBE_OT_show_panorama,
        SPECTRAL_PROBE_OT_add_mask,
        SPECTRAL_PROBE_OT_seed_from_view,
        SPECTRAL_PROBE_OT_light_world,
        SPECTRAL_PROBE_OT_light_from_photographs,
        SPECTRAL_PROBE_OT_match_backplate,
        SPECTRAL_PROBE_OT_add_ground,
        SPECTRAL_PROBE_OT_add_object,
        SPECTRAL_PROBE_OT_add_torrance_sparrow,
        SPECTRAL_PROBE_OT_show_swatches,
        SPECTRAL_PROBE_OT_choose_spectrum,
        SPECTRAL_PROBE_OT_add_asset_library,
        SPECTRAL_PROBE_OT_remove_asset_library,
        SPECTRAL_PROBE_OT_add_swappable,
        SPECTRAL_PROBE_OT_remove_swappable,
        SPECTRAL_PROBE_OT_plan_render,
        SPECTRAL_PROBE_OT_render_spectral,
        SPECTRAL_PROBE_OT_render_animation,
        SPECTRAL_PROBE_OT_export_farm_job,
        SPECTRAL_PROBE_OT_render_and_compare,
        SPECTRAL_PROBE_OT_use_cycles,
        SPECTRAL_PROBE_OT_copy_report,
        SPECTRAL_PROBE_OT_swap_light,
        SPECTRAL_PROBE_OT_composite,
        SPECTRAL_PROBE_OT_compare,
        SPECTRAL_PROBE_OT_show_comparison,
    )
)


def register() -> None:
    """Make the operators and the command known to Blender."""
    _register_classes()
    running_job.register()
    command_line.register()
    panorama_handlers.register()
    add_asset_library.register()


def unregister() -> None:
    """Take them back."""
    add_asset_library.unregister()
    SwatchShelf.clear()
    panorama_handlers.unregister()
    command_line.unregister()
    running_job.unregister()
    open_modals.close_all()
    _unregister_classes()

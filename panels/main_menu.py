"""Render > Spectral Probe, and Image > Spectral Probe: every operator that makes sense by its name alone.

Blender's search (F3) finds what stands in menus; here it is named so that it can be found, which buttons in a panel need not be.
"""

from __future__ import annotations

from typing import ClassVar

import bpy
from bpy.app.translations import pgettext_n as n_

_ENUMS = {
    "show_comparison": "view",
    "show_panorama": "picture",
    "pick_direction": "target",
    "make_paths": "form",
}
"""Operators that are a submenu of the items of a property."""


class _Stage:
    """Mixin: a submenu of operators, each with its text, or its label where that says enough."""

    operators: ClassVar[tuple[tuple[str, str], ...]]

    def draw(self, _context: bpy.types.Context) -> None:
        """Draw a line for each."""
        for verb, text in self.operators:
            words = {"text": text} if text else {}
            if verb in _ENUMS:
                self.layout.operator_menu_enum(f"spectral_probe.{verb}", _ENUMS[verb], **words)
            else:
                self.layout.operator(f"spectral_probe.{verb}", **words)


class SPECTRAL_PROBE_MT_photographs(_Stage, bpy.types.Menu):
    """Photographs of the ball, their views, and the camera that took them"""

    bl_label = "Photographs of the Ball"
    operators = (
        ("import_photographs", n_("Import Photographs...", "Operator")),
        ("import_capture", n_("Import Capture...", "Operator")),
        ("save_capture", n_("Save Capture...", "Operator")),
        ("add_view", ""),
        ("remove_view", ""),
        ("add_photos", n_("Add Photographs to View...", "Operator")),
        ("remove_photo", ""),
        ("join_views", ""),
        ("spread_views", ""),
        ("calibrate", n_("Calibrate Camera...", "Operator")),
        ("show_sensitivities", n_("Show Camera Sensitivities", "Operator")),
        ("add_own_light", n_("Add Measured Lamp...", "Operator")),
        ("remove_own_light", ""),
        ("add_region_light", n_("Add Region with Lamps of Its Own", "Operator")),
        ("remove_region_light", n_("Remove Region with Lamps of Its Own", "Operator")),
    )


class SPECTRAL_PROBE_MT_probe(_Stage, bpy.types.Menu):
    """The ball in the photographs, and the probe built from it"""

    bl_label = "Ball and Probe"
    operators = (
        ("light_from_photographs", ""),
        ("detect_ball", ""),
        ("show_photograph", n_("Show Photograph of the Ball", "Operator")),
        ("edit_outline", n_("Edit Outline of the Ball", "Operator")),
        ("build_probe", ""),
        ("light_world", n_("Light World with Probe", "Operator")),
        ("show_spectrum", ""),
        ("show_basis", n_("Show Spectral Basis", "Operator")),
        ("show_confidence", ""),
        ("pack_probe", ""),
        ("unpack_probe", ""),
        ("find_files", n_("Find Spectral Probe Files...", "Operator")),
        ("make_paths", ""),
    )


class SPECTRAL_PROBE_MT_panorama(_Stage, bpy.types.Menu):
    """Directions and regions of the panorama, and the glass and lamps there"""

    bl_label = "Glass and Lamps"
    operators = (
        ("show_panorama", ""),
        ("pick_direction", ""),
        ("seed_from_view", n_("Take Direction from Viewport", "Operator")),
        ("draw_region", ""),
        ("edit_region", n_("Edit Corners of Region", "Operator")),
        ("add_mask", n_("New Mask of the Panorama", "Operator")),
        ("choose_glass", n_("Choose Glass for Region", "Operator")),
        ("choose_lamp", n_("Choose Lamp for Region", "Operator")),
        ("add_glass", n_("Add Glass to Region", "Operator")),
        ("replace_lamp", n_("Replace Lamp in Region", "Operator")),
        ("remove_edit", n_("Remove Glass or Lamp", "Operator")),
        ("add_swappable", ""),
        ("remove_swappable", n_("Make Region Not Swappable", "Operator")),
    )


class SPECTRAL_PROBE_MT_scene(_Stage, bpy.types.Menu):
    """Spectral materials, and the photograph behind the scene"""

    bl_label = "Materials and Backplate"
    operators = (
        ("show_swatches", n_("Show Swatches of the Library", "Operator")),
        ("choose_spectrum", n_("Choose Spectrum of Material or Lamp", "Operator")),
        ("add_torrance_sparrow", n_("Add Torrance-Sparrow Material", "Operator")),
        ("add_asset_library", n_("Add Library of Spectral Materials", "Operator")),
        ("remove_asset_library", n_("Remove Library of Spectral Materials", "Operator")),
        ("match_backplate", n_("Match Camera to Photograph", "Operator")),
        ("add_ground", n_("Lay Ground of the Photograph", "Operator")),
    )


class SPECTRAL_PROBE_MT_render(_Stage, bpy.types.Menu):
    """The spectral render, its comparison with RGB, and what can be changed after it"""

    bl_label = "Spectral Render"
    operators = (
        ("use_cycles", ""),
        ("plan_render", n_("Plan Spectral Render", "Operator")),
        ("export_farm_job", n_("Export Farm Job...", "Operator")),
        ("own_render_folder", n_("Give Scene Its Own Render Folder", "Operator")),
        ("swap_light", n_("Swap Light of the Render", "Operator")),
        ("composite", n_("Composite into Photograph", "Operator")),
        ("compare", n_("Compare RGB with Spectral", "Operator")),
        ("show_comparison", ""),
    )


STAGES = (
    SPECTRAL_PROBE_MT_photographs,
    SPECTRAL_PROBE_MT_probe,
    SPECTRAL_PROBE_MT_panorama,
    SPECTRAL_PROBE_MT_scene,
    SPECTRAL_PROBE_MT_render,
)
"""The submenus, in the order of the pipeline."""


class SPECTRAL_PROBE_MT_main(bpy.types.Menu):
    """Everything that Spectral Probe can do"""

    bl_label = "Spectral Probe"

    def draw(self, _context: bpy.types.Context) -> None:
        """Draw a submenu for each stage."""
        for stage in STAGES:
            self.layout.menu(stage.__name__)


def draw_main_menu(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """The line in a menu of Blender's."""
    menu.layout.separator()
    menu.layout.menu("SPECTRAL_PROBE_MT_main")


def register() -> None:
    """Put the line into the menus Render and Image, once."""
    unregister()
    bpy.types.TOPBAR_MT_render.append(draw_main_menu)
    bpy.types.IMAGE_MT_image.append(draw_main_menu)


def unregister() -> None:
    """Take it out."""
    bpy.types.IMAGE_MT_image.remove(draw_main_menu)
    bpy.types.TOPBAR_MT_render.remove(draw_main_menu)

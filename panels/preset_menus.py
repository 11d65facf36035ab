"""Blender's preset menus in the headers of panels."""

from pathlib import Path

import bpy
from bl_ui.utils import PresetPanel

from ..operators.preset import SUFFIX, subfolder

_ROOT = str(Path(__file__).resolve().parents[1])


class _Presets(PresetPanel):
    """Mixin: a menu of presets of one kind."""

    preset_operator = "spectral_probe.load_preset"
    preset_add_operator = "spectral_probe.save_preset"
    preset_extensions = frozenset({SUFFIX})


class SPECTRAL_PROBE_PT_capture_presets(_Presets, bpy.types.Panel):
    """The camera, its lens, and the ball."""

    bl_label = "Camera and Ball Presets"
    preset_subdir = subfolder("capture")
    preset_operator_defaults = preset_add_operator_properties = {"kind": "capture"}  # noqa: RUF012  (Blender's own)


class SPECTRAL_PROBE_PT_lamps_presets(_Presets, bpy.types.Panel):
    """Lamps that may be present."""

    bl_label = "Lamp Presets"
    preset_subdir = subfolder("lamps")
    preset_operator_defaults = preset_add_operator_properties = {"kind": "lamps"}  # noqa: RUF012


class SPECTRAL_PROBE_PT_render_presets(_Presets, bpy.types.Panel):
    """How finely the spectrum is rendered."""

    bl_label = "Spectral Render Presets"
    preset_subdir = subfolder("render")
    preset_operator_defaults = preset_add_operator_properties = {"kind": "render"}  # noqa: RUF012


def register() -> None:
    """Have Blender look for presets that came with the extension."""
    bpy.utils.register_preset_path(_ROOT)


def unregister() -> None:
    """Take that back."""
    bpy.utils.unregister_preset_path(_ROOT)

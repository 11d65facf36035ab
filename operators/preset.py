"""Presets of settings, in Blender's own preset menus and folders.

Blender's presets are Python scripts that it runs, or XML that knows no settings of add-ons. These are TOML and only read:
a preset from elsewhere can set what stands in `KINDS`, and nothing else.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ..spectral_probe.errors import FileFormatError
from .base import FINISHED, OperatorResult, ReportsErrors
from .typed import decimal

if TYPE_CHECKING:
    from ..spectral_probe.files.preset_file import Setting

SUFFIX = ".toml"

KINDS: dict[str, tuple[str, ...]] = {
    "capture": (
        "camera.model", "camera.sensitivities", "camera.half_size", "camera.focal_source", "camera.focal_px", "camera.focal_mm",
        "camera.sensor_width_mm", "camera.calibration", "camera.has_principal", "camera.principal_px", "camera.distortion",
        "ball_radius", "ball_material",
    ),
    "lamps": ("families", "families_automatic", "method"),
    "render": ("plan", "passes", "max_de2000", "samples", "full_samples", "rgb_twin"),
}  # fmt: skip
"""The settings of each kind of preset, from `Scene.spectral_probe`."""

_LENGTHS = ("ball_radius",)  # in metres in the file, whatever the unit of the scene

_KIND = EnumProperty(
    name="Kind",
    items=(
        ("capture", "Camera and Ball", "The camera, its lens, and the ball"),
        ("lamps", "Lamps", "Lamps that may be present"),
        ("render", "Spectral Render", "How finely the spectrum is rendered"),
    ),
    options={"HIDDEN"},
)


def subfolder(kind: str) -> str:
    """The folder of a kind of presets, in every folder where Blender looks for presets."""
    return f"spectral_probe/{kind}"


class SPECTRAL_PROBE_OT_load_preset(ReportsErrors, bpy.types.Operator):
    """Take the settings of this preset"""

    bl_idname = "spectral_probe.load_preset"
    bl_label = "Load Spectral Probe Preset"

    filepath: StringProperty(name="Preset", subtype="FILE_PATH", options={"SKIP_SAVE", "HIDDEN"})
    kind: _KIND

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Read all of the file before any setting is changed."""
        from ..spectral_probe.files.preset_file import read_preset

        path = Path(bpy.path.abspath(self.filepath))
        given = read_preset(path)
        unknown = [name for name in given if name not in KINDS[self.kind]]
        if unknown:
            raise FileFormatError(
                rpt_(
                    "{file} sets {name}, which this kind of preset does not have. Choose another preset."
                ).format(file=path.name, name=unknown[0])
            )
        settings = context.scene.spectral_probe
        before = _values(settings, self.kind)
        for name, value in given.items():
            try:
                _set(settings, name, value)
            except (TypeError, ValueError) as problem:
                for changed, old in before:
                    _set(settings, changed, old)
                raise FileFormatError(
                    rpt_("{file}: {name} cannot be {value}. Save the preset again, or remove it.").format(
                        file=path.name, name=name, value=repr(value)
                    )
                ) from problem
        return FINISHED


class SPECTRAL_PROBE_OT_save_preset(ReportsErrors, bpy.types.Operator):
    """Save these settings as a preset, or remove a preset"""

    bl_idname = "spectral_probe.save_preset"
    bl_label = "Save Spectral Probe Preset"
    bl_options = {"REGISTER", "INTERNAL"}  # noqa: RUF012  (Blender's own; the file is not undone)

    name: StringProperty(name="Name", description="Name of the preset", maxlen=64, options={"SKIP_SAVE"})
    remove_name: BoolProperty(name="Remove", default=False, options={"HIDDEN", "SKIP_SAVE"})
    kind: _KIND

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Write the file, or remove it."""
        from bl_operators.presets import AddPresetBase

        from ..spectral_probe.files.preset_file import write_preset

        folder = Path(bpy.utils.user_resource("SCRIPTS", path=f"presets/{subfolder(self.kind)}", create=True))
        name = AddPresetBase.as_filename(self.name)
        if not name:
            raise FileFormatError(rpt_("Give the preset a name."))
        find = bpy.utils.preset_find
        known = find(name, subfolder(self.kind), ext=SUFFIX)
        if self.remove_name:
            known = known or find(self.name, subfolder(self.kind), ext=SUFFIX, display_name=True)
            if known is None or Path(known).parent != folder:
                raise FileFormatError(rpt_("This preset came with Spectral Probe: it cannot be removed."))
            Path(known).unlink()
            return FINISHED
        if known:
            raise FileFormatError(
                rpt_("There is a preset called {name} already. Give another name.").format(name=name)
            )
        path = folder / f"{name}{SUFFIX}"
        write_preset(path, dict(_values(context.scene.spectral_probe, self.kind)))
        self.report({"INFO"}, rpt_("Saved the preset {name}").format(name=name))
        return FINISHED


def _values(settings: bpy.types.PropertyGroup, kind: str) -> list[tuple[str, Setting]]:
    """The settings of a kind, as they are written."""
    return [(name, _plain(settings, name)) for name in KINDS[kind]]


def _plain(settings: bpy.types.PropertyGroup, name: str) -> Setting:
    value = settings.path_resolve(name)
    if isinstance(value, set):
        return sorted(value)
    if isinstance(value, bool | int):
        return value
    if isinstance(value, str):
        return bpy.path.abspath(value) if value.startswith("//") else value
    if isinstance(value, float):
        return decimal(value * settings.id_data.unit_settings.scale_length if name in _LENGTHS else value)
    return [decimal(item) for item in value]


def _set(settings: bpy.types.PropertyGroup, name: str, value: Setting) -> None:
    owner_path, _, key = name.rpartition(".")
    owner = settings.path_resolve(owner_path) if owner_path else settings
    if owner.bl_rna.properties[key].type == "ENUM" and isinstance(value, list):
        value = set(value)
    if name in _LENGTHS:
        value = float(value) / settings.id_data.unit_settings.scale_length
    setattr(owner, key, value)

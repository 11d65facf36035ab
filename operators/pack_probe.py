"""Pack the probe into the .blend, and unpack it."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.props import StringProperty

from .base import FINISHED, OperatorResult, ReportsErrors
from .bridge import packed_probe
from .polls import has_probe
from .settings import built_folder, folder_of

_MEGABYTE = 1e6


class SPECTRAL_PROBE_OT_pack_probe(ReportsErrors, bpy.types.Operator):
    """Put a copy of the probe into the .blend, so that it can be given away alone. Its files stay where they are"""

    bl_idname = "spectral_probe.pack_probe"
    bl_label = "Pack Probe"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a probe."""
        return has_probe(cls, context)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        """Say how much it is first."""
        settings = context.scene.spectral_probe
        files = packed_probe.packable(built_folder(settings), settings.edits.state)
        size = sum(path.stat().st_size for _, path in files) / _MEGABYTE
        answer: OperatorResult = context.window_manager.invoke_confirm(
            self,
            event,
            title=rpt_("Pack Probe"),
            message=rpt_("The .blend becomes {size:.1f} MB larger").format(size=size),
            confirm_text=rpt_("Pack"),
        )
        return answer

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Pack it."""
        settings = context.scene.spectral_probe
        size = packed_probe.pack(settings, built_folder(settings)) / _MEGABYTE
        self.report({"INFO"}, rpt_("Probe packed, {size:.1f} MB").format(size=size))
        return FINISHED


class SPECTRAL_PROBE_OT_unpack_probe(ReportsErrors, bpy.types.Operator):
    """Write the packed probe into its folder and take it out of the .blend. Other files there are never replaced"""

    bl_idname = "spectral_probe.unpack_probe"
    bl_label = "Unpack Probe"

    directory: StringProperty(
        name="Folder",
        description="Where to write the files. Empty: the folder of the probe",
        subtype="DIR_PATH",
        options={"SKIP_SAVE", "PATH_SUPPORTS_BLEND_RELATIVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a packed one."""
        if packed_probe.is_packed(context.scene.spectral_probe):
            return True
        cls.poll_message_set("The .blend holds no packed probe")
        return False

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Write the files."""
        settings = context.scene.spectral_probe
        folder = folder_of(self.directory or settings.probe_directory, "probe")
        if settings.packed.outdated:
            packed_probe.pack(settings, built_folder(settings))
        written = packed_probe.unpack(settings, folder)
        if self.directory:
            _move_to(settings, self.directory)
        _show_from(folder, written)
        packed_probe.remove(settings)
        self.report(
            {"INFO"}, rpt_("{count} files written to {folder}").format(count=len(written), folder=folder)
        )
        return FINISHED


def _move_to(settings: bpy.types.PropertyGroup, directory: str) -> None:
    same = settings.edits.probe_directory == settings.probe_directory
    settings.probe_directory = directory
    if same:
        settings.edits.probe_directory = directory


def _show_from(folder: Path, written: list[Path]) -> None:
    """Pictures of the files that are there again are read from them."""
    for image in bpy.data.images:
        if image.source == "FILE" and Path(bpy.path.abspath(image.filepath)) in written and folder.is_dir():
            image.reload()

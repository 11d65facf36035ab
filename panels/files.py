"""Files: the packed probe, how paths are written, what is missing. Also our part of File > External Data."""

from pathlib import Path

import bpy
from bpy.app.translations import pgettext_iface as iface_
from bpy.app.translations import pgettext_n as n_

from ..operators.missing import still_missing
from ..versions import is_newer
from .main import InWorld, paragraph, results

_NAMED = 5


class SPECTRAL_PROBE_PT_files(InWorld, bpy.types.Panel):
    """What the .blend refers to, and what it holds."""

    bl_label = "Files"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012  (Blender's own form)

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the copy of the probe, and how paths are written."""
        layout, settings = self.layout, context.scene.spectral_probe
        files = settings.packed.files
        row = layout.row(align=True)
        row.operator("spectral_probe.pack_probe", icon="PACKAGE")
        row.operator("spectral_probe.unpack_probe", icon="UGLYPACKAGE")
        if files:
            size = sum(item.size_bytes for item in files) / 1e6
            text = iface_("The .blend holds the probe: {count} files, {size:.1f} MB")
            paragraph(results(layout), context, text.format(count=len(files), size=size), "NONE")
        row = layout.row(align=True)
        row.operator("spectral_probe.make_paths", text="Paths Relative").form = "RELATIVE"
        row.operator("spectral_probe.make_paths", text="Paths Absolute").form = "ABSOLUTE"


def draw_newer(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    """A warning where the settings are those of a later version; nothing else."""
    if is_newer(context.scene.spectral_probe):
        text = iface_(
            "A later version of Spectral Probe saved this file. What is not known here is kept; update the extension to use it."
        )
        paragraph(layout, context, text, "ERROR")


def draw_missing(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    """Files that are missing, and the button that finds them; nothing where none is."""
    gone = still_missing(context)
    if not gone:
        return
    column = results(layout)
    column.label(
        text=iface_("Files are missing: {count}").format(count=len(gone)), icon="ERROR", translate=False
    )
    for path in gone[:_NAMED]:
        column.label(text="/".join(Path(path).parts[-2:]), icon="BLANK1", translate=False)
    if len(gone) > _NAMED:
        column.label(text="...", icon="BLANK1", translate=False)
    layout.operator("spectral_probe.find_files", icon="VIEWZOOM")


def draw_external_data(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """Entries of File > External Data."""
    layout = self.layout
    layout.separator()
    for form, text in (
        ("RELATIVE", n_("Make Spectral Probe Paths Relative", "Operator")),
        ("ABSOLUTE", n_("Make Spectral Probe Paths Absolute", "Operator")),
    ):
        layout.operator("spectral_probe.make_paths", text=text).form = form
    layout.operator("spectral_probe.find_files")

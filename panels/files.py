"""Files: what is missing, the packed probe, settings of a later version. Also our part of File > External Data."""

import bpy
from bpy.app.translations import pgettext_iface as iface_

from ..operators.missing import still_missing
from ..versions import is_newer
from .main import InWorld, paragraph, results

_NAMED = 5


class SPECTRAL_PROBE_PT_files(InWorld, bpy.types.Panel):
    """What the .blend refers to, and what it holds."""

    bl_label = "Files"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012  (Blender's own form)

    def draw_header(self, context: bpy.types.Context) -> None:
        """A sign that something is missing, to be seen where the panel is closed."""
        if still_missing(context):
            self.layout.label(icon="ERROR")

    def draw(self, context: bpy.types.Context) -> None:
        """Draw what is missing, and the copy of the probe."""
        layout, settings = self.layout, context.scene.spectral_probe
        draw_newer(layout, context)
        _draw_missing(layout, context)
        files = settings.packed.files
        row = layout.row(align=True)
        row.operator("spectral_probe.pack_probe", icon="PACKAGE")
        row.operator("spectral_probe.unpack_probe", icon="UGLYPACKAGE")
        if files:
            size = sum(item.size_bytes for item in files) / 1e6
            text = iface_("The .blend holds the probe: {count} files, {size:.1f} MB")
            results(layout).label(text=text.format(count=len(files), size=size), translate=False)


def draw_newer(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    """A warning where the settings are those of a later version; nothing else."""
    if is_newer(context.scene.spectral_probe):
        text = iface_(
            "A later version of Spectral Probe saved this file. What is not known here is kept; update the extension to use it."
        )
        paragraph(layout, context, text, "ERROR")


def _draw_missing(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    gone = still_missing(context)
    if not gone:
        return
    column = results(layout)
    for path in gone[:_NAMED]:
        paragraph(column, context, path, "LIBRARY_DATA_BROKEN")
    if len(gone) > _NAMED:
        column.label(text=iface_("and {count} more").format(count=len(gone) - _NAMED), translate=False)
    layout.operator("spectral_probe.find_files", icon="VIEWZOOM")


def draw_external_data(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """Entries of File > External Data."""
    layout = self.layout
    layout.separator()
    for form, text in (
        ("RELATIVE", "Make Spectral Probe Paths Relative"),
        ("ABSOLUTE", "Make Spectral Probe Paths Absolute"),
    ):
        layout.operator("spectral_probe.make_paths", text=text).form = form
    layout.operator("spectral_probe.find_files")

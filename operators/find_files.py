"""Find missing files of ours again, and make our paths relative or absolute: File > External Data does so for Blender's own."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.props import EnumProperty, StringProperty

from ..spectral_probe.errors import CaptureError
from .asking_for_folder import AsksForFolder
from .base import FINISHED, OperatorResult, ReportsErrors
from .bridge import own_paths
from .missing import keep_missing

if TYPE_CHECKING:
    from ..spectral_probe.model import Job


class SPECTRAL_PROBE_OT_find_files(AsksForFolder, bpy.types.Operator):
    """Look in a folder, and all that is in it, for photographs, spectra and probes that are not where they were"""

    bl_idname = "spectral_probe.find_files"
    bl_label = "Find Spectral Probe Files"

    directory: StringProperty(
        name="Folder",
        description="Where to look",
        subtype="DIR_PATH",
        options={"SKIP_SAVE", "PATH_SUPPORTS_BLEND_RELATIVE"},
    )
    filter_folder: bpy.props.BoolProperty(default=True, options={"HIDDEN", "SKIP_SAVE"})

    in_thread = True

    def job(self, _context: bpy.types.Context) -> Job[dict[str, Path]]:
        """See what is missing, and start to look for it."""
        from ..spectral_probe.files.finding import find_files

        if not self.directory:
            raise CaptureError(
                rpt_("No folder is chosen. Choose the one that the files are in, or one above it.")
            )
        gone = own_paths.missing(own_paths.local_blocks())
        return find_files(Path(bpy.path.abspath(self.directory)), list(gone))

    def done(self, context: bpy.types.Context, result: dict[str, Path]) -> None:
        """Write where they are."""
        gone = own_paths.missing(own_paths.local_blocks())  # anew: the user may have worked on
        found = {old: new for old, new in result.items() if old in gone}
        count = own_paths.put_found(gone, found)
        left = keep_missing(context)
        if not gone:
            self.tell("INFO", rpt_("No file is missing"))
        else:
            self.report(
                {"WARNING" if left else "INFO"},
                rpt_("{found} found, {left} still missing").format(found=count, left=len(left)),
            )


class SPECTRAL_PROBE_OT_make_paths(ReportsErrors, bpy.types.Operator):
    """Make the paths of photographs, spectra, probes and renders relative to the .blend, or absolute"""

    bl_idname = "spectral_probe.make_paths"
    bl_label = "Make Spectral Probe Paths"

    form: EnumProperty(
        name="Form",
        description="How the paths are written",
        items=(
            ("RELATIVE", "Relative", "Relative to the .blend, so that they can be moved together"),
            ("ABSOLUTE", "Absolute", "From the root of the disk, so that the .blend can be moved alone"),
        ),
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """There must be a saved file to be relative to."""
        if bpy.data.filepath:
            return True
        cls.poll_message_set("Save the .blend first: paths are relative to it")
        return False

    def run(self, _context: bpy.types.Context) -> OperatorResult:
        """Write them."""
        make = own_paths.make_relative if self.form == "RELATIVE" else own_paths.make_absolute
        self.report({"INFO"}, rpt_("{count} paths changed").format(count=make(own_paths.local_blocks())))
        return FINISHED

"""What is the same in every file: the folder of the user's own spectra and cameras."""

from pathlib import Path

import bpy
from bpy.props import StringProperty


class SpectralProbePreferences(bpy.types.AddonPreferences):
    """Settings of the extension in Blender's preferences."""

    bl_idname = __package__

    library_folder: StringProperty(
        name="Library Folder",
        description="Folder of your own cameras, lamps and reflectances (CSV, AMPAS JSON, IES TM-27): the fields where a "
        "camera, a lamp or a reflectance is named offer them too",
        subtype="DIR_PATH",
    )

    def draw(self, _context: bpy.types.Context) -> None:
        """Draw the settings."""
        self.layout.prop(self, "library_folder")


def library_folder() -> Path | None:
    """The user's library folder; None where none is chosen, it is not there, or the extension is not an add-on here."""
    addon = bpy.context.preferences.addons.get(__package__)
    chosen = addon.preferences.library_folder if addon is not None and addon.preferences is not None else ""
    folder = Path(bpy.path.abspath(chosen)) if chosen else None
    return folder if folder is not None and folder.is_dir() else None


register, unregister = bpy.utils.register_classes_factory((SpectralProbePreferences,))

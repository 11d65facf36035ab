"""What is the same in every file: the folder of the user's own spectra and cameras, and the asset library."""

from pathlib import Path

import bpy
from bpy.props import BoolProperty, StringProperty


class SpectralProbePreferences(bpy.types.AddonPreferences):
    """Settings of the extension in Blender's preferences."""

    bl_idname = __package__

    library_folder: StringProperty(
        name="Library Folder",
        description="Folder of your own cameras, lamps and reflectances (CSV, AMPAS JSON, IES TM-27): the fields where a "
        "camera, a lamp or a reflectance is named offer them too",
        subtype="DIR_PATH",
    )
    asset_library: BoolProperty(
        name="Asset Library",
        description="Keep the spectral materials among the asset libraries of the preferences",
        options={"HIDDEN"},
    )

    def draw(self, _context: bpy.types.Context) -> None:
        """Draw the settings."""
        self.layout.prop(self, "library_folder")
        row = self.layout.split(factor=0.4)
        row.label(text="Spectral metals and glasses in the Asset Browser:")
        verb = "remove" if self.asset_library else "add"
        row.operator(f"spectral_probe.{verb}_asset_library", icon="ASSET_MANAGER")


def addon_preferences() -> SpectralProbePreferences | None:
    """The extension's preferences; None where it is not an add-on, as when a script registers it."""
    addon = bpy.context.preferences.addons.get(__package__)
    return addon.preferences if addon is not None else None


def library_folder() -> Path | None:
    """The user's library folder; None where none is chosen, it is not there, or the extension is not an add-on here."""
    preferences = addon_preferences()
    chosen = preferences.library_folder if preferences is not None else ""
    folder = Path(bpy.path.abspath(chosen)) if chosen else None
    return folder if folder is not None and folder.is_dir() else None


register, unregister = bpy.utils.register_classes_factory((SpectralProbePreferences,))

"""The asset library of the extension in Blender's preferences: one entry, which comes and goes with the extension.

Blender's own preferences hold the entry. The extension's hold whether it is wanted: it is put right when the extension is enabled
(an update, or another Blender, may have another folder) and leaves when the extension does.
"""

from __future__ import annotations

from pathlib import Path

import bpy

NAME = "Spectral Probe"


def assets_folder() -> Path:
    """Folder of the assets that come with the extension."""
    return Path(__file__).absolute().parents[2] / "assets"  # not resolved: where Blender looks


def entries() -> list[bpy.types.UserAssetLibrary]:
    """Entries of the preferences that are ours: those of our folder, and of our name where their folder is gone."""
    ours = assets_folder()
    return [entry for entry in bpy.context.preferences.filepaths.asset_libraries if _is_ours(entry, ours)]


def add_entry() -> None:
    """Put our entry into the preferences, or put right the one that is there."""
    libraries, known = bpy.context.preferences.filepaths.asset_libraries, entries()
    for double in known[1:]:
        libraries.remove(double)
    if known:
        known[0].path = str(assets_folder())
        return
    entry = libraries.new(name=NAME, directory=str(assets_folder()))
    entry.import_method = "APPEND"  # a linked material's spectral settings could not be changed


def remove_entries() -> None:
    """Take our entry out of the preferences."""
    for entry in entries():
        bpy.context.preferences.filepaths.asset_libraries.remove(entry)


def _is_ours(entry: bpy.types.UserAssetLibrary, ours: Path) -> bool:
    if not entry.path:
        return False
    folder = Path(entry.path)
    moved = entry.name.startswith(NAME) and folder.parts[-2:] == ours.parts[-2:] and not folder.is_dir()
    return folder == ours or moved

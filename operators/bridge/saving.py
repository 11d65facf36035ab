"""A scene saved to a file that is there whole or not at all."""

from pathlib import Path

import bpy

from ...spectral_probe.errors import RenderError
from .restore import changed


def save_scene(path: Path, *, copy: bool = False) -> None:
    """Save what is open as a .blend, in the place of an earlier one, of which no copy is kept.

    Blender itself writes to a file beside it first; what it leaves of that on a full disk is removed.

    Parameters
    ----------
    path
        The file; paths in the scene are made relative to it as ever.
    copy
        The open file stays the one it was.

    Raises
    ------
    RenderError
        If it cannot be written; an earlier file is then as it was.
    """
    beside = path.with_name(f"{path.name}@")
    try:
        with changed(bpy.context.preferences.filepaths, save_version=0):
            bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=copy, compress=True)
    except RuntimeError as problem:
        beside.unlink(missing_ok=True)
        why = str(problem).strip().rpartition("Error: ")[2].splitlines()[0].rstrip(".")
        raise RenderError(f"{path} cannot be written ({why}). Make room, or choose another place.") from None

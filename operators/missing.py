"""Which files are missing, looked for when a file is opened or after they were searched, not whenever a panel is drawn."""

from __future__ import annotations

from pathlib import Path

import bpy

from .bridge import own_paths


def keep_missing(context: bpy.types.Context) -> list[str]:
    """Look which files of ours are missing, and keep their list for the panels."""
    gone = list(own_paths.missing(own_paths.local_blocks()))
    context.window_manager.spectral_probe_files.missing = "\n".join(gone)
    return gone


def still_missing(context: bpy.types.Context) -> list[str]:
    """Those of the list that still are; with nothing missing no disk is touched."""
    listed = context.window_manager.spectral_probe_files.missing
    return [path for path in listed.splitlines() if not Path(path).exists()]

"""The probe that was looked at last, kept in memory, so that pointing at its panorama answers at once.

It is no Blender data: nothing of it is saved, and undo does not touch it. One probe is kept; it is read again when its file
changed, and dropped when another .blend is opened.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ...spectral_probe.model import SpectralPanorama

type FileState = tuple[str, int, int]
"""Path, time of the last change, and size."""


@dataclass(frozen=True)
class OpenedProbe:
    """A probe's panorama, and the outlines of its edits' regions as lines of the picture, (N, 2, 2) each."""

    state: FileState
    panorama: SpectralPanorama
    outlines: tuple[NDArray[np.floating[Any]], ...] = field(default=())


class ProbeMemory:
    """Holds one probe. Its methods may be called from any thread: what is held is exchanged as a whole."""

    def __init__(self) -> None:
        self._held: OpenedProbe | None = None
        self._picture: Path | None = None

    def peek(self, path: Path) -> OpenedProbe | None:
        """The probe of a file if it is held, without a look at the disk."""
        held = self._held
        return held if held is not None and held.state[0] == str(path) else None

    def read(self, path: Path) -> OpenedProbe:
        """The probe of a file, read if it is not held or its file has changed.

        Raises
        ------
        SpectralProbeError
            If it cannot be read.
        """
        from ...spectral_probe.files.panorama_file import read_panorama

        held = self._held
        if held is not None and path.is_file() and held.state == _state(path):
            return held
        return self.keep(path, read_panorama(path))

    def keep(self, path: Path, panorama: SpectralPanorama) -> OpenedProbe:
        """Hold a panorama that was read from a file or just written to it."""
        from ...spectral_probe.geometry.arcs import mask_outline
        from ...spectral_probe.spectra.edits import edited_mask

        masks = (edited_mask(panorama, number) for number in range(len(panorama.edits)))
        held = OpenedProbe(_state(path), panorama, tuple(mask_outline(mask) for mask in masks))
        self._held = held
        return held

    def forget(self) -> None:
        """Hold nothing."""
        self._held = self._picture = None

    @property
    def picture(self) -> Path | None:
        """The file whose pixels the panorama's image shows: undo brings its path back, not its pixels."""
        return self._picture

    @picture.setter
    def picture(self, path: Path) -> None:
        self._picture = path


def _state(path: Path) -> FileState:
    status = path.stat()
    return str(path), status.st_mtime_ns, status.st_size


MEMORY = ProbeMemory()
"""The one of this Blender: a file's probe is the same for all its windows."""


@bpy.app.handlers.persistent
def forget_probe(*_: Any) -> None:
    """Another file is opened."""
    MEMORY.forget()

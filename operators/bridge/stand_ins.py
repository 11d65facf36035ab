"""Copies of the scene's materials and lamps that take their place for a while: the user's node trees are never edited."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any

import bpy

from ...spectral_probe.errors import RenderError, SpectralProbeError
from .restore import in_scene, refuse_linked, stand_in
from .shaders import own_trees


@dataclass(frozen=True)
class Copy:
    """A stand-in: the original's name and what it is, its copy, and the node trees of the copy with all groups."""

    name: str
    kind: str
    datablock: Any
    trees: list[bpy.types.NodeTree]

    @property
    def label(self) -> str:
        """How messages call the original."""
        return f'{self.kind} "{self.name}"'


@contextmanager
def material_copies(scene: bpy.types.Scene) -> Iterator[list[Copy]]:
    """A stand-in for each material of the scene while the block runs."""
    with _copies(scene, [m for m in bpy.data.materials if not m.is_grease_pencil], "Material") as copies:
        yield copies


@contextmanager
def lamp_copies(scene: bpy.types.Scene) -> Iterator[list[Copy]]:
    """A stand-in for each lamp of the scene while the block runs."""
    with _copies(scene, bpy.data.lights, "Lamp") as copies:
        yield copies


@contextmanager
def _copies(scene: bpy.types.Scene, candidates: Any, kind: str) -> Iterator[list[Copy]]:
    originals = in_scene(scene, candidates)
    copies: list[Copy] = []
    with ExitStack() as stack:
        for original in originals:
            datablock = original.copy()
            stack.enter_context(stand_in(original, datablock))
            datablock.animation_data_clear()
            trees = own_trees(datablock.node_tree, stack) if datablock.node_tree else []
            copies.append(Copy(original.name, kind, datablock, trees))
        refuse_linked(scene, originals, kind)
        yield copies


@contextmanager
def naming(label: str) -> Iterator[None]:
    """Say in an error message which material or lamp it is about."""
    try:
        yield
    except SpectralProbeError as error:
        raise RenderError(f"{label}: {error}") from error

"""Changing Blender data for a while, and putting it back exactly."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

import bpy

from ...spectral_probe.errors import RenderError


def is_gone(datablock: bpy.types.ID | None) -> bool:
    """Whether a datablock was removed from the file since this reference to it was made."""
    try:
        return datablock is not None and not datablock.name
    except ReferenceError:
        return True


@contextmanager
def changed(
    owner: bpy.types.bpy_struct, layer: bpy.types.ViewLayer | None = None, /, **values: Any
) -> Iterator[None]:
    """Set properties of a Blender structure while the block runs, in the order given.

    They come back in the same order: what a format allows depends on the properties before. What the user has removed
    meanwhile needs nothing put back; `layer` is the view layer, if any, that the structure is or belongs to.
    """
    home = owner.id_data  # parts of a datablock do not tell that it was removed
    before = {name: getattr(owner, name) for name in values}
    group = isinstance(owner, bpy.types.PropertyGroup)
    unset = [name for name in values if group and not owner.is_property_set(name)]
    try:
        for name, value in values.items():
            setattr(owner, name, value)
        yield
    finally:
        if not is_gone(home) and (layer is None or layer in home.view_layers[:]):
            for name, value in before.items():
                with suppress(ReferenceError):  # a value that was removed cannot come back
                    setattr(owner, name, value)
            for name in unset:  # an add-on's property that was never set is so again
                owner.property_unset(name)


@contextmanager
def stand_in(original: bpy.types.ID, replacement: bpy.types.ID) -> Iterator[None]:
    """Let every user of a datablock use another one while the block runs, then remove the other.

    This reaches every kind of use alike: slots of meshes and of objects, overrides, geometry nodes.
    """
    original.user_remap(replacement)
    try:
        yield
    finally:
        if not is_gone(original) and not is_gone(replacement):
            replacement.user_remap(original)
        remove(replacement)


def remove(datablock: bpy.types.ID) -> None:
    """Remove a temporary datablock, unless the user has."""
    if not is_gone(datablock):
        bpy.data.batch_remove([datablock])


def refuse_linked(scene: bpy.types.Scene, datablocks: list[Any], kind: str) -> None:
    """Raise a `RenderError` if the scene still uses datablocks that have stand-ins: data of other files keeps its own."""
    for datablock in in_scene(scene, datablocks):
        raise RenderError(
            f'{kind} "{datablock.name}" is used by data linked from another file. Make it local '
            "(Object > Relations > Make Local > All) before a spectral render."
        )


def in_scene(scene: bpy.types.Scene, datablocks: Any) -> list[Any]:
    """Those of the datablocks that the scene uses, however indirectly."""
    users = bpy.data.user_map()
    reached: dict[bpy.types.ID, bool] = {}

    def reaches(datablock: bpy.types.ID) -> bool:
        pending, seen = [datablock], {datablock}
        while pending:
            current = pending.pop()
            if current == scene or reached.get(current):
                reached[datablock] = True
                return True
            new = users.get(current, set()) - seen
            seen |= new
            pending.extend(new)
        return False

    return [datablock for datablock in datablocks if reaches(datablock)]

"""The paths in our settings: Blender follows those of its own datablocks when files move, not those of extensions.

A path is a text property of the kind of a file or folder, or any other text of ours that begins with "//", such as a ball's
material from a file. Groups that a datablock has no data of are not looked into: that would make them.
"""

import os
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import bpy

from ...versions import Stored, stored_settings

RELATIVE = "//"

_PATHS = {"FILE_PATH", "DIR_PATH"}


@dataclass(frozen=True)
class PathField:
    """A setting that holds a path.

    Parameters
    ----------
    owner
        Group of settings.
    name
        Of its property.
    kind
        "FILE_PATH", "DIR_PATH", or "NONE" for other texts.
    """

    owner: bpy.types.PropertyGroup
    name: str
    kind: str

    @property
    def text(self) -> str:
        """As it stands in the settings."""
        return str(getattr(self.owner, self.name))

    def set(self, text: str) -> None:
        """Write another path, where it is another."""
        if text != self.text:
            setattr(self.owner, self.name, text)

    def path(self) -> Path | None:
        """The absolute path; None where it is relative to a file that was never saved."""
        text = self.text
        if text.startswith(RELATIVE) and not bpy.data.filepath:
            return None
        return Path(bpy.path.abspath(text))


def blocks_with_settings() -> Iterator[bpy.types.ID]:
    """Every datablock of the file that has settings of ours."""
    for blocks in (bpy.data.scenes, bpy.data.materials, bpy.data.lights):
        yield from (block for block in blocks if stored_settings(block) is not None)


def path_fields(block: bpy.types.ID) -> Iterator[PathField]:
    """The paths in a datablock's settings, empty ones left out."""
    stored = stored_settings(block)
    if stored is not None:
        yield from _fields(block.spectral_probe, stored)


def _fields(group: bpy.types.PropertyGroup, stored: Stored) -> Iterator[PathField]:
    for prop in group.bl_rna.properties:
        name = prop.identifier
        if prop.type == "STRING" and name != "name":
            field = PathField(group, name, prop.subtype)
            if field.text and (prop.subtype in _PATHS or field.text.startswith(RELATIVE)):
                yield field
        elif name in stored and prop.type in {"POINTER", "COLLECTION"}:
            value = getattr(group, name)
            if prop.type == "COLLECTION":
                for item, kept in zip(value, stored[name], strict=True):
                    yield from _fields(item, kept)
            elif isinstance(value, bpy.types.PropertyGroup):
                yield from _fields(value, stored[name])


# ---------------------------------------------------------------- moving


def follow(blocks: Iterable[bpy.types.ID], old_folder: Path, new_folder: Path | None) -> Callable[[], None]:
    """Keep relative paths pointing to what they point to now, when the file they are relative to moves.

    A path that points to nothing is left, such as that of a folder which a render will make.

    Parameters
    ----------
    blocks
        Datablocks.
    old_folder
        Folder that their paths are relative to.
    new_folder
        Folder that they will be relative to; None makes them absolute.

    Returns
    -------
    callable
        Puts back what was there.
    """
    before: list[tuple[PathField, str]] = []
    for block in blocks:
        for field in path_fields(block):
            text = field.text
            if not text.startswith(RELATIVE):
                continue
            path = Path(bpy.path.abspath(text, start=str(old_folder)))
            if path.exists():
                before.append((field, text))
                field.set(_written(path, new_folder, text))

    def put_back() -> None:
        for field, text in before:
            field.set(text)

    return put_back


def make_relative(blocks: Iterable[bpy.types.ID]) -> int:
    """Make absolute paths relative to the .blend, where they can be; how many were."""
    folder = Path(bpy.data.filepath).parent
    changed = 0
    for field in _own(blocks):
        text, prop = field.text, field.owner.bl_rna.properties[field.name]
        if not prop.is_path_supports_blend_relative or not Path(text).is_absolute():
            continue
        written = _written(Path(text), folder, text)
        changed += written != text
        field.set(written)
    return changed


def make_absolute(blocks: Iterable[bpy.types.ID]) -> int:
    """Make paths that are relative to the .blend absolute; how many were."""
    changed = 0
    for field in _own(blocks):
        text = field.text
        if text.startswith(RELATIVE):
            changed += 1
            field.set(_written(Path(bpy.path.abspath(text)), None, text))
    return changed


def _own(blocks: Iterable[bpy.types.ID]) -> Iterator[PathField]:
    for block in blocks:
        if block.library is None:
            yield from list(path_fields(block))


def _written(path: Path, folder: Path | None, like: str) -> str:
    """A path as text, relative to a folder unless they have no common root; it ends with a slash where `like` does."""
    path = Path(os.path.normpath(path))
    end = "/" if like.endswith(("/", "\\")) else ""
    if folder is not None:
        try:
            return RELATIVE + os.path.relpath(path, folder).replace(os.sep, "/") + end
        except ValueError:  # on another drive
            pass
    return str(path) + end

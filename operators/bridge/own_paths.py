"""The paths in our settings: Blender follows those of its own datablocks when files move, not those of extensions.

A path is a text property of the kind of a file or folder, or any other text of ours that begins with "//", such as a ball's
material from a file. Groups that a datablock has no data of are not looked into: that would make them.
"""

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path, PureWindowsPath

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


def local_blocks() -> list[bpy.types.ID]:
    """Those that belong to this file: linked ones are changed in theirs."""
    return [block for block in blocks_with_settings() if block.library is None]


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
        text = field.text
        if field.kind not in _PATHS or not Path(text).is_absolute():
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
        yield from list(path_fields(block))  # a list: they are changed on the way


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


# ---------------------------------------------------------------- missing


MARKERS = {"probe_directory": "probe.exr", "render_directory": "xyz.exr"}
"""The file by which a folder of ours is known."""

_NOT_NEEDED = {"capture_path"}
"""Files that nothing reads again."""


def missing(blocks: Iterable[bpy.types.ID]) -> dict[str, list[PathField]]:
    """Files that settings name and that are not there: the absolute path of each, and the settings that name it.

    A folder of results counts where something was made in it; it is told by the file that it is known by.
    """
    gone: dict[str, list[PathField]] = {}
    for block in blocks:
        for field in path_fields(block):
            wanted = _needed(field)
            if wanted is not None and not wanted.exists():
                gone.setdefault(str(wanted), []).append(field)
    return gone


def _needed(field: PathField) -> Path | None:
    """The file that a setting needs, None where it needs none, such as where it is a name of the library."""
    text, path = field.text, field.path()
    marker = _marker(field)
    if marker:
        made = field.owner.probe.width_px if field.name == "probe_directory" else field.owner.render.passes
        return path / marker if made and path is not None else None
    if field.kind == "DIR_PATH" or field.name in _NOT_NEEDED or path is None:
        return None
    return path if text.startswith(RELATIVE) or Path(text).is_absolute() or _of_windows(text) else None


def _marker(field: PathField) -> str:
    """The file that the folder of a setting is known by; none where it follows another setting."""
    whole = field.owner == field.owner.id_data.spectral_probe
    return MARKERS.get(field.name, "") if whole else ""


def _of_windows(text: str) -> bool:
    return PureWindowsPath(text).is_absolute()


def put_found(gone: Mapping[str, list[PathField]], found: Mapping[str, Path]) -> int:
    """Write where missing files were found into the settings that name them; how many files these were.

    A folder takes those that lie in it along. Where a path was relative, it is again.
    """
    for old, new in found.items():
        for field in gone[old]:
            text = field.text
            folder = Path(bpy.data.filepath).parent if text.startswith(RELATIVE) else None
            marker = _marker(field)
            place = new.parent if marker else new
            field.set(_written(place, folder, text))
            if marker:
                _take_along(field.owner, text, field.text)
                _take_images(Path(old).parent, place)
    return len(found)


def _take_along(settings: bpy.types.PropertyGroup, old: str, new: str) -> None:
    """Results in a folder that was found lie where it lies."""
    for field in list(path_fields(settings.id_data)):
        rest = field.text.removeprefix(old.rstrip("/\\"))
        if field.kind == "DIR_PATH" and rest != field.text and rest[:1] in {"", "/", "\\"}:
            field.set(new.rstrip("/\\") + rest)


def _take_images(old: Path, new: Path) -> None:
    """Pictures of a folder that was found, such as the world's panorama, are shown from where it lies."""
    for image in bpy.data.images:
        path = Path(bpy.path.abspath(image.filepath)) if image.filepath else None
        if image.library is not None or path is None or not path.is_relative_to(old) or path.exists():
            continue
        there = new / path.relative_to(old)
        if there.is_file():
            folder = Path(bpy.data.filepath).parent if image.filepath.startswith(RELATIVE) else None
            image.filepath = _written(there, folder, "")
            image.reload()

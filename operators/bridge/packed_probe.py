"""A probe's files inside the .blend, and out again where they are missing.

Blender packs what image datablocks show; such a datablock holds each file byte by byte, report.json a text. What can be made
again from probe.exr is left out (spectral.exr, layers.exr), and so are the plots. Edited light goes along in the state that
lights the scene.

Where a file with a packed probe is opened and the folder of the probe is not there, the copy is written into a temporary
folder of the session, in which `settings.built_folder` finds it: the settings stay as they are. Edits are made there, too,
and are packed anew when the .blend is saved.
"""

import hashlib
import re
from collections.abc import Iterable
from pathlib import Path

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ...spectral_probe.errors import FileFormatError
from ...spectral_probe.files.atomic import check_folder, written_whole

PROBE = "probe.exr"
_FILES = (PROBE, "world.exr", "report.json", "preview.png", "confidence.png")
EDITS = "edits"
_TEXTS = ".json"
_IMAGE_NAME = "Spectral Probe File"


def packable(folder: Path, state: str) -> list[tuple[str, Path]]:
    """The files of a probe that are packed: place in its folder, and path.

    Parameters
    ----------
    folder
        Of the probe as it was built.
    state
        Folder of its edited light within edits/; empty where there is none.
    """
    names = [*_FILES, *(f"{EDITS}/{state}/{name}" for name in _FILES if state)]
    return [(name, folder / name) for name in names if (folder / name).is_file()]


def pack(settings: bpy.types.PropertyGroup, folder: Path) -> int:
    """Put a copy of a probe's files into the .blend, in place of an earlier one; returns their size in bytes.

    Raises
    ------
    FileFormatError
        If a file cannot be read, or there is no probe.
    """
    found = packable(folder, settings.edits.state)
    if not any(name == _lit_by(settings) for name, _ in found):  # an earlier copy is better than none
        raise FileFormatError(
            rpt_(
                "{path} is not there, and was not packed. Find it, or build the probe again; an earlier copy stays."
            ).format(path=folder / _lit_by(settings))
        )
    try:
        contents = [(name, path, path.read_bytes()) for name, path in found]
    except OSError as problem:
        raise FileFormatError(
            f"{problem.filename} cannot be read ({problem.strerror}). Build the probe again."
        ) from None
    remove(settings)
    for name, path, content in contents:
        item = settings.packed.files.add()
        item.name, item.digest, item.size_bytes = name, _digest(content), len(content)
        if path.suffix == _TEXTS:
            item.text = content.decode("utf-8")
        else:
            item.image = _packed_image(path, content)
    settings.packed.outdated = False
    return sum(len(content) for _, _, content in contents)


def _lit_by(settings: bpy.types.PropertyGroup) -> str:
    """The file whose light the scene has now."""
    state = settings.edits.state
    return f"{EDITS}/{state}/{PROBE}" if state else PROBE


def remove(settings: bpy.types.PropertyGroup) -> None:
    """Take the copy out of the .blend; what a copy of the scene holds, too, stays."""
    images = {item.image for item in settings.packed.files if item.image is not None}
    settings.property_unset("packed")
    for image in images:
        if not image.users:
            bpy.data.images.remove(image)


def is_packed(settings: bpy.types.PropertyGroup) -> bool:
    """Whether the .blend holds a copy of the probe."""
    return bool(settings.packed.files)


def temporary_folder(settings: bpy.types.PropertyGroup) -> Path:
    """The folder of this session in which a packed probe lies where its own is missing."""
    digests = "".join(item.digest for item in settings.packed.files if EDITS not in item.name)
    return Path(bpy.app.tempdir) / "spectral_probe" / _digest(digests.encode())


def differing(settings: bpy.types.PropertyGroup, folder: Path) -> list[str]:
    """Packed files whose place in a folder is taken by others."""
    return [
        item.name
        for item in settings.packed.files
        if _is_ours(item.name)
        and (folder / item.name).is_file()
        and _digest((folder / item.name).read_bytes()) != item.digest
    ]


def unpack(settings: bpy.types.PropertyGroup, folder: Path) -> list[Path]:
    """Write the packed files that are missing into a folder; returns those written.

    Raises
    ------
    FileFormatError
        If other files are in their place, which are never replaced, or the folder cannot be written to.
    """
    check_folder(folder)
    others = differing(settings, folder)
    if others:
        raise FileFormatError(
            f"{folder} holds another probe than the .blend ({', '.join(others)}). Choose another folder to unpack to."
        )
    return _write(settings, folder)


def unpack_for_session(settings: bpy.types.PropertyGroup) -> None:
    """Write the packed files into the temporary folder of the session, where the folder of the probe is not there."""
    if not (_own_folder(settings) / PROBE).is_file() or not _state_is_there(settings):
        _write(settings, temporary_folder(settings))


def _state_is_there(settings: bpy.types.PropertyGroup) -> bool:
    state = settings.edits.state
    return not state or (_own_folder(settings) / EDITS / state / PROBE).is_file()


def _own_folder(settings: bpy.types.PropertyGroup) -> Path:
    return Path(bpy.path.abspath(settings.probe_directory))


def _write(settings: bpy.types.PropertyGroup, folder: Path) -> list[Path]:
    written = []
    for item in settings.packed.files:
        if not _is_ours(item.name):
            continue
        path, content = folder / item.name, _content(item)
        if not path.is_file() and content is not None:
            with written_whole(path) as temporary:
                temporary.write_bytes(content)
            written.append(path)
    return written


def _is_ours(name: str) -> bool:
    """Whether a packed file's name is one that packing gives. A .blend is anybody's file: other names may lead anywhere."""
    state, _, file = name.rpartition("/")
    return file in _FILES and (not state or re.fullmatch(rf"{EDITS}/[\w-]+", state) is not None)


def _content(item: bpy.types.PropertyGroup) -> bytes | None:
    """What was packed; None where the datablock was unpacked, changed or deleted by the user."""
    if item.text:
        content = item.text.encode("utf-8")
    elif item.image is not None and item.image.packed_file is not None:
        content = item.image.packed_file.data
    else:
        return None
    return content if _digest(content) == item.digest else None


def _packed_image(path: Path, content: bytes) -> bpy.types.Image:
    """A datablock with a file's content; one that shows the file, such as the world's, keeps it too, and shares it."""
    shown = next((image for image in _images() if _shows(image, path)), None)
    if shown is not None:
        shown.pack()
        image = shown.copy()
        image.name = f"{_IMAGE_NAME} {path.name}"
    else:
        image = bpy.data.images.new(f"{_IMAGE_NAME} {path.name}", 1, 1)
    image.pack(data=content, data_len=len(content))
    return image


def _images() -> Iterable[bpy.types.Image]:
    return (image for image in bpy.data.images if image.library is None and image.source == "FILE")


def _shows(image: bpy.types.Image, path: Path) -> bool:
    return bool(image.filepath) and Path(bpy.path.abspath(image.filepath)) == path


def _digest(content: bytes) -> str:
    return hashlib.blake2b(content, digest_size=12).hexdigest()

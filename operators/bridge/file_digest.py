"""Digests of files by what they hold: neither where a file lies nor when it was written shapes a picture.

So a scene is the same on another machine, under another mount point, and copied together with its textures.
"""

import hashlib
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

import bpy

from .own_paths import blocks_with_settings, path_fields

_DIGEST_BYTES = 16
_WHOLE_UP_TO = 2**30
_BLOCK, _BLOCKS = 2**20, 64
_REMEMBERED = 4096


def file_digest(path: Path) -> str:
    """Digest of a file's size and content; "" where there is none.

    Of a file over 1 GiB, such as a cache of moving geometry, 64 blocks of 1 MiB are read, evenly spread from first to last.
    """
    try:
        if not path.is_file():
            return ""
        status = path.stat()
        return _digest(str(path), status.st_size, status.st_mtime_ns)
    except OSError:
        return ""


@lru_cache(maxsize=_REMEMBERED)
def _digest(path: str, size: int, _mtime_ns: int) -> str:
    """Digest of a file's content, once for each state of the file: every frame of an animation asks again."""
    digest = hashlib.blake2b(str(size).encode(), digest_size=_DIGEST_BYTES)
    with Path(path).open("rb") as file:
        if size <= _WHOLE_UP_TO:
            while block := file.read(_BLOCK):
                digest.update(block)
        else:
            for number in range(_BLOCKS):
                file.seek((size - _BLOCK) * number // (_BLOCKS - 1))
                digest.update(file.read(_BLOCK))
    return digest.hexdigest()


def opened_files_digest() -> str:
    """Digest of the .blend that was opened and of all files that it names, each by content; "" where it was never saved.

    Of a scene that was opened and not changed since, it says as much as its fingerprint, but for what this machine's processor
    makes of it: modifiers and drivers may differ in the last bits of a number on another.
    """
    if not bpy.data.filepath:
        return ""
    files = sorted(filter(None, (file_digest(path) for path in {*named_files()})))
    whole = file_digest(Path(bpy.data.filepath))
    return hashlib.blake2b(repr((whole, files)).encode(), digest_size=_DIGEST_BYTES).hexdigest()


def named_files() -> Iterator[Path]:
    """Files that the opened .blend names: Blender's own, every tile of an image, our settings', and inputs of nodes."""
    from .fingerprint import image_files

    yield from map(Path, bpy.utils.blend_paths(absolute=True, packed=False, local=False))
    for image in bpy.data.images:
        yield from image_files(image)
    for block in blocks_with_settings():
        yield from (path for field in path_fields(block) if (path := field.path()) is not None)
    for tree in bpy.data.node_groups:
        for node in tree.nodes:
            for socket in node.inputs:
                if socket.type == "STRING" and socket.default_value:
                    yield Path(bpy.path.abspath(socket.default_value, library=tree.library))

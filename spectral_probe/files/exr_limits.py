"""What an OpenEXR file says of its size, looked at before the library allocates what a hostile or damaged header claims.

By "OpenEXR File Layout" of the OpenEXR documentation. The library trusts the data window: a file of 400 bytes may claim
16 exabytes. Pixels that a file claims are held against three limits:

- what its compression can have packed into its bytes (`MOST_PER_BYTE`);
- its table of blocks, each of which takes bytes of its own, and all of which must be there;
- the memory that is free (`check_memory`), for a reader that takes the whole picture at once. A reader by rows needs only
  the first two: 16384 x 8192 pixels of 61 half channels, 16 GB, are read so.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from ..errors import FileFormatError

MAGIC = b"v/1\x01"

MOST_PER_BYTE: Mapping[int, int] = {
    0: 1,
    1: 65,
    2: 1100,
    3: 1100,
    4: 600,
    5: 1500,
    6: 4,
    7: 16,
    8: 10_000,
    9: 10_000,
}
"""Bytes of pixels that one byte of a file can stand for, by the number of its compression: none, RLE, ZIPS, ZIP, PIZ, PXR24, B44,
B44A, DWAA, DWAB. Black pictures measured with OpenEXR 3.5: 1, 64, 930, 983, 409, 1304, 2.3, 11, 1257, 4993; deflate cannot reach
1033, PXR24 gives a fourth to floats, PIZ has a code for 255 words. A higher number belongs to a JPEG 2000 of `_WAVELETS`."""

_WAVELETS = 200_000
"""As above, for HTJ2K32 and HTJ2K256 and what may come after them: 102,802 were measured."""

_HEADER_SLACK_BYTES = 4096
"""What so small a picture may claim beyond its limit: its file is mostly header."""

_LINES = {0: 1, 1: 1, 2: 1, 3: 16, 4: 32, 5: 16, 6: 32, 7: 32, 8: 32, 9: 256}  # of a block, by compression
_PIXEL_BYTES = {0: 4, 1: 2, 2: 4}  # unsigned, half, float
_SINGLE_TILE, _DEEP, _MULTI_PART = 0x200, 0x800, 0x1000
_LONGEST_NAME = 256
_MOST_CHANNELS = 20_000
_MOST_PARTS = 1000
_LARGEST_SIDE = 1 << 24
_LARGEST_TILE_BYTES = 1 << 28
_FREE_SHARE = 0.8
_ONCE = ("channels", "compression", "dataWindow", "displayWindow", "tiles", "type", "chunkCount")
"""Attributes that say how large a picture is: two of a name would leave open which of them the library takes."""


@dataclass(frozen=True)
class ExrPart:
    """One picture of a file.

    Parameters
    ----------
    width, height
        Of its data window, in pixels.
    channels
        Names of its channels.
    pixel_bytes
        What its pixels take in memory, each in the type it is stored in.
    compression
        Number of its compression.
    blocks
        The fewest entries that its table of blocks can have.
    deep
        Whether its pixels hold lists of samples.
    """

    width: int
    height: int
    channels: tuple[str, ...]
    pixel_bytes: int
    compression: int
    blocks: int
    deep: bool


def check_exr(path: Path) -> tuple[ExrPart, ...]:
    """The parts of a file, whose header is sound, and all of whose blocks are there as far as its table tells.

    Raises
    ------
    FileFormatError
        If not, or if it claims more pixels than its bytes can hold.
    """
    path = Path(path)
    size = path.stat().st_size
    with _explained(path), path.open("rb") as file:
        parts, flags = _header(path, file)
        for part in parts:
            most = MOST_PER_BYTE.get(part.compression, _WAVELETS) * size + _HEADER_SLACK_BYTES
            if 8 * part.blocks > size or (part.pixel_bytes > most and not part.deep):
                raise EOFError
        _check_blocks(file, size, parts, flags)
    return parts


def exr_parts(path: Path) -> tuple[ExrPart, ...]:
    """The parts of a file as its header claims them: sound, but perhaps more than the file can hold.

    Raises
    ------
    FileFormatError
        If the header is no header.
    """
    path = Path(path)
    with _explained(path), path.open("rb") as file:
        return _header(path, file)[0]


@contextmanager
def _explained(path: Path) -> Iterator[None]:
    """What goes wrong while a file is looked at, as sentences."""
    try:
        yield
    except OSError as problem:
        raise FileFormatError(
            f"{path} cannot be read ({problem.strerror}). Check its permissions and its disk."
        ) from None
    except EOFError:
        raise FileFormatError(
            f"{path.name} cannot be read: it is cut short, the file ends before its picture does. Copy or export it again."
        ) from None
    except (struct.error, ValueError):
        raise FileFormatError(
            f"{path.name} cannot be read: it is broken or not what its name says. Export or copy it again."
        ) from None


def check_readable(path: Path) -> None:
    """Refuse a file that the library should not be asked to read whole: see `check_exr` and `check_memory`; and deep ones.

    Raises
    ------
    FileFormatError
        If so.
    """
    parts = check_exr(path)
    refuse_deep(path, parts)
    check_memory(path, parts)


def refuse_deep(path: Path, parts: Sequence[ExrPart]) -> None:
    """Refuse a deep picture, which nothing here can read.

    Raises
    ------
    FileFormatError
        If a part is deep.
    """
    if any(part.deep for part in parts):
        raise FileFormatError(
            f"{Path(path).name} is a deep picture, of samples in a list a pixel. Flatten it first."
        )


def check_memory(path: Path, parts: Sequence[ExrPart]) -> None:
    """Refuse to read a whole file whose pixels the free memory does not hold.

    Raises
    ------
    FileFormatError
        If so.
    """
    import psutil

    needed, free = sum(part.pixel_bytes for part in parts), psutil.virtual_memory().available
    if needed > _FREE_SHARE * free:
        largest = max(parts, key=lambda part: part.pixel_bytes)
        raise FileFormatError(
            f"{path.name} takes {needed / 1e9:.1f} GB of memory ({largest.width} x {largest.height} pixels, "
            f"{len(largest.channels)} channels), and {free / 1e9:.1f} GB are free. Close other programs, or give a smaller one."
        )


# ---------------------------------------------------------------- the header


def _header(path: Path, file: BinaryIO) -> tuple[tuple[ExrPart, ...], int]:
    """All parts, and the file's flags; EOFError where it ends too early, ValueError where it is no such file."""
    if file.read(4) != MAGIC:
        raise FileFormatError(f"{path.name} is not an OpenEXR image.")
    size, flags = path.stat().st_size, _whole(_taken(file, 4))
    parts: list[ExrPart] = []
    while True:
        attributes = dict(_attributes(file, size))
        if not attributes and parts:
            break
        parts.append(_part(attributes, flags, size))
        if not flags & _MULTI_PART:
            break
        if len(parts) > _MOST_PARTS:
            raise ValueError("too many parts")
    return tuple(parts), flags


def _attributes(file: BinaryIO, size: int) -> Iterator[tuple[str, bytes]]:
    """Names and values of one header, up to the zero that ends it; of those that do not count here, the value is left out."""
    seen = set()
    while name := _text(file):
        kind = _text(file)
        length = _whole(_taken(file, 4))
        if length > size - file.tell():
            raise EOFError
        if name in seen and name in _ONCE:
            raise ValueError(f"two attributes {name}")
        seen.add(name)
        if name in _ONCE:
            yield name, _taken(file, length)
        elif kind == "string":  # the library takes text for UTF-8, and complains on standard output
            _taken(file, length).decode("utf-8")
            yield name, b""
        else:
            file.seek(length, 1)
            yield name, b""


def _part(attributes: Mapping[str, bytes], flags: int, size: int) -> ExrPart:
    """One part from its attributes."""
    missing = {"channels", "compression", "dataWindow"} - set(attributes)
    if missing:
        raise ValueError(f"no {', '.join(missing)}")
    left, top, right, bottom = struct.unpack("<4i", attributes["dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    if not (0 < width <= _LARGEST_SIDE and 0 < height <= _LARGEST_SIDE):
        raise ValueError("a size that is none")
    channels = tuple(_channels(attributes["channels"]))
    if not 0 < len(channels) <= _MOST_CHANNELS or len({name for name, *_ in channels}) < len(channels):
        raise ValueError("no channels, or two of a name")
    (compression,) = struct.unpack("<B", attributes["compression"])
    kind = attributes.get("type", b"").rstrip(b"\0")
    deep = kind.startswith(b"deep") or bool(flags & _DEEP and not flags & _MULTI_PART)
    per_pixel = sum(kept for _, kept, _, _ in channels)
    blocks = -(-height // _LINES.get(compression, 1 << 24))
    if kind in (b"tiledimage", b"deeptile") or (flags & _SINGLE_TILE and not flags & _MULTI_PART):
        blocks = _tiles(attributes.get("tiles", b""), width, height, per_pixel)
    if "chunkCount" in attributes and not 0 < struct.unpack("<i", attributes["chunkCount"])[0] <= size // 8:
        raise EOFError
    pixel_bytes = sum(kept * -(-width // across) * -(-height // down) for _, kept, across, down in channels)
    return ExrPart(
        width, height, tuple(name for name, *_ in channels), pixel_bytes, compression, blocks, deep
    )


def _channels(data: bytes) -> Iterator[tuple[str, int, int, int]]:
    """Name, bytes of a pixel, and sampling across and down of each channel."""
    at = 0
    while at < len(data) and data[at]:
        end = data.index(0, at)
        if end - at >= _LONGEST_NAME:
            raise ValueError("a name too long")
        kind, across, down = struct.unpack_from("<i4x2i", data, end + 1)
        if kind not in _PIXEL_BYTES or min(across, down) < 1:
            raise ValueError("a channel of no kind")
        yield data[at:end].decode("utf-8"), _PIXEL_BYTES[kind], across, down
        at = end + 17


def _tiles(data: bytes, width: int, height: int, per_pixel: int) -> int:
    """Tiles of the full size."""
    across = int.from_bytes(data[:4], "little")
    down = int.from_bytes(data[4:8], "little")
    if min(across, down) < 1 or across * down * per_pixel > _LARGEST_TILE_BYTES:
        raise ValueError("tiles of no size, or too large")
    return -(-width // across) * -(-height // down)


def _text(file: BinaryIO) -> str:
    """A text up to its zero."""
    found = bytearray()
    while (letter := _taken(file, 1)) != b"\0":
        found += letter
        if len(found) >= _LONGEST_NAME:
            raise ValueError("a name too long")
    return found.decode("utf-8")


def _taken(file: BinaryIO, count: int) -> bytes:
    data = file.read(count)
    if len(data) < count:
        raise EOFError
    return data


def _whole(data: bytes) -> int:
    return int.from_bytes(data, "little")


# ---------------------------------------------------------------- the blocks


def _check_blocks(file: BinaryIO, size: int, parts: Sequence[ExrPart], flags: int) -> None:
    """The table of blocks has enough entries, which point into the file; the last block is all there."""
    offsets = list(_offsets(file, size))
    if len(offsets) < sum(part.blocks for part in parts):
        raise EOFError
    if flags & (_MULTI_PART | _DEEP):  # their blocks have other heads
        return
    head = 20 if flags & _SINGLE_TILE else 8
    file.seek(max(offsets) + head - 4)
    if max(offsets) + head + _whole(_taken(file, 4)) > size:
        raise EOFError


def _offsets(file: BinaryIO, size: int) -> Iterator[int]:
    """The entries of the table, which ends where the first of the blocks begins."""
    first = size
    at = file.tell()
    while at < first:
        offset = _whole(_taken(file, 8))
        at += 8
        if not at <= offset <= size:  # 0 is what an interrupted writer leaves
            raise EOFError
        first = min(first, offset)
        yield offset

"""OpenEXR images written and read some rows at a time, so that an image of any size needs the memory of a few rows.

The OpenEXR library encodes whole images. A file of scan lines is a header, a table of where the chunks of 1 or 16 lines begin,
and the chunks (OpenEXR, "File Layout"), each encoded by itself: so the library encodes a few rows as a small image, and its
chunks are put behind one another under the first one's header. The file is to the byte what the library writes of the whole
image.
"""

from __future__ import annotations

import io
import struct
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import OpenEXR

from ..errors import FileFormatError
from ..parallel import in_order
from .silence import libraries_silenced

type Header = dict[str, Any]
type MakeRows = Callable[[slice], Mapping[str, Any]]
"""Gives the channels (h, W) of some rows by name."""

_LINES = {
    OpenEXR.NO_COMPRESSION: 1,
    OpenEXR.RLE_COMPRESSION: 1,
    OpenEXR.ZIPS_COMPRESSION: 1,
    OpenEXR.ZIP_COMPRESSION: 16,
}
"""Lines that a chunk of each compression holds."""

_BYTES_AT_A_TIME = 1 << 23
"""Of pixels that are encoded at a time in each thread."""

_PLACE = struct.Struct("<Q")
_BOX = struct.Struct("<4i")


def encode_rows(file: BinaryIO, size: tuple[int, int], make: MakeRows, attributes: Header) -> None:
    """Encode an image into an open file.

    Parameters
    ----------
    file
        Open for writing, at its beginning.
    size
        Height and width in pixels.
    make
        Gives the rows, in threads and not always in order; the same channels of the same types every time.
    attributes
        The header's, with the compression: none, RLE, ZIPS or ZIP.

    Raises
    ------
    OSError
        If there is no room.
    """
    height, width = size
    lines = _LINES[attributes["compression"]]

    def encoded(rows: slice) -> bytes:
        pixels = {name: np.ascontiguousarray(plane) for name, plane in make(rows).items()}
        if any(plane.shape != (rows.stop - rows.start, width) for plane in pixels.values()):
            raise ValueError("The rows do not fit the image.")
        corners = (np.array([0, rows.start], np.int32), np.array([width - 1, rows.stop - 1], np.int32))
        stream = io.BytesIO()
        OpenEXR.File(attributes | {"dataWindow": corners, "displayWindow": corners}, pixels).write(stream)
        return stream.getvalue()

    first = slice(0, min(lines, height))
    row_bytes = sum(plane[:1].nbytes for plane in map(np.asarray, make(first).values()))
    step = max(lines, _BYTES_AT_A_TIME // max(row_bytes, 1) // lines * lines)
    blocks = [slice(start, min(start + step, height)) for start in range(0, height, step)]
    places: list[int] = []
    table_start = 0
    for block in in_order(encoded, blocks):
        header_end, boxes = _header(block)
        count = -(-_rows_of(block, boxes["dataWindow"]) // lines)
        chunks_start = header_end + count * _PLACE.size
        if not places:
            header = bytearray(block[:header_end])
            for start in boxes.values():
                _BOX.pack_into(header, start, 0, 0, width - 1, height - 1)
            file.write(header)
            table_start = header_end
            file.write(bytes(-(-height // lines) * _PLACE.size))
        here = file.tell()
        table = np.frombuffer(block, "<u8", count, header_end).astype(np.int64)
        places += (table - chunks_start + here).tolist()
        file.write(memoryview(block)[chunks_start:])
    file.seek(table_start)
    file.write(np.array(places, "<u8").tobytes())


def _header(encoded: bytes) -> tuple[int, dict[str, int]]:
    """Where the header of an image that was just encoded ends, and where its data and display windows stand."""
    boxes = {}
    place = 8  # after the magic number and the version
    while encoded[place]:
        name_end = encoded.index(0, place)
        type_end = encoded.index(0, name_end + 1)
        (size,) = struct.unpack_from("<I", encoded, type_end + 1)
        name = encoded[place:name_end].decode()
        if name in {"dataWindow", "displayWindow"}:
            boxes[name] = type_end + 5
        place = type_end + 5 + size
    return place + 1, boxes


def _rows_of(encoded: bytes, box: int) -> int:
    _, top, _, bottom = _BOX.unpack_from(encoded, box)
    return int(bottom - top + 1)


class ExrRows:
    """An OpenEXR image of which some rows of some channels are read at a time.

    Use it in a `with` block. Tiled images are read, too, as far as the library reads them as scan lines.

    Parameters
    ----------
    path
        The file; it has been checked (`image_exr.open_rows`).

    Raises
    ------
    FileFormatError
        If it cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self._name = Path(path).name
        try:
            with libraries_silenced():
                self.header: Header = dict(OpenEXR.File(str(path), header_only=True).header())
                self._file = OpenEXR.InputFile(str(path))
                kinds = self._file.header()["channels"]
        except (RuntimeError, OSError, KeyError, ValueError) as problem:
            raise FileFormatError(
                f"{self._name} cannot be read as OpenEXR ({problem}). It may be cut short."
            ) from None
        (left, self._top), (right, bottom) = (corner.tolist() for corner in self.header["dataWindow"])
        self.width, self.height = right - left + 1, bottom - self._top + 1
        self._kinds = {name: _KINDS[str(channel.type)] for name, channel in kinds.items()}
        if any((channel.xSampling, channel.ySampling) != (1, 1) for channel in kinds.values()):
            raise FileFormatError(
                f"The channels of {self._name} differ in size. Write it without subsampling."
            )

    def __enter__(self) -> ExrRows:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the channels."""
        return tuple(self._kinds)

    def read(self, names: Sequence[str], rows: slice) -> dict[str, Any]:
        """Channels (h, W) of some rows by name, each in its own type.

        Raises
        ------
        FileFormatError
            If the file is cut short or damaged there.
        """
        first, last = self._top + rows.start, self._top + rows.stop - 1
        try:
            with libraries_silenced():
                found = self._file.channels(list(names), scanLine1=first, scanLine2=last)
        except (OSError, RuntimeError):
            raise FileFormatError(
                f"{self._name} is damaged or cut short: its pixels cannot be read. Write it again."
            ) from None
        shape = (rows.stop - rows.start, self.width)
        return {
            name: np.frombuffer(pixels, self._kinds[name]).reshape(shape)
            for name, pixels in zip(names, found, strict=True)
        }

    def blocks(self, channels: int | None = None) -> list[slice]:
        """The rows in parts that need little memory, whole chunks each; of all channels, or of so many at a time."""
        row_bytes = 4 * self.width * (len(self._kinds) if channels is None else channels)
        step = max(16, _BYTES_AT_A_TIME // max(row_bytes, 1) // 16 * 16)
        return [slice(start, min(start + step, self.height)) for start in range(0, self.height, step)]


_KINDS = {"HALF": np.float16, "FLOAT": np.float32, "UINT": np.uint32}

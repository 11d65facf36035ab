"""The directories of files built as TIFF (TIFF, DNG, NEF, ARW, CR2, PEF, ...): what pictures they hold, and whether whole."""

from __future__ import annotations

import struct
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from ..errors import PhotographError
from .file_kind import Bytes, broken, check_size, cut_short, mapped, number

EXIF_IFD = 0x8769

TAGS_UNREADABLE = (
    OSError,
    SyntaxError,
    ValueError,
    KeyError,
    TypeError,
    IndexError,
    OverflowError,
    struct.error,
)
"""What Pillow raises over damaged EXIF tags."""

_WIDTH, _HEIGHT, _BITS, _PHOTOMETRIC, _SAMPLES, _FORMAT = 256, 257, 258, 262, 277, 339
_STRIPS, _STRIP_BYTES, _TILES, _TILE_BYTES = 273, 279, 324, 325
_NEXT_INSIDE, _DNG_VERSION = 330, 50706
_CFA, _LINEAR_RAW = 32803, 34892
_SIZES = {1: 1, 3: 2, 4: 4, 13: 4, 16: 8, 18: 8}  # bytes of the unsigned types
_MOST_DIRECTORIES = 64
_MOST_VALUES = 2_000_000


@dataclass(frozen=True)
class Directory:
    """One picture of the file; every tag holds its unsigned numbers."""

    tags: Mapping[int, Sequence[int]]

    def first(self, tag: int, default: int = 0) -> int:
        """The first value of a tag."""
        values = self.tags.get(tag)
        return values[0] if values else default

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height."""
        return self.first(_WIDTH), self.first(_HEIGHT)

    @property
    def bits(self) -> int:
        """Bits of a sample."""
        return self.first(_BITS, 1)

    @property
    def floating(self) -> bool:
        """Whether samples are floating-point numbers."""
        return self.first(_FORMAT, 1) == 3

    @property
    def samples(self) -> int:
        """Samples of a pixel."""
        return self.first(_SAMPLES, 1)

    @property
    def photometric(self) -> int:
        """How samples are meant: 0 and 1 grey, 2 RGB, 3 palette, 5 CMYK, 6 YCbCr."""
        return self.first(_PHOTOMETRIC, 1)

    @property
    def raw(self) -> bool:
        """Whether it holds a sensor's values."""
        return self.photometric in (_CFA, _LINEAR_RAW) or _DNG_VERSION in self.tags

    @property
    def end(self) -> int:
        """Where in the file its last strip or tile ends."""
        ends = [0]
        for starts, counts in ((_STRIPS, _STRIP_BYTES), (_TILES, _TILE_BYTES)):
            pairs = zip(self.tags.get(starts, ()), self.tags.get(counts, ()), strict=False)
            ends += [start + count for start, count in pairs]
        return max(ends)


def directories(path: Path) -> list[Directory]:
    """All directories of a file built as TIFF, those inside others too; the first is the file's main one.

    Raises
    ------
    PhotographError
        If the file ends before its directories do.
    """
    data = mapped(path)
    order: Literal["little", "big"] = "little" if data[0] == ord("I") else "big"
    big = number(data, 2, 2, order) == 43
    width = 8 if big else 4
    found: list[Directory] = []
    try:
        waiting, seen = [number(data, 8 if big else 4, width, order)], set[int]()
        while waiting and len(found) < _MOST_DIRECTORIES:
            at = waiting.pop(0)
            if at == 0 or at in seen:
                continue
            seen.add(at)
            directory, following = _directory(data, at, order, big)
            found.append(directory)
            waiting += [*directory.tags.get(_NEXT_INSIDE, ()), following]
    except EOFError:
        if not found:
            raise PhotographError(cut_short(path)) from None
    return found


def _directory(data: Bytes, at: int, order: Literal["little", "big"], big: bool) -> tuple[Directory, int]:
    width, entry = (8, 20) if big else (4, 12)
    count = number(data, at, 8 if big else 2, order)
    at += 8 if big else 2
    tags: dict[int, Sequence[int]] = {}
    for start in range(at, at + min(count, 4096) * entry, entry):
        tag, kind = number(data, start, 2, order), number(data, start + 2, 2, order)
        values, size = number(data, start + 4, width, order), _SIZES.get(kind)
        if size is None or values > _MOST_VALUES:
            continue
        place = start + 4 + width
        if values * size > width:
            place = number(data, place, width, order)
        tags[tag] = [number(data, place + i * size, size, order) for i in range(values)]
    return Directory(tags), number(data, at + count * entry, width, order)


def check_tiff(path: Path) -> list[Directory]:
    """The directories of a file whose largest picture has a sound size and is all there.

    Only the largest is judged: cameras write wrong lengths for thumbnails.

    Raises
    ------
    PhotographError
        If not.
    """
    found = directories(path)
    if not found:
        raise PhotographError(broken(path))
    largest = max(found, key=lambda directory: directory.size_px[0] * directory.size_px[1])
    check_size(path, *largest.size_px)
    if largest.end > path.stat().st_size:
        raise PhotographError(cut_short(path))
    return found


def exif_of_tiff(path: Path) -> Mapping[int, Any]:
    """EXIF tags of a file built as TIFF, empty where it has none."""
    from PIL import Image

    with warnings.catch_warnings(), path.open("rb") as file:
        warnings.simplefilter("ignore")  # of odd tags, which are as good as absent
        if file.read(4) not in (b"II*\0", b"MM\0*"):
            return {}
        file.seek(0)
        exif = Image.Exif()
        try:
            exif.load_from_fp(file)
            return {**exif, **exif.get_ifd(EXIF_IFD)}
        except TAGS_UNREADABLE:
            # Pillow gives up on directories it does not know. Exposure and lens are then as good as absent.
            return {}

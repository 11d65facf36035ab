"""Cryptomatte, as Cycles writes it into OpenEXR: how much of each pixel shows which object, with partly covered pixels.

By Friedman & Jones (2015), "Fully automatic ID mattes with support for motion blur and transparency", SIGGRAPH posters,
doi:10.1145/2787626.2787629: channels hold pairs of an object's number (its name's hash, kept in the bits of a float) and its
share of the pixel. The table of names in the header is not read: Blender writes none for an empty view layer, and names with
quotation marks so that they cannot be read.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ..errors import FileFormatError
from ..model import FloatArray

OBJECT_LEVEL = "CryptoObject"
"""How the names of Cycles' cryptomatte passes of objects begin; two digits follow."""

_WORD = 0xFFFFFFFF
_PAIRS = (("r", "g"), ("b", "a"))


def object_shares(
    channels: Mapping[str, Any], names: Iterable[str], prefix: str = ""
) -> dict[str, FloatArray]:
    """Shares (H, W) float32 of objects by name.

    Parameters
    ----------
    channels
        (H, W) channels by name, as `image_exr.read_channels` reads them.
    names
        The objects' names.
    prefix
        What the channels' names begin with before `OBJECT_LEVEL`, such as "0." for the first view layer.

    Raises
    ------
    FileFormatError
        If there is no cryptomatte among the channels.
    """
    start = f"{prefix}{OBJECT_LEVEL}"
    levels = sorted({name.rpartition(".")[0] for name in channels if name.startswith(start)})
    if not levels:
        raise FileFormatError("The render does not say which pixels show which object. Render it again.")
    wanted = list(dict.fromkeys(names))
    found = shares(channels, levels, np.array([number_of(name) for name in wanted], np.uint32))
    return dict(zip(wanted, found, strict=True))


def number_of(name: str) -> int:
    """Number of an object by its name: MurmurHash3 (32 bits) of it, with an exponent that a plain float may have.

    Examples
    --------
    As Blender's own table says:

    >>> f"{number_of('Ground'):08x} {number_of('Cube'):08x} {number_of('Ball ü'):08x}"
    '24950135 a8fce865 b9c93da0'
    """
    text = name.encode("utf-8")
    whole = len(text) & ~3
    state = 0
    for start in range(0, whole, 4):
        state ^= _mixed(int.from_bytes(text[start : start + 4], "little"))
        state = (_turned(state, 13) * 5 + 0xE6546B64) & _WORD
    if whole < len(text):
        state ^= _mixed(int.from_bytes(text[whole:], "little"))
    state ^= len(text)
    for shift, factor in ((16, 0x85EBCA6B), (13, 0xC2B2AE35), (16, 1)):
        state = ((state ^ state >> shift) * factor) & _WORD
    return state ^ 1 << 23 if state >> 23 & 0xFF in {0, 0xFF} else state


def _mixed(block: int) -> int:
    return _turned(block * 0xCC9E2D51 & _WORD, 15) * 0x1B873593 & _WORD


def _turned(word: int, bits: int) -> int:
    return (word << bits | word >> 32 - bits) & _WORD


def shares(channels: Mapping[str, Any], levels: Sequence[str], numbers: FloatArray) -> FloatArray:
    """Shares (N, H, W) of objects by their numbers (N,) uint32, from the channels of some levels.

    Examples
    --------
    >>> number = np.uint32(0x3F800000)
    >>> level = {"m.r": number.view(np.float32), "m.g": 0.75, "m.b": 2.0, "m.a": 0.25}
    >>> level = {name: np.full((1, 1), value, np.float32) for name, value in level.items()}
    >>> shares(level, ["m"], np.array([number, 7], np.uint32)).ravel().tolist()
    [0.75, 0.0]
    """
    order = np.argsort(numbers)
    ordered = numbers[order]
    height, width = next(plane for name, plane in channels.items() if _of(name, levels[0])).shape
    total = np.zeros((len(numbers), height, width), np.float32)
    for level in levels if len(numbers) else ():
        letters = {name.rpartition(".")[2].lower(): channels[name] for name in channels if _of(name, level)}
        for number_letter, share_letter in _PAIRS:
            if number_letter not in letters or share_letter not in letters:
                raise FileFormatError(
                    "The render does not say which pixels show which object: its cryptomatte is damaged. Render it again."
                )
            held = np.ascontiguousarray(letters[number_letter], np.float32).view(np.uint32)
            share = np.asarray(letters[share_letter], np.float32)
            place = np.minimum(np.searchsorted(ordered, held), len(ordered) - 1)
            known = ordered[place] == held
            rows, columns = np.nonzero(known)
            # A number stands at most once at a pixel of one pair, so plain indexing adds each share once.
            total[order[place[known]], rows, columns] += share[known]
    return total


def _of(name: str, level: str) -> bool:
    return name.rpartition(".")[0] == level

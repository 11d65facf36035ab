"""Cryptomatte, as Cycles writes it into OpenEXR: how much of each pixel shows which object, with partly covered pixels.

Layout by Friedman & Jones (2015), "Fully automatic ID mattes with support for motion blur and transparency", SIGGRAPH
posters, doi:10.1145/2787626.2787629: channels hold pairs of an object's number (its name's hash, kept in the bits of a
float) and its share of the pixel; the header says which name has which number.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FileFormatError
from ..model import FloatArray
from .image_exr import read_channels

OBJECT_LEVEL = "CryptoObject"
"""How the names of Cycles' cryptomatte passes of objects begin; two digits follow."""

_MANIFEST = "manifest"
_PAIRS = (("r", "g"), ("b", "a"))


def read_cryptomatte(path: Path, prefix: str = "") -> dict[str, FloatArray]:
    """Shares (H, W) float32 of all objects by name, of a multilayer OpenEXR.

    Parameters
    ----------
    path
        The file.
    prefix
        What the channels' names begin with before `OBJECT_LEVEL`, such as "0." for the first view layer.

    Returns
    -------
    dict
        Planes of the objects that the file names, zero where one is not seen.

    Raises
    ------
    FileFormatError
        If the file is missing, or holds no cryptomatte.
    """
    channels, header = read_channels(path)
    numbers = _numbers(header)
    start = f"{prefix}{OBJECT_LEVEL}"
    levels = sorted({name.rpartition(".")[0] for name in channels if name.startswith(start)})
    if not levels or not numbers:
        raise FileFormatError(
            f"{Path(path).name} does not say which pixels show which object. Render it again."
        )
    found = shares(channels, levels, np.array(list(numbers.values()), np.uint32))
    return dict(zip(numbers, found, strict=True))


def shares(channels: Mapping[str, Any], levels: list[str], numbers: FloatArray) -> FloatArray:
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
    total: FloatArray | None = None
    for level in levels:
        letters = {name.rpartition(".")[2].lower(): channels[name] for name in channels if _of(name, level)}
        for number_letter, share_letter in _PAIRS:
            held = np.ascontiguousarray(letters[number_letter], np.float32).view(np.uint32)
            share = np.asarray(letters[share_letter], np.float32)
            if total is None:
                total = np.zeros((len(numbers), *held.shape), np.float32)
            place = np.minimum(np.searchsorted(ordered, held), len(ordered) - 1)
            known = ordered[place] == held
            rows, columns = np.nonzero(known)
            # A number stands at most once at a pixel of one pair, so plain indexing adds each share once.
            total[order[place[known]], rows, columns] += share[known]
    return np.zeros((len(numbers), 0, 0), np.float32) if total is None else total


def _of(name: str, level: str) -> bool:
    return name.rpartition(".")[0] == level


def _numbers(header: Mapping[str, Any]) -> dict[str, int]:
    """Numbers of all objects by name, of every manifest in a header."""
    numbers: dict[str, int] = {}
    for key, text in header.items():
        if key.startswith("cryptomatte/") and key.endswith(_MANIFEST):
            numbers |= {str(name): int(number, 16) for name, number in json.loads(text).items()}
    return numbers

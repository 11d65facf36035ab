"""What names a part of an animation's work: a frame's folder, and a share of its list of steps."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Share:
    """One of `of` equal shares of a list, the `number`-th of them counted from 1."""

    number: int
    of: int


def frame_folder(directory: Path, frame: int) -> Path:
    """The folder of a frame in that of its animation.

    Examples
    --------
    >>> frame_folder(Path("render"), 7).name
    'frame_0007'
    """
    return directory / f"frame_{frame:04d}"

"""Arrays too large to stay in memory: they lie in a file without a name, and only the rows in use are resident.

A panorama of 16384 x 8192 texels with twelve weights each is 6.4 GB. Whoever goes through it strip by strip lets each strip go
after use (`let_go`): its pages leave the process, and come back from the file when they are looked at again.
"""

from __future__ import annotations

import mmap
import os
import tempfile
from typing import Any

import numpy as np
import numpy.typing as npt

LARGEST_IN_MEMORY_BYTES = 1 << 31
"""Arrays larger than this lie in a file."""

TEXELS_A_STRIP = 1 << 23
"""A panorama of 4096 x 2048 is one strip. Larger ones have strips of a quarter: some steps take 400 bytes a texel."""


def large_array(shape: tuple[int, ...], kind: npt.DTypeLike = np.float32) -> npt.NDArray[Any]:
    """An array of zeros, in memory or, if it is larger than `LARGEST_IN_MEMORY_BYTES`, in an unnamed file.

    The file lies in the system's folder for temporary files (`TMPDIR`) and is gone with the process, however that ends. Its
    place on the disk is taken now; where there is not enough, the array is made in memory.

    Examples
    --------
    >>> float(large_array((2, 4)).sum())
    0.0
    """
    size = int(np.prod(shape, dtype=np.int64)) * np.dtype(kind).itemsize
    if size <= LARGEST_IN_MEMORY_BYTES or not hasattr(os, "posix_fallocate"):
        return np.zeros(shape, kind)
    try:
        with tempfile.TemporaryFile() as file:
            os.posix_fallocate(file.fileno(), 0, size)  # a full disk is told now, and not by a signal later
            mapped = mmap.mmap(file.fileno(), size)
    except OSError:
        return np.zeros(shape, kind)
    return np.frombuffer(mapped, kind).reshape(shape)


def let_go(array: npt.NDArray[Any]) -> None:
    """Let the pages of a `large_array` leave this process's memory; what they hold stays. Nothing for other arrays.

    Examples
    --------
    >>> array = np.ones(3)
    >>> let_go(array)
    >>> float(array.sum())
    3.0
    """
    base: Any = array
    while isinstance(base, np.ndarray | memoryview):
        base = base.base if isinstance(base, np.ndarray) else base.obj
    if isinstance(base, mmap.mmap) and hasattr(base, "madvise"):
        base.madvise(mmap.MADV_DONTNEED)


def strips(height: int, width: int, multiple: int = 8) -> list[slice]:
    """The rows of an image: one part up to `TEXELS_A_STRIP`, else of a quarter of it, a multiple of so many rows but the last.

    Examples
    --------
    >>> strips(2048, 4096), len(strips(8192, 16384))
    ([slice(0, 2048, None)], 64)
    """
    if height * width <= TEXELS_A_STRIP:
        return [slice(0, height)]
    step = max(multiple, TEXELS_A_STRIP // 4 // width // multiple * multiple)
    return [slice(start, min(start + step, height)) for start in range(0, height, step)]


def with_margin(rows: slice, margin: int, height: int) -> tuple[slice, slice]:
    """Rows with up to so many more on both sides, and where in those the rows themselves are.

    Examples
    --------
    >>> with_margin(slice(2, 6), 4, 8)
    (slice(0, 8, None), slice(2, 6, None))
    """
    wide = slice(max(rows.start - margin, 0), min(rows.stop + margin, height))
    return wide, slice(rows.start - wide.start, rows.stop - wide.start)

"""Work in parallel on all processors: numpy and OpenCV let other threads run while they compute."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

_TEXELS_AT_A_TIME = 1 << 17


def processors() -> int:
    """How many processors this process may use, at least one."""
    return os.process_cpu_count() or 1


def in_parallel[Part, Result](work: Callable[[Part], Result], parts: Sequence[Part]) -> list[Result]:
    """Results of `work` for each part, in their order.

    Examples
    --------
    >>> in_parallel(lambda number: number**2, range(4))
    [0, 1, 4, 9]
    """
    import cv2

    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)  # its own would only get in the way of these
    try:
        with ThreadPoolExecutor(processors()) as pool:
            return list(pool.map(work, parts))
    finally:
        cv2.setNumThreads(threads)


def row_blocks(width: int) -> list[slice]:
    """The rows of a panorama in parts that fit a processor's cache.

    Examples
    --------
    >>> row_blocks(1024)
    [slice(0, 128, None), slice(128, 256, None), slice(256, 384, None), slice(384, 512, None)]
    """
    step = max(4, _TEXELS_AT_A_TIME // width // 4 * 4)
    return [slice(start, min(start + step, width // 2)) for start in range(0, width // 2, step)]

"""Work in parallel on all processors: numpy and OpenCV let other threads run while they compute."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np

from .model import FloatArray

_TEXELS_AT_A_TIME = 1 << 17

_ONE_THREAD_PRODUCT = 1 << 18
"""Multiplications up to which OpenBLAS computes a matrix product in the thread that asks for it (its interface/gemm.c)."""


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


def in_order[Part, Result](work: Callable[[Part], Result], parts: Sequence[Part]) -> Iterator[Result]:
    """Results of `work` in the order of the parts, made on all processors, few of them at a time in memory.

    Examples
    --------
    >>> list(in_order(lambda number: number**2, range(5)))
    [0, 1, 4, 9, 16]
    """
    if len(parts) == 1:
        yield work(parts[0])
        return
    waiting: deque[Future[Result]] = deque()
    with ThreadPoolExecutor(processors()) as pool:
        try:
            for part in parts:
                waiting.append(pool.submit(work, part))
                if len(waiting) > processors():
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        finally:
            for left in waiting:
                left.cancel()


def row_blocks(width: int, height: int | None = None) -> list[slice]:
    """The rows of a panorama, or of an image of a height, in parts that fit a processor's cache.

    Examples
    --------
    >>> row_blocks(1024)
    [slice(0, 128, None), slice(128, 256, None), slice(256, 384, None), slice(384, 512, None)]
    """
    rows = width // 2 if height is None else height
    step = max(4, _TEXELS_AT_A_TIME // width // 4 * 4)
    return [slice(start, min(start + step, rows)) for start in range(0, rows, step)]


def product(matrix: FloatArray, columns: FloatArray) -> FloatArray:
    """Matrix (M, K) times columns (K, P), computed in this thread alone.

    Threads of the library of matrix products would get in the way of those of `in_parallel`, many times over. It starts none
    for products as small as these.

    The matrix is never handed on transposed. Where both factors are, and of single precision, OpenBLAS 0.3.34 on processors with
    AVX-512 keeps where the result goes in memory that all threads share (`index_n` of sgemm_small_kernel_tt_skylakex.c): two
    threads at once may write into each other's result, or anywhere.

    Examples
    --------
    >>> matrix, columns = np.arange(6.0).reshape(2, 3), np.ones((3, 100_000))
    >>> bool((product(matrix, columns) == matrix @ columns).all())
    True
    """
    matrix = np.ascontiguousarray(matrix)
    result = np.empty((len(matrix), columns.shape[1]), np.result_type(matrix, columns))
    step = max(1, _ONE_THREAD_PRODUCT // matrix.size)
    for start in range(0, columns.shape[1], step):
        few = slice(start, start + step)
        np.matmul(matrix, columns[:, few], out=result[:, few])
    return result


def summed_product(first: FloatArray, second: FloatArray) -> FloatArray:
    """Matrix (M, P) times the transpose of another (K, P), computed in this thread alone.

    Examples
    --------
    >>> first, second = np.ones((2, 100_000)), np.ones((3, 100_000))
    >>> bool((summed_product(first, second) == 100_000).all())
    True
    """
    result = np.zeros((len(first), len(second)), np.result_type(first, second))
    step = max(1, _ONE_THREAD_PRODUCT // result.size)
    for start in range(0, first.shape[1], step):
        few = slice(start, start + step)
        result += first[:, few] @ second[:, few].T
    return result

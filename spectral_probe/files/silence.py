"""Libraries written in C that have something to say on the terminal, kept quiet while they read a damaged file.

OpenEXR, libtiff and libpng write lines of their own to standard error (file descriptor 2), past Python and whatever is told
them. What there is to say is said by the error of whoever reads.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_STANDARD_ERROR = 2


class _Silence:
    """Standard error of the process, which readers in several threads share: the last that ends lets it speak again."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._readers = 0
        self._kept: int | None = None

    def begin(self) -> None:
        with self._lock:
            self._readers += 1
            if self._readers > 1:
                return
            if sys.stderr is not None:
                sys.stderr.flush()
            try:
                self._kept = os.dup(_STANDARD_ERROR)
            except OSError:  # a program with a window has none on some systems
                return
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, _STANDARD_ERROR)
            os.close(nowhere)

    def end(self) -> None:
        with self._lock:
            self._readers -= 1
            if self._readers or self._kept is None:
                return
            os.dup2(self._kept, _STANDARD_ERROR)
            os.close(self._kept)
            self._kept = None


_SILENCE = _Silence()


@contextmanager
def libraries_silenced() -> Iterator[None]:
    """Nothing that is written to standard error within the block is seen. Keep the block short: it is for one library's call.

    Examples
    --------
    >>> with libraries_silenced():
    ...     _ = os.write(2, b"what a library has to say")
    """
    _SILENCE.begin()
    try:
        yield
    finally:
        _SILENCE.end()

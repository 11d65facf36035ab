"""Libraries written in C that have something to say on the terminal, kept quiet while they read a damaged file.

OpenEXR, libtiff and libpng write lines of their own to standard error (file descriptor 2), past Python and whatever is told
them; OpenEXR's module prints, too. What there is to say is said by the error of whoever reads.
"""

from __future__ import annotations

import io
import os
import sys
import threading
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from typing import TextIO

_STANDARD_ERROR = 2


class _Elsewhere(io.TextIOBase):
    """Standard output for all threads but some, whose words are dropped."""

    def __init__(self, stream: TextIO, silent: Collection[int]) -> None:
        super().__init__()
        self._stream = stream
        self._silent = silent

    def write(self, text: str) -> int:
        return len(text) if threading.get_ident() in self._silent else self._stream.write(text)

    def flush(self) -> None:
        self._stream.flush()


class _Silence:
    """Standard error and output of the process, shared by readers in several threads: the last that ends lets it speak again."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._readers: list[int] = []  # their threads
        self._out: TextIO | None = None
        self._kept: int | None = None

    def begin(self) -> None:
        with self._lock:
            self._readers.append(threading.get_ident())
            if len(self._readers) > 1:
                return
            self._out = sys.stdout
            if self._out is not None:
                sys.stdout = _Elsewhere(self._out, self._readers)
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
            self._readers.remove(threading.get_ident())
            if self._readers:
                return
            if isinstance(sys.stdout, _Elsewhere) and self._out is not None:
                sys.stdout = self._out
            if self._kept is None:
                return
            os.dup2(self._kept, _STANDARD_ERROR)
            os.close(self._kept)
            self._kept = None


_SILENCE = _Silence()


@contextmanager
def libraries_silenced() -> Iterator[None]:
    """Nothing that is written to standard error within the block is seen, nor what its thread prints.

    Keep the block short: it is for one library's call.

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

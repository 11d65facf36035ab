"""Blender's own messages kept off the terminal while a verb of the command line works.

Blender's C++ side writes to file descriptor 1, which Python's `sys.stdout` knows nothing of; so the
descriptor itself is pointed elsewhere. Progress goes to standard error and is not touched.
"""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

_STANDARD_OUTPUT = 1


@contextmanager
def blender_silenced() -> Iterator[None]:
    """Nothing reaches standard output until the block ends."""
    _flush()
    kept = os.dup(_STANDARD_OUTPUT)
    try:
        with open(os.devnull, "wb") as nowhere:  # noqa: PTH123  (the null device is no path)
            os.dup2(nowhere.fileno(), _STANDARD_OUTPUT)
        yield
    finally:
        _flush()
        os.dup2(kept, _STANDARD_OUTPUT)
        os.close(kept)


def _flush() -> None:
    """Empty Python's and the C library's buffers into wherever the descriptor points now."""
    sys.stdout.flush()
    library = ctypes.CDLL("ucrtbase" if sys.platform == "win32" else None)
    library.fflush(None)

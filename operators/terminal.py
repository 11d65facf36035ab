"""Blender's own messages kept off the terminal while a verb of the command line works.

Blender writes some through Python's `sys.stdout` and some, from C++, straight to file descriptor 1; so both are
pointed elsewhere. Progress goes to standard error and is not touched.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path

_STANDARD_OUTPUT = 1


@contextmanager
def blender_silenced() -> Iterator[None]:
    """Nothing reaches standard output until the block ends."""
    _flush()
    kept = os.dup(_STANDARD_OUTPUT)
    try:
        with Path(os.devnull).open("w", encoding="utf-8") as nowhere, redirect_stdout(nowhere):
            os.dup2(nowhere.fileno(), _STANDARD_OUTPUT)
            yield
    finally:
        _flush()
        os.dup2(kept, _STANDARD_OUTPUT)
        os.close(kept)


def _flush() -> None:
    """Empty Python's and the C library's buffers into wherever the descriptor points now."""
    import ctypes

    sys.stdout.flush()
    library = ctypes.CDLL("ucrtbase" if sys.platform == "win32" else None)
    library.fflush(None)

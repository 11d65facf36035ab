"""Files written whole or not at all, into folders that can be written to."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from ..errors import FileFormatError

UNFINISHED = ".writing-"
"""How the names of temporary folders begin; one that is left over is that of a process that was killed."""


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """A temporary path beside `path` that takes its place when the block ends well, and vanishes when it does not.

    The temporary file keeps the suffix, so that libraries that choose a format by it still can. The folder is
    made if it is missing.

    Raises
    ------
    FileFormatError
        If it cannot be written there.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> with written_whole(folder / "a.txt") as temporary:
    ...     _ = temporary.write_text("all of it")
    >>> (folder / "a.txt").read_text(), len(list(folder.iterdir()))
    ('all of it', 1)
    """
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(prefix=UNFINISHED, dir=path.parent) as folder:
            temporary = Path(folder) / path.name
            yield temporary
            temporary.replace(path)
    except OSError as problem:
        raise FileFormatError(
            f"{path} cannot be written ({problem.strerror or problem}). Choose another place, or make room."
        ) from None


def check_folder(directory: Path) -> None:
    """Refuse, before any work and without making anything, a folder that cannot be written to.

    Raises
    ------
    FileFormatError
        If the path, or what it lies in, is a file or may not be written to.
    """
    try:
        nearest = next(path for path in (directory, *directory.resolve().parents) if path.exists())
    except OSError as problem:
        raise FileFormatError(
            f"The folder {directory} cannot be written to ({problem.strerror}). Choose another."
        ) from None
    if not nearest.is_dir():
        raise FileFormatError(f"{nearest} is a file, not a folder. Choose another folder to write to.")
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise FileFormatError(f"The folder {nearest} may not be written to. Choose another.")


def make_folder(directory: Path) -> None:
    """Make a folder and those it lies in, where they are missing.

    Raises
    ------
    FileFormatError
        If it cannot be made.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp()) / "a" / "b"
    >>> make_folder(folder)
    >>> folder.is_dir()
    True
    """
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise FileFormatError(
            f"The folder {directory} cannot be made ({problem.strerror}). Choose another."
        ) from None

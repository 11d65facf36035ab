"""Files written whole or not at all, into folders that can be written to."""

from __future__ import annotations

import errno
import json
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from ..errors import FileFormatError
from .staging import (
    LOCK_NAME,
    MARK_NAME,
    UNFINISHED,
    destined,
    move_out,
    remove_leftovers,
    staging_folder,
    sync_file,
    sync_folder,
)

__all__ = [
    "UNFINISHED", "check_folder", "destined", "folder_written_whole", "make_folder", "remove_leftovers", "staging_folder",
    "written_together", "written_whole",
]  # fmt: skip

_FULL = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """A temporary path that takes the place of `path` when the block ends well, and vanishes when it does not.

    The temporary file keeps its name, so that libraries that choose a format by the suffix still can. Its content is on the disk
    before it takes its place. The folder is made if it is missing, and rid of what killed processes left there. Within a staging
    folder, which is moved as a whole, the file is written in place.

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
        if any(parent.name.startswith(UNFINISHED) for parent in path.parents):
            yield path
            return
        with staging_folder(path.parent) as folder:
            temporary = folder / path.name
            yield temporary
            sync_file(temporary)
            temporary.replace(path)
            sync_folder(path.parent)
    except OSError as problem:
        raise not_written(path, problem) from None


@contextmanager
def written_together(directory: Path, *, last: str, stale: Sequence[str] = ()) -> Iterator[Path]:
    """A staging folder whose files take their places in `directory` together when the block ends well, else none of them.

    No file system moves several files at once. All are on the disk before the first is moved; a process killed between two
    moves leaves the rest and the folder without `last`, and the next run that writes there moves the rest first.

    Parameters
    ----------
    directory
        Where to; it is made if it is missing. Hold its lock (`lock.folder_lock`).
    last
        The file that says that the others are there, such as report.json: that of an earlier run is removed first, the new one
        comes last.
    stale
        Names of files of an earlier run that are removed where this one has none.

    Raises
    ------
    FileFormatError
        If they cannot be written there.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> with written_together(folder, last="b.txt") as staging:
    ...     for name in ("a.txt", "b.txt"):
    ...         _ = (staging / name).write_text(name)
    >>> sorted(path.name for path in folder.iterdir())
    ['a.txt', 'b.txt']
    """
    directory = Path(directory)
    try:
        directory.mkdir(parents=True, exist_ok=True)
        with staging_folder(directory) as folder:
            yield folder
            files = [path for path in folder.rglob("*") if path.name != LOCK_NAME]
            _check_targets(files, folder, directory)
            for path in files:
                (sync_folder if path.is_dir() else sync_file)(path)
            mark = json.dumps(
                {"last": last, "stale": [name for name in stale if not (folder / name).exists()]}
            )
            unmarked = folder / f"{MARK_NAME}-"
            unmarked.write_text(mark, encoding="utf-8")
            sync_file(unmarked)
            unmarked.replace(folder / MARK_NAME)
            try:
                sync_folder(folder)
            except OSError:  # then nothing of this is to count
                (folder / MARK_NAME).unlink()
                raise
            move_out(folder, directory)
    except OSError as problem:
        raise not_written(directory, problem) from None


@contextmanager
def folder_written_whole(directory: Path) -> Iterator[Path]:
    """A temporary folder that becomes `directory`, a new one, when the block ends well, and vanishes when it does not.

    Where another process has made the folder meanwhile, that one stays: for folders named after their content.

    Raises
    ------
    FileFormatError
        If it cannot be written there.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp()) / "new"
    >>> with folder_written_whole(folder) as temporary:
    ...     _ = (temporary / "a.txt").write_text("all of it")
    >>> [path.name for path in folder.iterdir()]
    ['a.txt']
    """
    directory = Path(directory)
    try:
        directory.parent.mkdir(parents=True, exist_ok=True)
        with staging_folder(directory.parent) as folder:
            temporary = folder / directory.name
            temporary.mkdir()
            yield temporary
            for path in (*temporary.rglob("*"), temporary):
                (sync_folder if path.is_dir() else sync_file)(path)
            if not directory.is_dir():
                with suppress(FileExistsError):
                    temporary.rename(directory)
            sync_folder(directory.parent)
    except OSError as problem:
        raise not_written(directory, problem) from None


def not_written(path: Path, problem: OSError) -> FileFormatError:
    """What to tell of an output that cannot be written."""
    why, path = problem.strerror or problem, destined(path)
    if problem.errno in _FULL:
        return FileFormatError(f"{path} cannot be written ({why}). Make room, or choose another place.")
    if problem.errno == errno.ENAMETOOLONG:
        return FileFormatError(f"{path} cannot be written ({why}). Choose a shorter name.")
    return FileFormatError(f"{path} cannot be written ({why}). Choose another place, or make room.")


def _check_targets(files: Sequence[Path], folder: Path, directory: Path) -> None:
    """Refuse, before the first is moved, files whose places folders have."""
    for path in files:
        target = directory / path.relative_to(folder)
        if target.is_dir() and not path.is_dir():
            raise IsADirectoryError(errno.EISDIR, f"{target.name} there is a folder")


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

"""Folders in which outputs are written before they take their places, and what killed processes left of them.

A staging folder lies beside the outputs, so that a rename is all it takes. Its name says which machine made it, and a lock on a
file in it is held as long as its process lives: whoever comes later can tell a leftover from work that goes on. Locks are the
operating system's (`filelock`): they end with the process, however it ends.
"""

from __future__ import annotations

import errno
import json
import os
import platform
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from hashlib import blake2b
from pathlib import Path
from tempfile import mkdtemp
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from filelock import BaseFileLock

UNFINISHED = ".writing-"
"""How the names of staging folders begin; one that is left over is that of a process that was killed."""

LOCK_NAME = ".lock"
"""The file in a staging folder that its process holds locked."""

MARK_NAME = ".whole"
"""Its presence in a staging folder says that all outputs are in it, whole, and are taking their places."""

NO_LOCKS = frozenset({errno.ENOSYS, errno.ENOLCK, errno.ENOTSUP, errno.EOPNOTSUPP, errno.EINVAL})
"""What a file system answers that knows no locks, such as some network shares."""

_ABANDONED_S = 24 * 3600.0
_ATTEMPTS = 5


@contextmanager
def staging_folder(directory: Path) -> Iterator[Path]:
    """An empty folder within `directory`, to write to; it is gone after the block, whatever happened.

    Where the block left the mark that all is whole and then failed to move it (`atomic.written_together`), the folder stays for
    the next run, which moves the rest.

    Examples
    --------
    >>> import tempfile
    >>> with staging_folder(Path(tempfile.mkdtemp())) as folder:
    ...     folder.name.startswith(UNFINISHED)
    True
    >>> folder.exists()
    False
    """
    remove_leftovers(directory)
    folder, lock = _new_folder(directory)
    try:
        yield folder
    finally:
        _remove(folder, lock, keep=(folder / MARK_NAME).is_file())


def remove_leftovers(directory: Path) -> None:
    """Remove what killed processes were writing in a folder; what they had written whole takes its place.

    A folder of a process that lives is left alone: its lock is held. On some network shares the locks of other machines are not
    seen; what another machine left is therefore removed only after a day without a change.
    """
    try:
        with os.scandir(directory) as entries:
            left = [
                Path(entry.path)
                for entry in entries
                if entry.name.startswith(UNFINISHED) and entry.is_dir(follow_symlinks=False)
            ]
    except OSError:  # whoever writes next says why
        return
    for folder in left:
        own = folder.name.removeprefix(UNFINISHED).split("-")[:2]
        here = any(mine == its for mine, its in zip(_machine(), own, strict=False))
        if not here and not _abandoned(folder):
            continue
        try:
            lock = _locked(folder)
        except (
            OSError,
            NotImplementedError,
        ):  # gone meanwhile, or no locks here: nobody can tell whether its owner lives
            continue
        if lock is None:
            continue
        mark = folder / MARK_NAME
        if here and mark.is_file():
            with suppress(OSError):  # then the next run tries again
                move_out(folder, directory)
        _remove(folder, lock, keep=here and mark.is_file())


def move_out(folder: Path, directory: Path) -> None:
    """Let all that a staging folder with the mark holds take its place; may be done again from wherever it was cut short.

    The output that says that the others are there goes first and comes last: what lies between two versions lacks it.
    """
    try:
        mark = json.loads((folder / MARK_NAME).read_text(encoding="utf-8"))
        last, stale = Path(mark["last"]).name, [Path(name).name for name in mark["stale"]]
    except (
        ValueError,
        KeyError,
        TypeError,
        RecursionError,
    ):  # cut short with the machine: written before all else took its place
        (folder / MARK_NAME).unlink()
        return
    if (folder / last).exists():
        (directory / last).unlink(missing_ok=True)
    for name in stale:
        (directory / name).unlink(missing_ok=True)
    files = [file for file in folder.iterdir() if file.name not in (LOCK_NAME, MARK_NAME)]
    for file in sorted(files, key=lambda file: file.name == last):
        file.replace(directory / file.name)
    sync_folder(directory)
    (folder / MARK_NAME).unlink()


def sync_file(path: Path) -> None:
    """Wait until a file's content is on the disk, so that a rename never comes to lie there before it."""
    file = os.open(path, os.O_RDWR if os.name == "nt" else os.O_RDONLY)
    try:
        os.fsync(file)
    finally:
        os.close(file)


def sync_folder(path: Path) -> None:
    """Wait until a folder's names are on the disk, where the platform can."""
    if os.name == "nt":
        return
    folder = os.open(path, os.O_RDONLY)
    try:
        os.fsync(folder)
    except OSError as problem:
        if problem.errno not in NO_LOCKS:  # some file systems do not sync folders
            raise
    finally:
        os.close(folder)


def destined(path: Path) -> Path:
    """Where a file in a staging folder is to go, which is what a person should be told; other paths are themselves.

    Examples
    --------
    >>> destined(Path("out", f"{UNFINISHED}ab-cd-ef", "probe.exr")).as_posix()
    'out/probe.exr'
    """
    return Path(*(part for part in path.parts if not part.startswith(UNFINISHED)))


def _machine() -> tuple[str, str]:
    """Short names of this machine and of its running system: either alone says that a process is one of ours.

    Containers of one machine have names of their own, and share the system; a restarted machine keeps its name.
    """
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii")
    except OSError:
        boot = platform.node()
    return _short(platform.node()), _short(boot)


def _short(text: str) -> str:
    return blake2b(text.encode(), digest_size=4).hexdigest()


def _abandoned(folder: Path) -> bool:
    """Whether nothing in a folder has changed for a day."""
    try:
        changed = max(path.stat().st_mtime for path in (folder, *folder.rglob("*")))
    except OSError:
        return False
    return time.time() - changed > _ABANDONED_S


def _new_folder(directory: Path) -> tuple[Path, BaseFileLock | None]:
    """A folder whose lock is ours; without one where the file system has no locks."""
    for _ in range(_ATTEMPTS):
        folder = Path(mkdtemp(prefix=f"{UNFINISHED}{'-'.join(_machine())}-", dir=directory))
        try:
            lock = _locked(folder)
        except FileNotFoundError:  # taken for a leftover before it was locked
            continue
        except (OSError, NotImplementedError) as problem:
            if not isinstance(problem, NotImplementedError) and problem.errno not in NO_LOCKS:
                shutil.rmtree(folder, ignore_errors=True)
                raise
            return folder, None
        if lock is not None:
            return folder, lock
    raise FileNotFoundError(errno.ENOENT, "its temporary folder vanishes", str(directory))


def _locked(folder: Path) -> BaseFileLock | None:
    """The lock of a staging folder; None where its process lives."""
    from filelock import FileLock, Timeout

    lock = FileLock(folder / LOCK_NAME, timeout=0, thread_local=False, fallback_to_soft=False)
    try:
        lock.acquire()
    except Timeout:
        return None
    return lock


def _remove(folder: Path, lock: BaseFileLock | None, *, keep: bool) -> None:
    """Remove a staging folder whose lock is ours: the lock's file last, which some systems do not let go while it is open."""
    try:
        entries = [] if keep else list(folder.iterdir())
    except OSError:
        entries = []
    for path in entries:
        if path.name == LOCK_NAME:
            continue
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path, ignore_errors=True)
        else:
            with suppress(OSError):
                path.unlink()
    if lock is not None:
        with suppress(OSError):
            lock.release()
    if not keep:
        shutil.rmtree(folder, ignore_errors=True)

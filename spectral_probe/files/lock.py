"""One process at a time writes to a folder; a second one is told who does.

The lock is the operating system's, on a file in the folder (`filelock`): it ends with the process, however that ends, and needs
nobody to remove it. Beside it a small file says who holds it. Both have dot names and are gone when a job ends, well or badly;
of a killed one they stay until the next run there.
"""

from __future__ import annotations

import json
import logging
import os
import platform
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from datetime import datetime
from pathlib import Path

from ..errors import FileFormatError, FolderBusyError
from .atomic import check_folder
from .staging import NO_LOCKS, remove_leftovers

_LOG = logging.getLogger(__name__)

LOCK_NAME = "spectral_probe"
"""Of the lock of a whole folder: the files are .spectral_probe.lock and .spectral_probe.holder."""

_ATTEMPTS = 5


@contextmanager
def folder_lock(directory: Path, *, wait_s: float = 0.0, name: str = LOCK_NAME) -> Iterator[None]:
    """Nobody else writes to a folder during the block: no other process, and no other job of this one.

    The folder is made if it is missing, and removed again if nothing was written to it. What killed processes left in it is
    removed.

    Parameters
    ----------
    directory
        The folder.
    wait_s
        Seconds to wait for whoever holds it.
    name
        Which lock: one folder may have several, such as one for each step of a render.

    Raises
    ------
    FolderBusyError
        If someone else holds it.
    FileFormatError
        If the folder cannot be written to.

    Note
    ----
    On a share that knows no locks the block goes on without one, and a warning is logged.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp()) / "out"
    >>> with folder_lock(folder):
    ...     try:
    ...         with folder_lock(folder):
    ...             pass
    ...     except FileFormatError as told:
    ...         "another job of this process" in str(told)
    True
    >>> folder.exists()
    False
    """
    directory = Path(directory)
    check_folder(directory)
    place = directory.absolute()
    with ExitStack() as stack:
        _acquire(stack, directory, place, name, wait_s)
        remove_leftovers(place)
        yield


def _acquire(stack: ExitStack, directory: Path, place: Path, name: str, wait_s: float) -> None:
    """Make the folder and take its lock; the stack gives both back."""
    from filelock import FileLock, Timeout

    path, holder = place / f".{name}.lock", place / f".{name}.holder"
    lock = FileLock(path, timeout=wait_s, thread_local=False, fallback_to_soft=False)
    for attempt in range(_ATTEMPTS):
        try:
            _make(stack, place)
            lock.acquire(poll_interval=0.05)
        except Timeout:
            raise FolderBusyError(
                f"{directory} is being written by {_told(holder)}. Wait for it, or choose another folder."
            ) from None
        except FileNotFoundError as problem:  # whoever had made the folder removed it again
            if attempt + 1 == _ATTEMPTS:
                raise _refused(directory, problem) from None
        except NotImplementedError:
            _warn(directory)
            return
        except OSError as problem:
            if problem.errno not in NO_LOCKS:
                raise _refused(directory, problem) from None
            _warn(directory)
            return
        else:
            break
    stack.callback(lock.release)
    # Gone while the lock is held: whoever waits for it sees that the file has lost its name, and begins anew.
    stack.callback(_unlink, path)
    stack.callback(_unlink, holder)
    with suppress(OSError):  # the lock holds without it
        holder.write_text(json.dumps(_ourselves()), encoding="utf-8")


def _make(stack: ExitStack, place: Path) -> None:
    """Make a folder and those it lies in; those that are new and still empty go again with the stack."""
    missing = [folder for folder in (place, *place.parents) if not folder.exists()]
    place.mkdir(parents=True, exist_ok=True)
    for folder in reversed(missing):
        stack.callback(_remove_empty, folder)


def _unlink(path: Path) -> None:
    with suppress(
        OSError
    ):  # another process may have it open, which some systems mind; an empty lock file is no lock
        path.unlink()


def _remove_empty(folder: Path) -> None:
    with suppress(OSError):
        folder.rmdir()


def _ourselves() -> dict[str, object]:
    return {
        "host": platform.node(),
        "process": os.getpid(),
        "since": datetime.now().astimezone().isoformat(timespec="seconds"),
    }


def _told(holder: Path) -> str:
    """Who holds the lock, as far as it was noted."""
    try:
        noted = json.loads(holder.read_text(encoding="utf-8"))
        host, process, since = (
            str(noted["host"]),
            int(noted["process"]),
            datetime.fromisoformat(noted["since"]),
        )
    except (
        OSError,
        ValueError,
        KeyError,
        TypeError,
        OverflowError,
        RecursionError,
    ):  # not written yet, or damaged
        return "another process"
    if (host, process) == (platform.node(), os.getpid()):
        return "another job of this process"
    host = "".join(letter for letter in host[:64] if letter.isprintable())
    return f"another process ({host}, process {process}, since {since:%Y-%m-%d %H:%M:%S})"


def _refused(directory: Path, problem: OSError) -> FileFormatError:
    return FileFormatError(
        f"The folder {directory} cannot be written to ({problem.strerror or problem}). Choose another, or make room."
    )


def _warn(directory: Path) -> None:
    _LOG.warning(
        "%s lies on a share without file locks: see to it yourself that no other process writes there.",
        directory,
    )

"""Locks of a frame and of its steps, waited for while a window stays alive."""

import time
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path

from ...spectral_probe.errors import FolderBusyError
from ...spectral_probe.files.lock import LOCK_NAME, folder_lock
from ...spectral_probe.model import Job, Progress
from ...spectral_probe.work import worked

_LOOK_EVERY_S = 0.25


def waited_lock(
    stack: ExitStack, progress: Progress, directory: Path, *, name: str = LOCK_NAME, wait_s: float
) -> Job[None]:
    """Take a lock of a folder (`files.lock`), which the stack gives back; `progress` is what is told while others hold it.

    Raises
    ------
    FolderBusyError
        If others still hold it when the time is over.
    FileFormatError
        If the folder cannot be written to.
    """
    until = time.monotonic() + wait_s
    while True:
        try:
            stack.enter_context(folder_lock(directory, name=name))
            return
        except FolderBusyError:
            if time.monotonic() > until:
                raise
        waiting = replace(progress, message=f"{progress.message} (waiting for another process)")
        yield from worked(waiting, partial(time.sleep, _LOOK_EVERY_S))

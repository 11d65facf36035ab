"""What a person or a scheduler sees of a verb at work: a bar, lines, or what Open Job Description reads of a task's output."""

from __future__ import annotations

import argparse
import io
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import TextIO

from .model import Job, Progress

_BAR_WIDTH = 28
_LINE_EVERY_S = 10.0


class Terminated(KeyboardInterrupt):
    """The system asks this process to end, as a scheduler does that cancels a task."""


def with_progress[Result](job: Job[Result], scheduler: SchedulerLines | None = None) -> Result:
    """Drive a job, showing how far it is: to a scheduler, or on standard error, a bar on a terminal, else a line now and then."""
    terminal = sys.stderr.isatty() and scheduler is None
    told = time.monotonic()
    try:
        while True:
            try:
                progress = next(job)
            except StopIteration as stop:
                return stop.value  # type: ignore[no-any-return]  # StopIteration carries its value untyped
            if scheduler is not None:
                scheduler.tell(progress)
            elif terminal:
                sys.stderr.write(_bar(progress))
            elif time.monotonic() - told > _LINE_EVERY_S:
                told = time.monotonic()
                sys.stderr.write(f"{progress.fraction:4.0%} {progress.message}\n")
            sys.stderr.flush()
    finally:
        job.close()
        if terminal:
            sys.stderr.write("\r\x1b[K")


def _bar(progress: Progress) -> str:
    done = round(progress.fraction * _BAR_WIDTH)
    return f"\r\x1b[K[{'#' * done}{'.' * (_BAR_WIDTH - done)}] {progress.fraction:4.0%} {progress.message}"


def add_openjd_word(parser: argparse.ArgumentParser) -> None:
    """Add --openjd."""
    parser.add_argument(
        "--openjd",
        action="store_true",
        help="tell progress and failure in the lines that schedulers of Open Job Description read",
    )


class SchedulerLines:
    """Progress and failure of a task in the lines that Open Job Description reads, on this process's standard output.

    They are written whole and at once, to where standard output went when this was made: Blender's own is silenced while it
    works.
    See "How Jobs Are Run", the messages of a session, in the Open Job Description specifications.
    """

    def __init__(self) -> None:
        self._descriptor: int | None = None
        self._stream: TextIO = sys.stdout
        try:
            sys.stdout.flush()
            self._descriptor = os.dup(sys.stdout.fileno())
        except (OSError, io.UnsupportedOperation):
            pass  # not a file, as in a console of Blender or a notebook: the stream itself will do
        self._percent = -1
        self._message = ""

    def tell(self, progress: Progress) -> None:
        """How far the task is, where it changed by a percent, and what it does."""
        percent = round(100 * min(max(progress.fraction, 0.0), 1.0))
        if percent != self._percent:
            self._percent = percent
            self._write("progress", str(percent))
        if progress.message != self._message:
            self._message = progress.message
            self._write("status", progress.message)

    def fail(self, message: str) -> None:
        """Why the task failed."""
        self._write("fail", message)

    def close(self) -> None:
        """Give the output back."""
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None

    def _write(self, kind: str, text: str) -> None:
        line = f"openjd_{kind}: {' '.join(text.split())}\n"
        if self._descriptor is None:
            self._stream.write(line)
            self._stream.flush()
        else:
            os.write(self._descriptor, line.encode("utf-8", "replace"))


@contextmanager
def ended_by_signal() -> Iterator[None]:
    """A request of the system to end stops the block as Ctrl-C does: whole files stay, temporary ones go.

    Raises
    ------
    Terminated
        In the block, when asked to end.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def end(_number: int, _frame: FrameType | None) -> None:
        raise Terminated

    before = signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL if before is None else before)

"""Processes for the captures of a batch, as many at a time as memory and processors allow."""

from __future__ import annotations

import json
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, Any

from .batch_captures import BatchCapture
from .batch_worker import BOOT, STOPPED, words_for
from .files.staging import remove_leftovers
from .parallel import processors

_STOP_S = 10.0
"""How long a process may take to put away what it was doing before it is killed."""

_TICK_S = 0.2

type Told = dict[str, Any]


@dataclass
class _Worker:
    capture: BatchCapture
    needs_bytes: int
    process: subprocess.Popen[str]
    errors: IO[bytes]
    fraction: float = 0.0
    ended: Told = field(default_factory=dict)


class Workers:
    """The running processes of a batch.

    Parameters
    ----------
    budget_bytes
        What all together may take; one alone is started whatever it needs.
    jobs
        How many at a time at most.
    width_px
        Width of the panoramas.
    """

    def __init__(self, budget_bytes: int, jobs: int, width_px: int | None) -> None:
        self._budget_bytes, self._jobs, self._width_px = budget_bytes, jobs, width_px
        self._running: list[_Worker] = []
        self._told: queue.Queue[tuple[_Worker, Told | None]] = queue.Queue()

    @property
    def running(self) -> int:
        """How many run now."""
        return len(self._running)

    @property
    def fractions(self) -> float:
        """How much of the running captures is done, in captures."""
        return sum(worker.fraction for worker in self._running)

    def has_room_for(self, needs_bytes: int) -> bool:
        """Whether a capture that needs so much memory may be started now."""
        taken = sum(worker.needs_bytes for worker in self._running)
        return not self._running or (
            len(self._running) < self._jobs and taken + needs_bytes <= self._budget_bytes
        )

    def start(self, capture: BatchCapture, needs_bytes: int) -> None:
        """Start the process of a capture."""
        errors = TemporaryFile()  # noqa: SIM115  (it lives as long as the process)
        process = subprocess.Popen(  # noqa: S603  (this interpreter, and words of our own)
            _command(max(1, processors() // self._jobs)),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
            text=True,
            encoding="utf-8",
            # Ctrl-C in a terminal reaches a whole group of processes; the batch alone decides what it means.
            start_new_session=True,
        )
        worker = _Worker(capture, needs_bytes, process, errors)
        self._running.append(worker)
        with suppress(OSError):  # it ended at once; its exit status says so
            _pipe(process.stdin).write(words_for(capture.path, capture.folder, self._width_px) + "\n")
            _pipe(process.stdin).flush()
        threading.Thread(target=self._listen, args=(worker,), daemon=True).start()

    def wait(self, ended: Callable[[BatchCapture, Told], None]) -> None:
        """Wait a moment for news; `ended` is told of each process that came to its end, "done" or "failed"."""
        try:
            worker, told = self._told.get(timeout=_TICK_S)
        except queue.Empty:
            return
        if told is None:
            self._running.remove(worker)
            ended(worker.capture, worker.ended or {"failed": self._why(worker)})
            worker.errors.close()
        elif "progress" in told:
            worker.fraction = float(told["progress"])
        else:
            worker.ended = told

    def stop(self) -> None:
        """Stop all: each puts away what it was writing, or is killed."""
        for worker in self._running:
            with suppress(OSError):
                _pipe(worker.process.stdin).close()
        for worker in self._running:
            try:
                worker.process.wait(_STOP_S)
            except subprocess.TimeoutExpired:
                worker.process.kill()
                worker.process.wait()
            worker.errors.close()
            remove_leftovers(worker.capture.folder)
        self._running.clear()

    def _listen(self, worker: _Worker) -> None:
        """Hand on what a process tells, in a thread, until it has ended."""
        pipe = _pipe(worker.process.stdout)
        with suppress(ValueError, OSError):  # closed, or no text
            for line in pipe:
                with suppress(ValueError):  # a library's own remark
                    told = json.loads(line)
                    if isinstance(told, dict):
                        self._told.put((worker, told))
        worker.process.wait()
        for end in (worker.process.stdin, pipe):
            with suppress(OSError):
                _pipe(end).close()
        self._told.put((worker, None))

    def _why(self, worker: _Worker) -> str:
        """What is told of a process that ended without a word."""
        status = worker.process.returncode
        if status in (STOPPED, -signal.SIGTERM, -signal.SIGINT):
            return "Its process was ended by someone. Start the batch again: what is done is kept."
        if status < 0:
            name = signal.Signals(-status).name if -status in set(signal.Signals) else str(-status)
            return (
                f"Its process was killed ({name}), as systems do when memory runs short. Start the batch again with --jobs 1 "
                "or a smaller --width: what is done is kept."
            )
        worker.errors.seek(0)
        lines = worker.errors.read().decode("utf-8", "replace").strip().splitlines()
        last = lines[-1] if lines else f"exit status {status}"
        return f"Its process ended with a defect of this program ({last[:300]}). Please report it."


def _command(threads: int) -> Sequence[str | Path]:
    """The interpreter that runs this, Blender's own too, on its share of the processors."""
    return [sys.executable, "-I", "-X", "utf8", "-X", f"cpu_count={threads}", "-c", BOOT]


def _pipe(pipe: IO[str] | None) -> IO[str]:
    if pipe is None:
        raise OSError("no pipe")
    return pipe

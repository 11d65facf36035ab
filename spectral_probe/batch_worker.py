"""One capture of a batch, in a process of its own: `python -c BOOT` with what to do on its standard input.

It tells its progress and its end on standard output, a line of JSON each. When its standard input closes, because the batch was
stopped or killed, it stops: a half-written output is never left in a probe's place.
"""

from __future__ import annotations

import json
import signal
import sys
import threading
import time
from _thread import interrupt_main
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

from .batch_memory import peak_bytes
from .batch_record import OUTPUTS, BatchRecord, digests_of, input_digests, program_version, write_record
from .errors import SpectralProbeError
from .files.capture import load_capture
from .files.lock import folder_lock
from .model import Job, Progress, part
from .probe import build_probe, write_outputs

STOPPED = 130
_TELL_EVERY_S = 0.2
_WAIT_S = 15.0
"""For the worker of a batch that was killed, which stops as soon as it sees that."""

BOOT = """
import sys, json, importlib.util
words = json.loads(sys.stdin.readline())
sys.path[:] = words["path"]
spec = importlib.util.spec_from_file_location("spectral_probe", words["core"] + "/__init__.py",
                                              submodule_search_locations=[words["core"]])
core = importlib.util.module_from_spec(spec)
sys.modules["spectral_probe"] = core
spec.loader.exec_module(core)
from spectral_probe.batch_worker import work
sys.exit(work(words))
"""
"""What the process runs first: this package from where it lies, with the libraries that the batch's own process found."""


def words_for(capture: Path, folder: Path, width_px: int | None) -> str:
    """What a worker reads first."""
    return json.dumps(
        {
            "path": sys.path,
            "core": str(Path(__file__).resolve().parent),
            "capture": str(capture),
            "folder": str(folder),
            "width_px": width_px,
        }
    )


def work(words: Mapping[str, Any]) -> int:
    """Do what the words say; the exit status is 0 also where it failed for a reason that was told."""
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it
    threading.Thread(target=_stop_with, args=(sys.stdin,), daemon=True).start()
    told: dict[str, Any]
    try:
        told = {"done": _driven(_built(Path(words["capture"]), Path(words["folder"]), words["width_px"]))}
    except SpectralProbeError as problem:
        told = {"failed": str(problem)}
    except KeyboardInterrupt:
        return STOPPED
    _tell(told)
    return 0


def _built(capture_path: Path, folder: Path, width_px: int | None) -> Job[dict[str, Any]]:
    """Build a capture's probe into a folder, with its record; the numbers for the batch's table."""
    start = time.perf_counter()
    with folder_lock(folder, wait_s=_WAIT_S):
        inputs = input_digests(
            capture_path
        )  # before the photographs are read: what changes later counts as changed
        capture = load_capture(capture_path)
        probe = yield from part(build_probe(capture, width_px), 0.0, 0.7)
        yield from part(write_outputs(probe, folder), 0.7, 1.0)
        numbers = {
            **table_row(probe.report),
            "seconds": round(time.perf_counter() - start, 2),
            "peak_memory_mb": round(peak_bytes() / 1e6),
        }
        outputs = digests_of((folder / name for name in OUTPUTS), folder)
        write_record(
            folder, BatchRecord(str(capture_path), program_version(), width_px, inputs, outputs, numbers)
        )
    return numbers


def table_row(report: Mapping[str, Any]) -> dict[str, Any]:
    """The numbers of a probe's report that a batch's table has."""
    views = report["views"]
    return {
        "views": len(views),
        "photographs": sum(len(view["photos"]) for view in views),
        "width": report["width"],
        "blind_fraction": report["blind_fraction"],
        "outline_rms_px": max(view["outline_rms_px"] for view in views),
        "clipped_fraction": max(view["clipped_fraction"] for view in views),
        "direction_error_deg": report["median_direction_error_deg"],
        "warnings": len(report["warnings"]),
    }


def _driven(job: Job[dict[str, Any]]) -> dict[str, Any]:
    told = 0.0
    while True:
        try:
            progress: Progress = next(job)
        except StopIteration as stop:
            return dict(stop.value)
        if time.monotonic() - told > _TELL_EVERY_S:
            told = time.monotonic()
            _tell({"progress": progress.fraction, "message": progress.message})


def _tell(what: Mapping[str, Any]) -> None:
    try:
        sys.stdout.write(json.dumps(what) + "\n")
        sys.stdout.flush()
    except OSError:  # nobody listens any more
        raise KeyboardInterrupt from None


def _stop_with(pipe: IO[str]) -> None:
    """Wait until the batch's end of the pipe closes, then stop the work."""
    pipe.read()
    if hasattr(signal, "pthread_kill"):  # wakes it where it waits for threads
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
    else:
        interrupt_main()

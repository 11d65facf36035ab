"""Many captures to probes: in parallel processes, what is done and unchanged left alone, one table of all."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from .batch_captures import BatchCapture, find_captures, named
from .batch_memory import memory_free, memory_needed
from .batch_processes import Told, Workers
from .batch_record import owners, read_record, unchanged
from .errors import CaptureError, PartlyFailedError, SpectralProbeError
from .files.atomic import written_whole
from .files.capture import load_capture
from .files.lock import folder_lock
from .geometry.panorama import WIDTHS
from .model import Job, Progress
from .parallel import processors

type Numbers = dict[str, Any]

COLUMNS = (
    "name", "capture", "folder", "status", "message", "seconds", "views", "photographs", "width", "blind_fraction",
    "outline_rms_px", "clipped_fraction", "direction_error_deg", "warnings", "peak_memory_mb", "estimated_memory_mb",
)  # fmt: skip
"""Of summary.csv; summary.json has the same names."""

_CHECKING = 0.05
"""Share of the progress that looking for what is done takes."""


@dataclass
class _Batch:
    output: Path
    width_px: int | None
    rows: dict[str, Numbers] = field(default_factory=dict)
    known_bytes: dict[str, int] = field(default_factory=dict)
    larger: float = 1.0  # how much more memory captures took than was estimated, at most


def probe_many(
    given: Sequence[Path],
    output: Path,
    width_px: int | None = None,
    *,
    jobs: int | None = None,
    restart: bool = False,
) -> Job[Numbers]:
    """Captures to probes, each in a folder of its own within `output`, and summary.csv and summary.json there.

    Parameters
    ----------
    given
        Capture files, and folders that have some (`batch_captures.find_captures`).
    output
        Folder of the batch.
    width_px
        Width of the panoramas in pixels; None: each as fine as its photographs.
    jobs
        How many captures at a time at most; None: as many as there are processors. Memory may allow fewer.
    restart
        Make all of them, also what is done and unchanged.

    Returns
    -------
    dict
        Counts, and the table's rows.

    Raises
    ------
    CaptureError
        If there is nothing to do, or the width is none.
    PartlyFailedError
        If some captures failed, at the end, with the numbers of all.
    """
    if width_px is not None and (width_px % 2 or not WIDTHS[0] <= width_px <= WIDTHS[1]):
        raise CaptureError(
            f"A panorama's width must be an even number from {WIDTHS[0]} to {WIDTHS[1]}, not {width_px}."
        )
    yield Progress(0.0, "Looking for captures")
    output = output.resolve()
    paths = find_captures(given, output)
    with folder_lock(output):
        captures = named(paths, output, owners(output))
        batch = _Batch(output, width_px)
        try:
            left = captures if restart else (yield from _not_done(batch, captures))
            yield from _made(batch, captures, left, jobs or processors())
        finally:
            _write_summary(batch, captures)
    return _numbers(batch, captures)


def _not_done(batch: _Batch, captures: Sequence[BatchCapture]) -> Job[list[BatchCapture]]:
    """The captures that are to be made; the others get their rows."""
    left = []
    with ThreadPoolExecutor(processors()) as pool:  # hashing lets other threads run
        checks = pool.map(partial(_finished, batch), captures)
        for number, (capture, row) in enumerate(zip(captures, checks, strict=True)):
            if row is None:
                left.append(capture)
            else:
                batch.rows[capture.name] = row
            yield Progress(_CHECKING * (number + 1) / len(captures), "Checking what is done")
    return left


def _finished(batch: _Batch, capture: BatchCapture) -> Numbers | None:
    """The row of a capture that is done and unchanged."""
    record = read_record(capture.folder)
    try:
        if record is None or not unchanged(record, capture.path, batch.width_px, capture.folder):
            return None
    except (SpectralProbeError, OSError):  # making it says what is wrong
        return None
    return {**record.numbers, "status": "skipped", "message": "done before, and unchanged"}


def _made(
    batch: _Batch, captures: Sequence[BatchCapture], left: Sequence[BatchCapture], jobs: int
) -> Job[None]:
    """Make captures in processes; each gets its row when it ends."""
    waiting = list(left)
    with closing(_Stopping(Workers(memory_free(), min(jobs, max(len(left), 1)), batch.width_px))) as stopping:
        workers = stopping.workers
        while waiting or workers.running:
            if waiting and _can_be_read(batch, waiting[0]):
                needs = int(batch.known_bytes[waiting[0].name] * batch.larger)
                if workers.has_room_for(needs):
                    workers.start(waiting.pop(0), needs)
                    continue
            elif waiting:
                waiting.pop(0)
                continue
            done = len(batch.rows) + workers.fractions
            yield Progress(
                _CHECKING + (1 - _CHECKING) * done / len(captures),
                f"{len(batch.rows)} of {len(captures)} captures, {workers.running} in work{_failures(batch)}",
            )
            workers.wait(partial(_ended, batch))


@dataclass
class _Stopping:
    """Stops all processes at the end, however it comes."""

    workers: Workers

    def close(self) -> None:
        self.workers.stop()


def _can_be_read(batch: _Batch, capture: BatchCapture) -> bool:
    """Whether the capture can be read; estimates its memory, or notes its failure."""
    if capture.name not in batch.known_bytes:
        try:
            batch.known_bytes[capture.name] = memory_needed(load_capture(capture.path), batch.width_px)
        except SpectralProbeError as problem:
            batch.rows[capture.name] = {"status": "failed", "message": str(problem)}
            return False
    return True


def _ended(batch: _Batch, capture: BatchCapture, told: Told) -> None:
    """Note how a capture ended, and learn from the memory that it took."""
    estimate = batch.known_bytes[capture.name]
    row: Numbers = {"estimated_memory_mb": round(estimate / 1e6)}
    if "done" in told:
        row |= {**told["done"], "status": "done", "message": ""}
        batch.larger = max(batch.larger, row["peak_memory_mb"] * 1e6 / estimate)
    else:
        row |= {"status": "failed", "message": str(told["failed"])}
    batch.rows[capture.name] = row


def _failures(batch: _Batch) -> str:
    count = _count(batch.rows.values(), "failed")
    return f", {count} failed" if count else ""


def _count(rows: Iterable[Numbers], status: str) -> int:
    return sum(row["status"] == status for row in rows)


def _rows(batch: _Batch, captures: Sequence[BatchCapture]) -> list[Numbers]:
    """A row for each capture, with all columns, in their order."""
    not_begun = {"status": "stopped", "message": "The batch was stopped before it was done."}
    rows = []
    for capture in captures:
        known = {
            **batch.rows.get(capture.name, not_begun),
            "name": capture.name,
            "capture": str(capture.path),
            "folder": str(capture.folder),
        }
        rows.append({column: known.get(column) for column in COLUMNS})
    return rows


def _write_summary(batch: _Batch, captures: Sequence[BatchCapture]) -> None:
    rows = _rows(batch, captures)
    text = io.StringIO(newline="")
    table = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    table.writeheader()
    table.writerows({key: "" if value is None else value for key, value in row.items()} for row in rows)
    with written_whole(batch.output / "summary.csv") as temporary:
        temporary.write_text(text.getvalue(), encoding="utf-8")
    with written_whole(batch.output / "summary.json") as temporary:
        temporary.write_text(json.dumps({"captures": rows}, indent=1) + "\n", encoding="utf-8")


def _numbers(batch: _Batch, captures: Sequence[BatchCapture]) -> Numbers:
    """The numbers to tell.

    Raises
    ------
    PartlyFailedError
        If some captures failed.
    """
    rows = _rows(batch, captures)
    counts = {status: _count(rows, status) for status in ("done", "skipped", "failed")}
    numbers = {
        "captures": len(rows),
        **counts,
        "taken": [str(capture.path) for capture in captures],
        "table": rows,
        "summary": str(batch.output / "summary.csv"),
        "written": str(batch.output),
    }
    if counts["failed"]:
        raise PartlyFailedError(
            [f"{row['name']}: {row['message']}" for row in rows if row["status"] == "failed"], numbers
        )
    return numbers

"""Work that a job hands to whoever drives it: a window's driver does it in a thread, and the window stays alive.

A job says with a step's `Progress.work` what it needs before it goes on. A driver may have it done elsewhere meanwhile; where
none has, it is done when the job asks for its result. So every driver gives the same, and most need not know of it.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, replace
from functools import partial
from typing import cast

from .model import Job, Progress


class Work[Result]:
    """A call that touches no Blender data, and its result once it was done; an error is raised where the result is asked for.

    Examples
    --------
    >>> work = Work(lambda: 6 * 7)
    >>> work.done
    False
    >>> work.result()
    42
    """

    def __init__(self, call: Callable[[], Result]) -> None:
        self._call = call
        self._outcome: Future[Result] = Future()

    @property
    def done(self) -> bool:
        """Whether it was done, well or not."""
        return self._outcome.done()

    @property
    def given(self) -> Result | None:
        """What it gave; None before, and where it failed."""
        return self._outcome.result() if self.done and self._outcome.exception() is None else None

    def run(self) -> None:
        """Do it, in whatever thread."""
        try:
            result = self._call()
        except BaseException as problem:  # noqa: BLE001  (raised again by `result`, in the job's own thread)
            self._outcome.set_exception(problem)
        else:
            self._outcome.set_result(result)

    def result(self) -> Result:
        """What it gave; does it now if nobody has."""
        if not self.done:
            self.run()
        return self._outcome.result()


@dataclass(frozen=True)
class Finished[Result]:
    """The end of a job and what it gave."""

    result: Result


def advance[Result](job: Job[Result]) -> Progress | Finished[Result]:
    """One step of a job."""
    try:
        return next(job)
    except StopIteration as stop:
        return Finished(cast("Result", stop.value))


def worked[Result](progress: Progress, call: Callable[[], Result]) -> Job[Result]:
    """A job of one step, which touches no Blender data: what is told of it, and what it calls.

    Examples
    --------
    >>> def job():
    ...     total = yield from worked(Progress(0.5, "adding"), lambda: 1 + 2)
    ...     return total * 2
    >>> from spectral_probe.model import finish
    >>> finish(job())
    6
    """
    work = Work(call)
    yield replace(progress, work=work)
    return work.result()


def all_worked[Result](job: Job[Result]) -> Job[Result]:
    """A job none of whose steps touches Blender data, each of them as work for a thread.

    Examples
    --------
    >>> def job():
    ...     yield Progress(0.5, "half way")
    ...     return 42
    >>> from spectral_probe.model import finish
    >>> finish(all_worked(job()))
    42
    """
    progress = Progress(0.0, "")
    try:
        while True:
            step = yield from worked(progress, partial(advance, job))
            if isinstance(step, Finished):
                return step.result
            progress = step
    finally:
        job.close()

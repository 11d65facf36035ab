"""The job that goes on while Blender's window lives: one step after another, its work in a thread, its renders as Blender's.

One at a time. Undo, saving and switching the extension off end it first, and Blender itself ends it where another file is
opened or a window closed (`JobOperator.cancel`): its scene is put back before anything else happens.
"""

from __future__ import annotations

import logging
import time
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import bpy
from bpy.app.handlers import persistent
from bpy.app.translations import pgettext_rpt as rpt_

from ..spectral_probe.model import Job, Progress
from ..spectral_probe.work import Finished, Work, advance
from .bridge.render_job import BlenderRender

_LOG = logging.getLogger(__name__)
_WAIT_S = 0.02

_running: list[RunningJob] = []  # the one that runs, or nothing


class RunningJob:
    """A job, driven by ticks of a timer.

    Parameters
    ----------
    label
        What it does, as its button says.
    job
        The job.
    in_thread
        No step of it touches Blender data; undo then lets it go on.
    """

    def __init__(self, label: str, job: Job[Any], *, in_thread: bool) -> None:
        self.label, self.in_thread = label, in_thread
        self.stopping = False
        self.ended_by = ""
        self._job = job
        self._worker = ThreadPoolExecutor(max_workers=1, thread_name_prefix="Spectral Probe")
        self._work: Work[Any] | None = None
        self._future: Future[None] | None = None
        _running.append(self)

    @property
    def rendering(self) -> bool:
        """Whether Blender renders for it now."""
        return isinstance(self._work, BlenderRender)

    @property
    def open(self) -> bool:
        """Whether it still goes on."""
        return self in _running

    def tick(self) -> Progress | Finished[Any] | None:
        """Go on by one step, as far as what was begun is done.

        Returns
        -------
        Progress, Finished or None
            The step that begins now, the end, or nothing new. With `stopping` set nothing new begins: the caller calls `end`
            once `busy` is false.
        """
        if self.busy or (self.stopping and not self._has_finished()):
            return None
        self._work_done()
        step = advance(self._job)
        if isinstance(step, Progress) and step.work is not None:
            self._begin(step.work)
        return step

    @property
    def busy(self) -> bool:
        """Whether a step was begun elsewhere and is not done."""
        if isinstance(self._work, BlenderRender):
            if self._work.running:
                return True
            self.stopping = self.stopping or self._work.stopped
        return self._future is not None and not self._future.done()

    def end(self, reason: str = "") -> None:
        """End the job now: wait for what runs elsewhere, and let the job put back what it changed."""
        if not self.open:
            return
        _running.remove(self)
        self.ended_by = reason
        try:
            self._wait()
            self._work_done()
        finally:
            self._worker.shutdown()
            self._job.close()

    def _begin(self, work: Work[Any]) -> None:
        self._work = work
        if isinstance(work, BlenderRender):
            work.start()
        else:
            self._future = self._worker.submit(work.run)

    def _has_finished(self) -> bool:
        """Whether the work was the job's last: its result is there, and nothing is left to be stopped."""
        return self._work is not None and isinstance(self._work.given, Finished)

    def _wait(self) -> None:
        """Until nothing of the job runs elsewhere."""
        if self._future is not None:
            self._future.exception()
        while isinstance(self._work, BlenderRender) and self._work.in_its_thread:
            time.sleep(_WAIT_S)

    def _work_done(self) -> None:
        if isinstance(self._work, BlenderRender):
            self._work.close()
        self._work = self._future = None


def running() -> RunningJob | None:
    """The job that runs now."""
    return _running[0] if _running else None


@persistent
def _before_undo(*_: object) -> None:
    job = running()
    if job is not None and not job.in_thread:  # what it holds of the scene is another's after undo
        job.end(rpt_("undo was pressed"))


@persistent
def _before_saving(*_: object) -> None:
    job = running()
    if job is not None and not job.in_thread:  # stand-ins for materials and the world must not be saved
        job.end(rpt_("the file was saved"))


def _handlers() -> tuple[tuple[list[Any], Any], ...]:
    handlers = bpy.app.handlers
    return (
        (handlers.undo_pre, _before_undo),
        (handlers.redo_pre, _before_undo),
        (handlers.save_pre, _before_saving),
    )


def register() -> None:
    """Listen to what ends a job."""
    unregister()
    for handlers, handler in _handlers():
        handlers.append(handler)


def unregister() -> None:
    """End a job that runs, and listen no longer."""
    job = running()
    if job is not None:
        job.end(rpt_("the extension was switched off"))
        _tell(job)
    for handlers, handler in _handlers():
        if handler in handlers:
            handlers.remove(handler)


def _tell(job: RunningJob) -> None:
    """Say what ended a job whose operator is gone, and cannot report it."""
    text = rpt_("{job} was stopped, because {reason}").format(job=job.label, reason=job.ended_by)
    if bpy.app.background or bpy.context.window is None:
        _LOG.warning("%s", text)
        return

    def draw(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
        menu.layout.label(text=text, translate=False)

    bpy.context.window_manager.popup_menu(draw, title="Spectral Probe", icon="INFO")

"""Long work as a generator of `Progress`, with two drivers: modal in a window, blocking without one.

ESC stops a job at its next step; closing the generator runs its `finally`, which puts the scene back. A job
that touches no Blender data runs its steps in a worker thread: the window stays alive while they last.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from typing import Any

import bpy

from ..spectral_probe.model import Job, Progress
from .base import CANCELLED, FINISHED, OperatorResult, ReportsErrors

RUNNING: OperatorResult = {"RUNNING_MODAL"}
_TICK_S = 0.05
_NAVIGATION = {"MIDDLEMOUSE", "MOUSEMOVE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "TRACKPADPAN", "TRACKPADZOOM"}


@dataclass(frozen=True)
class Finished[Result]:
    """The end of a job and what it gave."""

    result: Result


def advance[Result](job: Job[Result]) -> Progress | Finished[Result]:
    """One step of a job."""
    try:
        return next(job)
    except StopIteration as stop:
        return Finished(stop.value)


class JobOperator(ReportsErrors):
    """Mixin for operators whose work is a job. `job` starts it, `done` takes its result."""

    in_thread = False
    """True where the job's steps touch no Blender data."""

    after_stop = ""
    """What the user is told, besides, when ESC has stopped the job."""

    _open: ExitStack | None = None  # what must be closed when the modal driver ends
    _job: Job[Any] | None = None
    _worker: ThreadPoolExecutor | None = None
    _step: Future[Progress | Finished[Any]] | None = None
    _cancelling = False

    def job(self, context: bpy.types.Context) -> Job[Any]:
        """Read the settings and return the job; every operator has its own."""
        raise NotImplementedError

    def done(self, context: bpy.types.Context, result: Any) -> None:
        """Keep and report the result; every operator has its own."""
        raise NotImplementedError

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Block until the job is done: the driver for background and scripts."""
        with closing(self.job(context)) as job, _progress_shown(context, type(self).bl_idname):
            while not isinstance(step := advance(job), Finished):
                _show(context, step)
        self.done(context, step.result)
        return FINISHED

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        """Start the job and come back; `modal` drives it."""
        if bpy.app.background:
            return self.execute(context)
        return self.reporting(lambda: self._begin(context))

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        """Called by Blender for every event while the job lasts."""
        if event.type == "ESC" and event.value == "PRESS":
            self._cancelling = True
            context.workspace.status_text_set("Stopping after this step...")
        if event.type != "TIMER":
            return {"PASS_THROUGH"} if event.type in _NAVIGATION else RUNNING
        result = CANCELLED
        try:
            result = self.reporting(lambda: self._tick(context))
        finally:  # after a defect too: nothing of the job may stay behind
            if result != RUNNING:
                self._end()
        return result

    def cancel(self, _context: bpy.types.Context) -> None:
        """Called by Blender when it ends the operator itself, such as when another file is opened."""
        self._end()

    def _begin(self, context: bpy.types.Context) -> OperatorResult:
        with ExitStack() as opened:
            self._job = opened.enter_context(closing(self.job(context)))
            if self.in_thread:  # leaving it waits for its step: a generator that runs cannot be closed
                self._worker = opened.enter_context(ThreadPoolExecutor(max_workers=1))
            opened.enter_context(_progress_shown(context, type(self).bl_idname))
            timer = context.window_manager.event_timer_add(_TICK_S, window=context.window)
            opened.callback(context.window_manager.event_timer_remove, timer)
            context.window_manager.modal_handler_add(self)
            self._open = opened.pop_all()
        return RUNNING

    def _tick(self, context: bpy.types.Context) -> OperatorResult:
        if self._step is not None and not self._step.done():
            return RUNNING
        step = self._step.result() if self._step is not None else None
        self._step = None
        if self._cancelling and not isinstance(step, Finished):
            self.report({"INFO"}, f"{self.bl_label} stopped{self.after_stop}")
            return CANCELLED
        if step is None and self._worker is None:
            step = advance(self._job)
        if isinstance(step, Finished):
            self.done(context, step.result)
            return FINISHED
        if step is not None:
            _show(context, step)
        if self._worker is not None:
            self._step = self._worker.submit(advance, self._job)
        return RUNNING

    def _end(self) -> None:
        if self._open is not None:
            self._open.close()


@contextmanager
def _progress_shown(context: bpy.types.Context, operator: str) -> Iterator[None]:
    """Cursor, status bar and panels show progress until the block ends."""
    window_manager, workspace = context.window_manager, context.workspace
    window_manager.spectral_probe.operator = operator
    window_manager.spectral_probe.fraction = 0.0
    window_manager.progress_begin(0.0, 1.0)
    try:
        yield
    finally:
        window_manager.progress_end()
        window_manager.property_unset("spectral_probe")
        if workspace is not None and not bpy.app.background:
            workspace.status_text_set(None)
        _redraw(window_manager)


def _show(context: bpy.types.Context, step: Progress) -> None:
    shown = context.window_manager.spectral_probe
    shown.fraction, shown.message = step.fraction, step.message
    context.window_manager.progress_update(step.fraction)
    if not bpy.app.background and context.workspace is not None:
        context.workspace.status_text_set(f"{step.message} ({step.fraction:.0%}), ESC stops it")
    _redraw(context.window_manager)


def _redraw(window_manager: bpy.types.WindowManager) -> None:
    for window in window_manager.windows:
        for area in window.screen.areas:
            area.tag_redraw()

"""Long work as a generator of `Progress`, with two drivers: modal in a window, blocking without one.

ESC stops a job at its next step, and a render at once; closing the generator runs its `finally`, which puts the scene back. Steps
that touch no Blender data run in a thread, renders as Blender's own render job (`running_job`): the window stays alive.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from functools import partial
from importlib import import_module
from typing import Any, ClassVar

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..spectral_probe.errors import SpectralProbeError
from ..spectral_probe.model import Job, Progress
from ..spectral_probe.work import Finished, advance, all_worked, worked
from ..translations import of_core
from .base import CANCELLED, FINISHED, OperatorResult, ReportsErrors
from .job_progress import progress_shown
from .job_report import keep_report
from .open_modals import keep_open
from .running_job import RunningJob, running

RUNNING: OperatorResult = {"RUNNING_MODAL"}
_TICK_S = 0.05
_NAVIGATION = {"MIDDLEMOUSE", "MOUSEMOVE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "TRACKPADPAN", "TRACKPADZOOM"}


class JobOperator(ReportsErrors):
    """Mixin for operators whose work is a job. `job` starts it, `done` takes its result."""

    in_thread = False
    """True where none of the job's steps touches Blender data: all of them run in the thread."""

    needs: ClassVar[tuple[str, ...]] = ()
    """Modules that take long to import, as seen from here: a window's driver imports them first, in the thread."""

    after_stop = ""
    """What the user is told, besides, when ESC has stopped the job."""

    _open: ExitStack | None = None  # what must be closed when the modal driver ends
    _running: RunningJob | None = None
    _show: Any = None
    _scene_uid = 0
    _began = 0.0
    _longest_s = 0.0  # for how long at most a step held the window
    _lines: list[tuple[str, str]] | None = None

    def job(self, context: bpy.types.Context) -> Job[Any]:
        """Read the settings and return the job; every operator has its own."""
        raise NotImplementedError

    def done(self, context: bpy.types.Context, result: Any) -> None:
        """Keep and tell the result; every operator has its own."""
        raise NotImplementedError

    def tell(self, kind: str, text: str) -> None:
        """Report a line ("INFO" or "WARNING"), which also stays in the job's own report (`job_report`)."""
        text = of_core(text)
        self.report({kind}, text)
        if self._lines is not None:
            self._lines.append((kind, text))

    def reporting(self, work: Callable[[], OperatorResult]) -> OperatorResult:
        """The result of `work`, or CANCELLED with a report; both stay in the job's own report."""
        result = CANCELLED
        try:
            result = work()
        except SpectralProbeError as problem:
            self._fail(str(problem))
        except ReferenceError:  # what Blender raises for removed data
            self._fail(_gone(self.label()))
        if self._lines is not None and result in (FINISHED, CANCELLED):
            keep_report(
                type(self).bl_idname,
                self.label(),
                finished=result == FINISHED,
                seconds=time.monotonic() - self._began,
                lines=self._lines,
                longest_step_s=self._longest_s,
            )
        return result

    def _fail(self, text: str) -> None:
        text = of_core(text)
        self.report({"ERROR"}, text)
        if self._lines is not None:
            self._lines.append(("ERROR", text))

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Block until the job is done: the driver for background and scripts."""
        self._refuse_second()
        self._remember(context)
        with closing(self.job(context)) as job, progress_shown(context, type(self).bl_idname) as show:
            while not isinstance(step := advance(job), Finished):
                show(context, step)
        self._done(context, step.result)
        return FINISHED

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        """Start the job and come back; `modal` drives it."""
        if bpy.app.background:
            return self.execute(context)
        return self.reporting(lambda: self._timed(self._begin, context))

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        """Called by Blender for every event while the job lasts."""
        job = self._running
        if event.type == "ESC" and event.value == "PRESS" and job is not None:
            job.stopping = True
            context.workspace.status_text_set(rpt_("Stopping after this step..."))
        if event.type != "TIMER" and (job is None or job.open):
            return {"PASS_THROUGH"} if event.type in _NAVIGATION else RUNNING
        result = CANCELLED
        try:
            result = self.reporting(lambda: self._timed(self._tick, context))
        finally:  # after a defect too: nothing of the job may stay behind
            if result != RUNNING:
                self._end()
        return result

    def cancel(self, _context: bpy.types.Context) -> None:
        """Called by Blender when it ends the operator itself, such as when another file is opened."""
        self._end()

    def _begin(self, context: bpy.types.Context) -> OperatorResult:
        self._refuse_second()
        self._remember(context)
        with ExitStack() as opened:
            self._show = opened.enter_context(progress_shown(context, type(self).bl_idname))
            whole = self._whole(context)
            self._running = RunningJob(self.label(), whole, in_thread=self.in_thread)
            opened.callback(self._running.end)
            timer = context.window_manager.event_timer_add(_TICK_S, window=context.window)
            opened.callback(context.window_manager.event_timer_remove, timer)
            context.window_manager.modal_handler_add(self)
            self._open = opened.pop_all()
            keep_open(self._open)
        return RUNNING

    def _whole(self, context: bpy.types.Context) -> Job[Any]:
        """The job from the import of its modules on, for a window."""
        if self.needs:
            yield from worked(Progress(0.0, rpt_("Starting")), partial(_import, self.needs))
        with _its_scene(context, self._scene_uid, self.label()):
            job = self.job(context)
        return (yield from all_worked(job) if self.in_thread else job)

    def _timed(
        self, step: Callable[[bpy.types.Context], OperatorResult], context: bpy.types.Context
    ) -> OperatorResult:
        began = time.monotonic()
        try:
            return step(context)
        finally:
            self._longest_s = max(self._longest_s, time.monotonic() - began)

    def _tick(self, context: bpy.types.Context) -> OperatorResult:
        job = self._running
        if not job.open:
            text = rpt_("{job} was stopped, because {reason}").format(job=job.label, reason=job.ended_by)
            self.tell("WARNING", text)
            return CANCELLED
        step = job.tick()
        if isinstance(step, Finished):
            job.end()
            self._done(context, step.result)
            return FINISHED
        if step is not None:
            self._show(context, step)
        elif job.stopping and not job.busy:
            job.end()
            told = rpt_("{job} stopped").format(job=job.label)
            if self.after_stop:
                told = f"{told}. {rpt_(self.after_stop)}"
            self.tell("INFO", told)
            return CANCELLED
        return RUNNING

    def _refuse_second(self) -> None:
        job = running()
        if job is not None:
            text = rpt_("{job} is still running. Wait until it is done, or stop it with ESC.")
            raise SpectralProbeError(text.format(job=job.label))

    def _remember(self, context: bpy.types.Context) -> None:
        self._scene_uid, self._began, self._lines = context.scene.session_uid, time.monotonic(), []
        self._longest_s = 0.0

    def _done(self, context: bpy.types.Context, result: Any) -> None:
        with _its_scene(context, self._scene_uid, self.label()):
            self.done(context, result)

    def _end(self) -> None:
        if self._open is not None:
            self._open.close()


@contextmanager
def _its_scene(context: bpy.types.Context, uid: int, label: str) -> Iterator[None]:
    """The context's scene is the one that the job was started in, whatever the window shows now."""
    scene = next((scene for scene in bpy.data.scenes if scene.session_uid == uid), None)
    if scene is None:
        raise SpectralProbeError(_gone(label))
    if scene == context.scene:
        yield
        return
    with context.temp_override(scene=scene, view_layer=scene.view_layers[0]):
        yield


def _import(modules: tuple[str, ...]) -> None:
    for module in modules:
        import_module(module, __package__)


def _gone(label: str) -> str:
    text = rpt_(
        "{job} ended: its scene, or something it uses, was removed meanwhile. Undo that, and start it again."
    )
    return text.format(job=label)

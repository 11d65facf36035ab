"""Renders by Blender: blocking in background and scripts, as Blender's own render job where a window's driver starts them.

While a render job runs, Blender's interface is locked: whatever changed the scene then would change it under Cycles. ESC, and
the cross beside Blender's progress bar, stop it within the pass.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from typing import Any

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ...spectral_probe.errors import RenderError
from ...spectral_probe.work import Work
from .restore import changed, is_gone


class BlenderRender(Work[None]):
    """A render of a scene.

    A driver that does not know of it gets a blocking render when the job goes on. One with a window calls `start`, asks `running`
    now and then from the main thread, and `close` at the end.
    """

    def __init__(self, scene: bpy.types.Scene) -> None:
        super().__init__(partial(_blocking, scene))
        self._scene, self._name = scene, scene.name
        self._told = ""  # what Blender's handlers said of the end; they are called in the render's thread
        self._handlers = ExitStack()
        self._started = False

    @property
    def stopped(self) -> bool:
        """Whether the user has stopped it."""
        return self._told == "cancel"

    def start(self) -> None:
        """Begin it as Blender's render job, in the window of the context.

        Raises
        ------
        RenderError
            If Blender renders already, or refuses to.
        """
        if bpy.app.is_job_running("RENDER"):
            raise RenderError(
                rpt_(
                    "Blender is rendering something else. Wait until it is done, or stop it, and press the button again."
                )
            )
        handlers = bpy.app.handlers
        self._listen(handlers.render_complete, "complete")
        self._listen(handlers.render_cancel, "cancel")
        with ExitStack() as meanwhile:  # both are read only as it starts
            meanwhile.enter_context(_no_render_window())
            meanwhile.enter_context(changed(self._scene.render, use_lock_interface=True))
            try:
                answer = bpy.ops.render.render("INVOKE_DEFAULT", scene=self._name)
            except RuntimeError as problem:
                raise _refusal(problem) from None
        if "RUNNING_MODAL" not in answer:
            raise _refusal("")
        self._started = True

    @property
    def running(self) -> bool:
        """Whether it goes on, or Blender still ends it."""
        return bool(bpy.app.is_job_running("RENDER"))

    @property
    def in_its_thread(self) -> bool:
        """Whether Cycles still works on it, whatever Blender has yet to do in its own thread."""
        return self.running and not self._told

    def result(self) -> None:
        """Nothing; renders now if it was not started.

        Raises
        ------
        RenderError
            If Blender rendered nothing.
        """
        if not self._started:
            super().result()
        elif self._told != "complete":
            raise _refusal("")

    def close(self) -> None:
        """Take back the handlers."""
        self._handlers.close()

    def _listen(self, handlers: list[Any], word: str) -> None:
        def told(*_: object) -> None:
            self._told = self._told or word

        handlers.append(told)
        self._handlers.callback(_taken_back, handlers, told)


def _blocking(scene: bpy.types.Scene) -> None:
    if is_gone(scene):
        raise RenderError(rpt_("The scene was removed while it was rendered."))
    try:
        bpy.ops.render.render(scene=scene.name)
    except RuntimeError as problem:
        raise _refusal(problem) from None


def _refusal(problem: object) -> RenderError:
    said = str(problem).strip().removeprefix("Error: ") or rpt_("look at its console")
    return RenderError(rpt_("Blender did not render: {problem}").format(problem=said))


def _taken_back(handlers: list[Any], told: object) -> None:
    if told in handlers:  # another file may have been opened meanwhile, which clears them
        handlers.remove(told)


@contextmanager
def _no_render_window() -> Iterator[None]:
    """A render that starts in the block opens no window for its picture; the user's preference comes back unchanged."""
    preferences = bpy.context.preferences
    was_dirty = preferences.is_dirty
    with changed(preferences.view, render_display_type="NONE"):
        yield
    preferences.is_dirty = was_dirty

"""What is seen of a job while it runs: the cursor, the status bar and the panels."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..spectral_probe.model import Progress
from ..translations import of_core

type Show = Callable[[bpy.types.Context, Progress], None]


@contextmanager
def progress_shown(context: bpy.types.Context, operator: str) -> Iterator[Show]:
    """Cursor, status bar and panels show progress until the block ends; yields what shows a step."""
    window_manager = context.window_manager
    window_manager.spectral_probe.operator = operator
    window_manager.spectral_probe.fraction = 0.0
    window_manager.progress_begin(0.0, 1.0)
    told: set[str] = set()  # names of workspaces: the user may change to another one

    def show(context: bpy.types.Context, step: Progress) -> None:
        shown = context.window_manager.spectral_probe
        shown.fraction, shown.message = step.fraction, of_core(step.message)
        context.window_manager.progress_update(step.fraction)
        if not bpy.app.background and context.workspace is not None:
            told.add(context.workspace.name)
            text = rpt_("{message} ({fraction:.0%}), ESC stops it")
            context.workspace.status_text_set(text.format(message=shown.message, fraction=step.fraction))
        _redraw(context.window_manager)

    try:
        yield show
    finally:
        window_manager.progress_end()
        window_manager.property_unset("spectral_probe")
        if not bpy.app.background:
            for workspace in bpy.data.workspaces:
                if workspace.name in told:
                    workspace.status_text_set(None)
        _redraw(window_manager)


def _redraw(window_manager: bpy.types.WindowManager) -> None:
    """Draw again what shows progress: sidebars and properties, never a viewport, which may take long."""
    for window in window_manager.windows:
        for area in window.screen.areas:
            for region in area.regions:
                if region.type == "UI" or (area.type == "PROPERTIES" and region.type == "WINDOW"):
                    region.tag_redraw()

"""Modal operators that are open now, so that none leaves anything behind where the extension is switched off meanwhile.

Blender drops a modal operator whose class is unregistered, and does not call its `cancel`.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import bpy

_open: list[ExitStack] = []


def keep_open(stack: ExitStack) -> None:
    """Close a stack with the extension, unless it is closed before."""
    _open.append(stack)
    stack.callback(_open.remove, stack)


def close_all() -> None:
    """Close what is open, the last first."""
    while _open:
        _open[-1].close()


@contextmanager
def timer(context: bpy.types.Context, interval_s: float) -> Iterator[None]:
    """The window's modal operators are called again and again while the block runs."""
    window_manager = context.window_manager
    ticking = window_manager.event_timer_add(interval_s, window=context.window)
    try:
        yield
    finally:
        window_manager.event_timer_remove(ticking)


@contextmanager
def status_text(context: bpy.types.Context, text: str) -> Iterator[None]:
    """The status bar says something while the block runs; the user may change to another workspace meanwhile."""
    name = context.workspace.name
    context.workspace.status_text_set(text)
    try:
        yield
    finally:
        workspace = bpy.data.workspaces.get(name)
        if workspace is not None:
            workspace.status_text_set(None)

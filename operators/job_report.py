"""What a job did, kept until the next one of its kind: Blender's own reports are gone from the status bar after seconds."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..spectral_probe.render.pace import in_words


def keep_report(
    operator: str,
    label: str,
    *,
    finished: bool,
    seconds: float,
    lines: Sequence[tuple[str, str]],
    longest_step_s: float = 0.0,
) -> None:
    """Keep what an operator's job told, pairs of kind ("INFO", "WARNING", "ERROR") and text, in place of its last report.

    It opens where there is something to be warned of, and the others close: they were read.
    """
    reports = bpy.context.window_manager.spectral_probe_reports
    kept = reports.get(operator) or reports.add()
    kept.name = operator
    text = rpt_("{job}: done in {time}") if finished else rpt_("{job}: ended after {time}")
    kept.title = text.format(job=label, time=in_words(seconds))
    text = rpt_("Done in {time}") if finished else rpt_("Ended after {time}")
    kept.outcome = text.format(time=in_words(seconds))
    kept.finished = finished
    kept.longest_step_s = longest_step_s
    kept.lines.clear()
    for kind, text in lines:
        line = kept.lines.add()
        line.kind, line.text = kind, text
    for other in reports:
        other.opened = other.opened and other == kept
    kept.opened = kept.opened or any(kind != "INFO" for kind, _ in lines)


def forget_reports() -> None:
    """Forget what jobs told: another file is open now."""
    bpy.context.window_manager.spectral_probe_reports.clear()


def report_text(operator: str) -> str:
    """The last report of an operator's job as lines of text; empty without one."""
    kept = bpy.context.window_manager.spectral_probe_reports.get(operator)
    return "" if kept is None else "\n".join([kept.title, *(line.text for line in kept.lines)])

"""The verbs `render-pass` and `combine`: a frame rendered in parts by several processes, and put together by another."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..spectral_probe.errors import RenderError, SpectralProbeError
from ..spectral_probe.model import Job, Progress, part
from .command_line import open_scene, planner_of

if TYPE_CHECKING:
    from ..spectral_probe.render.outputs import OutputSettings

type Numbers = dict[str, Any]

_FAILURES_TOLD = 3
_LONGEST_WAIT_S = 30.0


def render_pass(arguments: argparse.Namespace) -> Job[Numbers]:
    """Render a share of a frame's passes into its folder; returns what was done."""
    from ..spectral_probe.cli_output import output_settings_of
    from ..spectral_probe.cli_render import render_words
    from ..spectral_probe.files.atomic import check_folder
    from ..spectral_probe.files.probe_exr import read_probe
    from ..spectral_probe.render.share import frame_folder
    from .bridge.beginning import FrameWords
    from .bridge.file_digest import opened_files_digest
    from .bridge.frames import frame_restored
    from .bridge.pass_task import render_passes

    directory = frame_folder(arguments.output.resolve(), arguments.frame)
    check_folder(directory)
    outputs = output_settings_of(arguments)
    probe = None if arguments.world else read_probe(arguments.probe)
    yield Progress(0.0, f"Opening {arguments.scene.name}")
    scene = open_scene(arguments.scene)
    words = FrameWords(
        not arguments.no_rgb,
        outputs,
        "restart" if arguments.restart else "resume" if arguments.resume else "refuse",
        tuple(render_words(arguments)),
        opened_files_digest(),
    )
    with frame_restored(scene):
        scene.frame_set(arguments.frame)
        planner = planner_of(scene, probe, arguments)
        done = yield from render_passes(scene, planner, directory, arguments.which, words)
    finished = [name for name in done.asked if name not in done.rendered]
    numbers: Numbers = {
        "frame": arguments.frame,
        "passes_of_frame": done.count,
        "rendered": list(done.rendered),
        "finished_before": finished,
        "seconds": done.seconds,
        "warnings": list(done.warnings),
        "written": str(directory),
    }
    if not done.asked:
        numbers["note"] = f"Nothing to do: all {done.count} passes of the frame are in other shares."
    return numbers


def combine(arguments: argparse.Namespace) -> Job[Numbers]:
    """Put the passes of frames together; all frames are tried, and those that failed are told at the end.

    Raises
    ------
    RenderError
        If a frame was not put together.
    """
    from ..spectral_probe.cli_frames import frames_to_combine
    from ..spectral_probe.cli_output import output_settings_of

    folders = [folder.resolve() for folder in frames_to_combine(arguments)]
    asked = output_settings_of(arguments)
    reports: list[Numbers] = []
    failures: list[SpectralProbeError] = []
    for number, folder in enumerate(folders):
        job = _combined(folder, asked)
        try:
            reports.append((yield from part(job, number / len(folders), (number + 1) / len(folders))))
        except SpectralProbeError as problem:
            failures.append(problem)
    if failures:
        raise _told(failures, len(folders))
    if len(folders) == 1:
        return {**reports[0], "written": str(folders[0])}
    return {
        "frames": len(folders),
        "seconds": sum(report["seconds"]["spectral"] for report in reports),
        "warnings": list(dict.fromkeys(text for report in reports for text in report["warnings"])),
        "written": [str(folder) for folder in folders],
    }


def _combined(folder: Path, asked: OutputSettings) -> Job[Numbers]:
    """Put one frame together, and return its report."""
    from .bridge.combining import combine as combine_job
    from .bridge.locks import waited_lock
    from .bridge.render_report import REPORT_NAME

    with ExitStack() as stack:
        progress = Progress(0.0, "Reading the passes")
        yield from waited_lock(stack, progress, folder, wait_s=_LONGEST_WAIT_S)
        yield from combine_job(folder, asked=asked)
        report: Numbers = json.loads((folder / REPORT_NAME).read_text("utf-8"))
        return report


def _told(failures: Sequence[SpectralProbeError], count: int) -> RenderError:
    """What failed, in one line."""
    if count == 1:
        return RenderError(str(failures[0]))
    named = " ".join(str(problem) for problem in failures[:_FAILURES_TOLD])
    more = f" And {len(failures) - _FAILURES_TOLD} more." if len(failures) > _FAILURES_TOLD else ""
    return RenderError(f"{len(failures)} of {count} frames were not put together. {named}{more}")

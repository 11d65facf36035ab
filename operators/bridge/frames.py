"""Frames of an animation, rendered spectrally one after another, each into a folder of its own."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ...spectral_probe.errors import RenderError
from ...spectral_probe.model import Job, Progress, part
from ...spectral_probe.render.share import frame_folder
from .cycles import spectral_render
from .planning import Planner
from .render_report import SpectralRender
from .restore import is_gone


def render_frames(
    scene: bpy.types.Scene, planner: Planner, directory: Path, frames: Sequence[int], **words: Any
) -> Job[tuple[SpectralRender, ...]]:
    """Render frames of a scene spectrally; its frame is afterwards the one before.

    Parameters
    ----------
    scene
        The scene, as for `cycles.spectral_render`.
    planner
        Makes the plans: one for all frames, unless materials or lamps change.
    directory
        Where each frame gets a folder of its own, `render.share.frame_folder`. Finished passes of an interrupted render are kept.
    frames
        Which frames, in this order.
    words
        Further words of `spectral_render`: rgb_twin, outputs, on_change.
    """
    if not frames:
        raise RenderError("No frames were asked for. Give a range such as 1-24.")
    results = []
    with frame_restored(scene):
        for number, frame in enumerate(frames):
            yield Progress(number / len(frames), rpt_("Frame {frame}").format(frame=frame))
            scene.frame_set(frame)
            job = spectral_render(
                scene, planner.probe, None, frame_folder(directory, frame), samples=planner.samples,
                planner=planner, **words,
            )  # fmt: skip
            results.append(
                (yield from part(_named(job, frame), number / len(frames), (number + 1) / len(frames)))
            )
    return tuple(results)


@contextmanager
def frame_restored(scene: bpy.types.Scene) -> Iterator[None]:
    """The scene may show other frames while the block runs."""
    frame, subframe = scene.frame_current, scene.frame_subframe
    try:
        yield
    finally:
        if not is_gone(scene) and (scene.frame_current, scene.frame_subframe) != (frame, subframe):
            scene.frame_set(frame, subframe=subframe)


def _named[Result](job: Job[Result], frame: int) -> Job[Result]:
    """A job whose messages begin with the frame."""
    try:
        while True:
            try:
                progress = next(job)
            except StopIteration as stop:
                result: Result = stop.value
                return result
            yield replace(progress, message=f"Frame {frame}: {progress.message}")
    finally:
        job.close()

"""A frame's finished steps put together, without its scene: all that takes was kept when the frame was begun."""

import os
import shlex
import time
from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from ...spectral_probe.composite_model import OBJECTS_NAME
from ...spectral_probe.errors import RenderError
from ...spectral_probe.files.atomic import written_together
from ...spectral_probe.model import Job, Progress
from ...spectral_probe.render.frame_record import FrameRecord
from ...spectral_probe.render.frame_steps import TWIN_STEP, FrameStep, frame_steps
from ...spectral_probe.render.outputs import OutputSettings
from ...spectral_probe.render.pass_folder import (
    FinishedStep,
    PassFolder,
    look_again,
    matte_steps,
    read_pass,
    render_steps,
)
from ...spectral_probe.render.plan_file import load_plan
from ...spectral_probe.render.share import frame_folder
from ...spectral_probe.render_model import WORLD, PassPlan
from ...spectral_probe.work import worked
from .assembling import (
    PLAN_NAME,
    picture_names,
    told_where_not_written,
    write_objects_of,
    write_pictures,
    write_twin,
)
from .backplate import write_backplate
from .parts import of_without
from .render_report import REPORT_NAME, SpectralRender, blend_of_part, write_report
from .resuming import begun_folder

_NAMED = 6


def combine(
    directory: Path,
    *,
    asked: OutputSettings | None = None,
    checked: Collection[str] = (),
    kept: Sequence[int] | None = None,
) -> Job[SpectralRender]:
    """Put the finished steps of a frame together and write its files, report.json last; the folder's lock is the caller's.

    Parameters
    ----------
    directory
        The frame's folder.
    asked
        What is written, and how pictures are finished, where that is not as was said when the frame was begun.
    checked
        Full names of steps whose files this process has just written, or found undamaged: they are not read twice.
    kept
        How many passes of the frame, and of its part without virtual objects, were there before this run; None for all.

    Raises
    ------
    RenderError
        If the frame was not begun, or steps are missing or damaged.
    """
    whole = begun_folder(directory)
    if whole is None:
        raise RenderError(
            f"There is no frame in {directory}, or the index of its passes, or its plan, is damaged. Give the folder of a frame, "
            "such as render/frame_0001, or render it."
        )
    plan, record = load_plan(directory / PLAN_NAME), whole.record
    folders = [whole, of_without(whole)] if record.without else [whole]
    steps = frame_steps(plan, record.samples, without=record.without, rgb_twin=record.rgb_twin)
    progress = Progress(1.0 if checked else 0.0, "Reading the passes")
    yield progress
    missing = yield from worked(progress, partial(_missing, folders, steps, checked))
    if missing:
        raise RenderError(_missing_told(directory, record, missing, len(steps)))
    with told_where_not_written(directory):
        (directory / REPORT_NAME).unlink(missing_ok=True)  # until the frame is complete again
    outputs, result = record.outputs_for(asked), None
    for number, folder in reversed(list(enumerate(folders))):
        done = None if kept is None else kept[number]
        fraction = 1.0 if checked else 1.0 - 0.8 * (number + 1) / len(folders)
        told = Progress(fraction, "Putting the passes together")
        result = yield from _put_together(told, folder, plan, directory, outputs, done, result)
    if result is None:
        raise ValueError("a frame has at least one part")
    return result


def _missing(
    folders: list[PassFolder], steps: tuple[FrameStep, ...], checked: Collection[str]
) -> list[FrameStep]:
    """Steps that are not finished, or whose files are damaged."""
    for folder in folders:
        look_again(folder.directory)
    by_part = {"": folders[0], folders[-1].directory.parent.name: folders[-1]}
    unknown = (step for step in steps if step.full_name not in checked)
    return [step for step in unknown if not by_part[step.part].holds(step.name)]


def _missing_told(directory: Path, record: FrameRecord, missing: list[FrameStep], count: int) -> str:
    """Which steps are missing, and the command that renders them."""
    names = [step.full_name for step in missing]
    told = ", ".join(names[:_NAMED]) + (f" and {len(names) - _NAMED} more" if len(names) > _NAMED else "")
    are = "is" if len(names) == 1 else "are"
    sentence = f"{len(names)} of {count} passes {are} missing or damaged in {directory}: {told}."
    if not record.words:
        return f"{sentence} Render the scene again: finished passes are kept."
    blend = Path(os.path.normpath(directory / (record.blend or record.scene)))
    words = [str(blend) if blend.is_file() else blend.name, *record.words]
    if directory.name == frame_folder(directory.parent, record.frame).name:
        place = ["-o", str(directory.parent), "--frame", str(record.frame), "--pass", names[0]]
        command = shlex.join(["spectral-probe", "render-pass", *words, *place])
    else:
        command = shlex.join(["spectral-probe", "render", *words, "-o", str(directory)])
    return f"{sentence} Render it: {command}" if len(names) == 1 else f"{sentence} Render each: {command}"


def _put_together(
    progress: Progress,
    folder: PassFolder,
    plan: PassPlan,
    directory: Path,
    outputs: OutputSettings,
    kept: int | None,
    alone: SpectralRender | None,
) -> Job[SpectralRender]:
    """Write the files of a part: of the whole frame, where `alone` is its part without virtual objects, or of that."""
    part, record = folder.directory.parent, folder.record
    whole = part == directory
    outputs = replace(outputs, denoise=outputs.denoise and whole)  # no one looks at the other
    start = time.perf_counter()
    yield progress
    steps = render_steps(plan, record.samples)
    with written_together(part, last=REPORT_NAME, stale=picture_names(folder.view_layers)) as staging:
        if record.twin_level is not None:
            yield from write_twin(progress, folder, record.twin_level, outputs, staging)
        yield from write_pictures(progress, folder, plan, steps, outputs, staging)
        first = yield from worked(progress, partial(read_pass, folder.path(steps[0].name)))
        height, width = first.groups[WORLD].shape[:2]
        if whole:
            yield from write_objects_of(progress, folder, matte_steps(plan, steps), staging)
            write_backplate(record, (width, height), directory, staging)
        result = _result(folder, plan, directory, kept, alone, time.perf_counter() - start)
        blend = blend_of_part(record.blend, directory, part)
        write_report(result, replace(record, blend=blend), (width, height), staging)
    return result


def _result(
    folder: PassFolder,
    plan: PassPlan,
    directory: Path,
    kept: int | None,
    alone: SpectralRender | None,
    seconds_assembly: float,
) -> SpectralRender:
    """What a part's files are, and what its steps took."""
    part, record = folder.directory.parent, folder.record
    whole, steps = part == directory, render_steps(plan, record.samples)
    entries = [_entry(folder, step.name) for step in steps]
    twin = _entry(folder, TWIN_STEP) if record.rgb_twin else None
    all_entries = [*entries, *([] if twin is None else [twin])]
    told = [*record.warnings, *beyond(plan), *(text for entry in all_entries for text in entry.warnings)]
    return SpectralRender(
        xyz=part / "xyz.exr",
        image=part / "image.exr",
        rgb=None if twin is None else part / "rgb.exr",
        layers=folder.view_layers,
        passes=tuple(folder.path(step.name) for step in steps),
        plan=plan,
        samples=record.samples,
        seconds_spectral=sum(entry.seconds for entry in entries),
        seconds_rgb=None if twin is None else twin.seconds,
        seconds_assembly=seconds_assembly,
        steps_kept=len(steps) if kept is None else kept,
        device="; ".join(dict.fromkeys(entry.device for entry in all_entries if entry.device)),
        warnings=tuple(dict.fromkeys([*told, *(() if alone is None else alone.warnings)])),
        light_residual=record.light_residual,
        objects=part / OBJECTS_NAME if whole else None,
        without=alone,
        catchers=record.catchers if whole else (),
        virtual=record.virtual if whole else (),
    )


def _entry(folder: PassFolder, name: str) -> FinishedStep:
    """The manifest of a step that was there a moment ago."""
    entry = folder.finished(name)
    if entry is None:
        raise RenderError(f"{folder.path(name)} was removed meanwhile. Render the frame again.")
    return entry


def beyond(plan: PassPlan) -> list[str]:
    """The plan's own sentences that warn."""
    return [note for note in plan.notes if "not reached" in note]

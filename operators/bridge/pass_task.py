"""Some steps of one frame, as a process of a render farm renders them: the first to come begins the frame, others join it."""

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

import bpy

from ...spectral_probe.errors import FolderBusyError
from ...spectral_probe.model import Job, Progress
from ...spectral_probe.render.frame_steps import FrameStep, chosen_steps
from ...spectral_probe.render.light_file import LIGHT_FOLDER
from ...spectral_probe.render.pass_folder import PassFolder
from ...spectral_probe.render.share import Share
from .beginning import PLANNING, FrameWords, begin, joined
from .cycles import check_scene
from .locks import waited_lock
from .parts import Frame, of_without
from .planning import Planner
from .render_report import REPORT_NAME
from .resuming import SceneChangedError, begun_folder, changes_since, refuse_probe_folder, render_fingerprint
from .step_rendering import render_frame_steps

_LOOK_EVERY_S = 1.0
_LONGEST_PLANNING_S = 3600.0


@dataclass(frozen=True)
class PassesRendered:
    """What a process rendered of a frame: steps by name, those it was asked for and those that were not finished before.

    `count` is how many the frame has; `seconds` is what the steps asked for took, whoever rendered them.
    """

    directory: Path
    count: int
    asked: tuple[str, ...]
    rendered: tuple[str, ...]
    seconds: float
    warnings: tuple[str, ...]


def render_passes(
    scene: bpy.types.Scene, planner: Planner, directory: Path, which: Share | str, words: FrameWords
) -> Job[PassesRendered]:
    """Render some steps of a frame into its folder; the scene shows the frame, and comes back as it was.

    Parameters
    ----------
    scene
        The scene, at the frame.
    planner
        Makes the plan, if this process comes first.
    directory
        The frame's folder.
    which
        A share of the frame's list of steps, or the name of one.
    words
        What the render is told. `on_change` "restart" begins the frame anew only where it was begun from something else, so that
        all tasks of a job may say it.

    Raises
    ------
    RenderError
        If the scene cannot be rendered, or there is no such step; a `SceneChangedError` if the frame was begun from something
        else.
    """
    check_scene(scene, planner.samples, own_world=planner.probe is None)
    refuse_probe_folder(directory)
    yield Progress(0.0, PLANNING)
    fingerprint = render_fingerprint(scene, planner)
    frame = yield from _begun(scene, planner, directory, words, fingerprint)
    wanted = chosen_steps(frame.steps, which, str(directory))
    rendered = yield from render_frame_steps(frame, wanted)
    entries = [entry for step in wanted if (entry := frame.part_of(step).folder.finished(step.name))]
    told = [*frame.record.warnings, *(text for entry in entries for text in entry.warnings)]
    return PassesRendered(
        directory,
        len(frame.steps),
        _names(wanted),
        _names(rendered),
        sum(entry.seconds for entry in entries),
        tuple(dict.fromkeys(told)),
    )


def _names(steps: Sequence[FrameStep]) -> tuple[str, ...]:
    return tuple(step.full_name for step in steps)


def _begun(
    scene: bpy.types.Scene, planner: Planner, directory: Path, words: FrameWords, fingerprint: dict[str, str]
) -> Job[Frame]:
    """The frame, begun by whoever came first; who comes later waits until it is."""
    waited_s = 0.0
    while True:
        whole = _to_join(scene, directory, fingerprint, words)
        if whole is not None:
            return joined(scene, planner, whole)
        with ExitStack() as stack:
            try:
                yield from waited_lock(stack, Progress(0.0, PLANNING), directory, wait_s=_LOOK_EVERY_S)
            except FolderBusyError:
                waited_s += _LOOK_EVERY_S
                if waited_s > _LONGEST_PLANNING_S:
                    raise
                continue
            if _to_join(scene, directory, fingerprint, words) is None:
                before = begun_folder(directory)
                same = before is not None and not _changes(scene, before, fingerprint, words)
                told = (
                    replace(words, on_change="refuse") if same else words
                )  # only other outputs are asked for
                return (yield from begin(scene, planner, directory, told, directory.parent / LIGHT_FOLDER))


def _changes(
    scene: bpy.types.Scene, whole: PassFolder, fingerprint: dict[str, str], words: FrameWords
) -> tuple[str, ...]:
    return changes_since(whole, fingerprint, words.files, scene.frame_current)


def _to_join(
    scene: bpy.types.Scene, directory: Path, fingerprint: dict[str, str], words: FrameWords
) -> PassFolder | None:
    """The frame's passes where it was begun as asked for; None where it has to be begun.

    Raises
    ------
    SceneChangedError
        If it was begun from something else, is not complete, and `words.on_change` does not say what to do.
    """
    whole = begun_folder(directory)
    if whole is None or (whole.record.without and begun_folder(of_without(whole).directory.parent) is None):
        return None
    changes = [*_changes(scene, whole, fingerprint, words)]
    if (whole.record.outputs, whole.record.rgb_twin) != (words.outputs, words.rgb_twin):
        changes.append("outputs")
    if not changes or words.on_change == "resume":
        return whole
    if words.on_change == "restart" or (directory / REPORT_NAME).is_file():
        return None
    raise SceneChangedError(
        f"{directory} was begun otherwise: its {' and '.join(changes)} changed since then. Begin it anew (--restart), use its "
        "passes as they are (--resume), or choose another folder."
    )

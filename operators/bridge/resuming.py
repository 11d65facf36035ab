"""Whether an interrupted render can be gone on with: what its steps were made from, and what is asked for now."""

from collections.abc import Mapping
from pathlib import Path
from typing import Literal

import bpy

from ...spectral_probe.errors import FileFormatError, RenderError
from ...spectral_probe.render.pass_folder import PassFolder, digest_of, look_again, open_pass_folder
from ...spectral_probe.render.plan_file import load_plan
from .assembling import PLAN_NAME
from .fingerprint import light_fingerprint, scene_fingerprint
from .planning import Planner
from .render_report import REPORT_NAME

type OnChange = Literal["refuse", "restart", "resume"]


class SceneChangedError(RenderError):
    """An unfinished render in the folder was made from something else."""


def render_fingerprint(scene: bpy.types.Scene, planner: Planner) -> dict[str, str]:
    """What a render's steps are made from, a digest for each part."""
    return {
        "scene": scene_fingerprint(scene),
        "light": light_fingerprint(planner.probe),
        "samples": str(planner.samples),
        "plan": planner.digest(),
        "Blender": bpy.app.version_string,
    }


def refuse_probe_folder(directory: Path) -> None:
    """Refuse the folder of a probe, some of whose files have the names of a render's.

    Raises
    ------
    RenderError
        If it is one.
    """
    if (directory / "probe.exr").is_file():
        raise RenderError(
            f"{directory} is the folder of a probe, whose spectral.exr and report.json the render would replace. Choose another "
            "folder for the render."
        )


def begun_folder(directory: Path) -> PassFolder | None:
    """The passes of a frame that was begun and has its plan; None where there is none, or one of them is damaged."""
    look_again(directory / "passes")
    earlier = open_pass_folder(directory / "passes")
    plan = directory / PLAN_NAME
    try:
        load_plan(plan)
        return earlier if earlier is not None and digest_of(plan) == earlier.plan else None
    except (FileFormatError, OSError):
        return None


def changes_since(
    earlier: PassFolder, fingerprint: Mapping[str, str], files: str, frame: int
) -> tuple[str, ...]:
    """Parts of a fingerprint that have changed since a frame was begun.

    The scene has not where it was just opened from the same `files` (`file_digest.opened_files_digest`) at the same frame: what
    another machine's processor makes of them may differ in the last bits.
    """
    record = earlier.record
    same = files != "" and (files, frame) == (record.files, record.frame)
    return tuple(name for name in earlier.changes(fingerprint) if not (same and name == "scene"))


def folder_to_go_on(
    directory: Path, fingerprint: Mapping[str, str], on_change: OnChange, files: str, frame: int
) -> PassFolder | None:
    """The folder of an interrupted render of the same; None where the frame has to be begun anew.

    Raises
    ------
    SceneChangedError
        If it was a render of something else, and `on_change` does not say what to do.
    """
    earlier = begun_folder(directory)
    if earlier is None or on_change == "restart":
        return None
    changes = changes_since(earlier, fingerprint, files, frame)
    finished = len(earlier.finished_names())
    if not changes or (on_change == "resume" and finished):
        return earlier
    if finished and not (directory / REPORT_NAME).is_file():
        raise SceneChangedError(
            f"{directory} has {finished} passes of an unfinished render, and its {' and '.join(changes)} changed since then. "
            "Render anew (--restart), or use them as they are (--resume)."
        )
    return None


def unfinished_changes(scene: bpy.types.Scene, planner: Planner, directory: Path) -> tuple[str, ...]:
    """What has changed since an unfinished render in a folder began; nothing where there is none, or it can be gone on with."""
    earlier = open_pass_folder(directory / "passes")
    if earlier is None or not earlier.finished_names() or (directory / REPORT_NAME).is_file():
        return ()
    return earlier.changes(render_fingerprint(scene, planner))

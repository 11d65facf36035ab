"""Whether an interrupted render can be gone on with: what its steps were made from, and what is asked for now."""

from pathlib import Path
from typing import Literal

import bpy

from ...spectral_probe.errors import FileFormatError, RenderError
from ...spectral_probe.render.pass_folder import (
    PassFolder,
    new_pass_folder,
    open_pass_folder,
    remove_unfinished,
)
from ...spectral_probe.render.plan_file import load_plan
from .assembling import remove_pictures
from .fingerprint import light_fingerprint, scene_fingerprint
from .pass_settings import enabled_layers
from .planning import Planner
from .render_report import REPORT_NAME

type OnChange = Literal["refuse", "restart", "resume"]

PLAN_NAME = "plan.json"


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


def folder_of_steps(
    directory: Path, fingerprint: dict[str, str], scene: bpy.types.Scene, on_change: OnChange
) -> PassFolder:
    """The folder of the steps: as an interrupted render of the same left it, or a new one.

    Raises
    ------
    SceneChangedError
        If it was a render of something else, and `on_change` does not say what to do.
    RenderError
        If it is the folder of a probe, some of whose files have the names of a render's.
    """
    if (directory / "probe.exr").is_file():
        raise RenderError(
            f"{directory} is the folder of a probe, whose spectral.exr and report.json the render would replace. Choose another "
            "folder for the render."
        )
    earlier = open_pass_folder(directory / "passes")
    layers = [layer.name for layer in enabled_layers(scene)]
    remove_unfinished(directory)
    usable = earlier is not None and earlier.finished and _has_plan(directory)
    if earlier is not None and usable and on_change != "restart":
        changes = earlier.changes(fingerprint)
        if not changes or on_change == "resume":
            remove_pictures(directory, earlier.view_layers)
            return earlier
        if not (directory / REPORT_NAME).is_file():
            raise SceneChangedError(
                f"{directory} has {len(earlier.finished)} passes of an unfinished render, and its "
                f"{' and '.join(changes)} changed since then. Render anew (--restart), or use them as they are (--resume)."
            )
    for view_layers in (() if earlier is None else earlier.view_layers, layers):
        remove_pictures(directory, view_layers)
    return new_pass_folder(directory / "passes", fingerprint, layers)


def _has_plan(directory: Path) -> bool:
    """Whether the plan that the steps were rendered by is there, undamaged."""
    try:
        load_plan(directory / PLAN_NAME)
    except FileFormatError:
        return False
    return True


def unfinished_changes(scene: bpy.types.Scene, planner: Planner, directory: Path) -> tuple[str, ...]:
    """What has changed since an unfinished render in a folder began; nothing where there is none, or it can be gone on with."""
    earlier = open_pass_folder(directory / "passes")
    if earlier is None or not earlier.finished or (directory / REPORT_NAME).is_file():
        return ()
    return earlier.changes(render_fingerprint(scene, planner))

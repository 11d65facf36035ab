"""The parts of a scene's render: with its virtual objects, and, where catchers stand for real surfaces, without them.

Each part has a folder of its own, `composite_model.WITHOUT_NAME` in that of the whole, and is complete: plan, passes, pictures
and report. Both follow one plan, with the same samples and seed, so that their noise cancels where the objects change nothing.
"""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path

import bpy

from ...spectral_probe.composite_model import WITHOUT_NAME
from ...spectral_probe.render.pass_folder import INDEX_NAME, PassFolder, open_pass_folder, remove_unfinished
from .assembling import remove_pictures
from .catchers import Surfaces, without_virtual
from .resuming import PLAN_NAME, OnChange, folder_of_steps


@dataclass(frozen=True)
class Part:
    """A render of the scene with or without its virtual objects.

    `shown` makes the scene show what belongs to it while a block runs; `told` is what its messages end with; `kept` are the steps
    of an earlier run, and grow.
    """

    directory: Path
    folder: PassFolder
    shown: Callable[[], AbstractContextManager[None]] = nullcontext
    told: str = ""
    kept: list[str] = field(default_factory=list)


def parts_of(
    scene: bpy.types.Scene, directory: Path, fingerprint: dict[str, str], found: Surfaces, on_change: OnChange
) -> tuple[Part, ...]:
    """The parts, each as an interrupted render of the same left its folder, or new.

    Raises
    ------
    RenderError
        As `resuming.folder_of_steps`.
    """
    whole = Part(directory, folder_of_steps(directory, fingerprint, scene, on_change))
    alone = directory / WITHOUT_NAME
    if not (found.catchers and found.virtual):
        remove_part(alone)
        return (whole,)
    if not whole.folder.finished or not _same_plan(directory, alone):
        on_change = "restart"
    folder = folder_of_steps(alone, {**fingerprint, "part": WITHOUT_NAME}, scene, on_change)
    return whole, Part(alone, folder, without_virtual(found), " without the objects")


def _same_plan(directory: Path, alone: Path) -> bool:
    plans = [folder / PLAN_NAME for folder in (directory, alone)]
    return all(plan.is_file() for plan in plans) and plans[0].read_bytes() == plans[1].read_bytes()


def remove_part(alone: Path) -> None:
    """Remove the part without the objects that an earlier render left; files of others stay."""
    earlier = open_pass_folder(alone / "passes")
    if earlier is None:
        return
    remove_unfinished(alone)
    remove_pictures(alone, earlier.view_layers)
    (alone / PLAN_NAME).unlink(missing_ok=True)
    (alone / "passes" / INDEX_NAME).unlink()
    for name in earlier.finished:
        earlier.path(name).unlink(missing_ok=True)
    for folder in (alone / "passes", alone):
        if not any(folder.iterdir()):
            folder.rmdir()

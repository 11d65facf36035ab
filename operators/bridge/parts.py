"""The parts of a scene's render: with its virtual objects, and, where catchers stand for real surfaces, without them.

Each part has a folder of its own, `composite_model.WITHOUT_NAME` in that of the whole, and is complete: plan, passes, pictures
and report. Both follow one plan, with the same samples and seed, so that their noise cancels where the objects change nothing.
"""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path

import bpy

from ...spectral_probe.composite_model import WITHOUT_NAME
from ...spectral_probe.render.frame_record import FrameRecord
from ...spectral_probe.render.frame_steps import FrameStep, frame_steps
from ...spectral_probe.render.pass_folder import INDEX_NAME, PassFolder, open_pass_folder
from ...spectral_probe.render_model import PassPlan
from .assembling import PLAN_NAME, remove_pictures
from .catchers import Surfaces, without_virtual
from .planning import Planner


@dataclass(frozen=True)
class Part:
    """A render of the scene with or without its virtual objects.

    `name` is "" or `WITHOUT_NAME`; `shown` makes the scene show what belongs to it while a block runs; `told` is what its
    messages end with; `kept` are the passes that were finished before, and grow.
    """

    name: str
    directory: Path
    folder: PassFolder
    shown: Callable[[], AbstractContextManager[None]] = nullcontext
    told: str = ""
    kept: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Frame:
    """A frame that was begun, in the process that has its scene open.

    The first of the `parts` is the one with all objects; `found` are the surfaces of the scene, `planner` knows its light.
    """

    scene: bpy.types.Scene
    planner: Planner
    plan: PassPlan
    parts: tuple[Part, ...]
    found: Surfaces

    @property
    def directory(self) -> Path:
        """The frame's folder."""
        return self.parts[0].directory

    @property
    def record(self) -> FrameRecord:
        """What putting it together needs of the scene."""
        return self.parts[0].folder.record

    @property
    def samples(self) -> int:
        """Samples of a full pass."""
        return self.record.samples

    @property
    def steps(self) -> tuple[FrameStep, ...]:
        """All steps, in the order of the frame's list."""
        record = self.record
        return frame_steps(self.plan, self.samples, without=record.without, rgb_twin=record.rgb_twin)

    def part_of(self, step: FrameStep) -> Part:
        """The part that a step belongs to."""
        return next(part for part in self.parts if part.name == step.part)


def parts_of(folders: Sequence[PassFolder], found: Surfaces) -> tuple[Part, ...]:
    """The parts of the folders of their passes: that of the whole, and that without the virtual objects where it has one."""
    whole = Part("", folders[0].directory.parent, folders[0])
    if len(folders) == 1:
        return (whole,)
    alone = folders[1]
    return whole, Part(
        WITHOUT_NAME, alone.directory.parent, alone, without_virtual(found), " without the objects"
    )


def of_without(whole: PassFolder) -> PassFolder:
    """The folder of the passes of the part without virtual objects, by that of the whole."""
    return replace(
        whole,
        directory=whole.directory.parent / WITHOUT_NAME / whole.directory.name,
        fingerprint={**whole.fingerprint, "part": WITHOUT_NAME},
    )


def remove_part(alone: Path) -> None:
    """Remove the part without the objects that an earlier render left; files of others stay."""
    passes = alone / "passes"
    if not (passes / INDEX_NAME).is_file():
        return
    earlier = open_pass_folder(passes)
    remove_pictures(alone, () if earlier is None else earlier.view_layers)
    (alone / PLAN_NAME).unlink(missing_ok=True)
    (passes / INDEX_NAME).unlink()
    for file in [*passes.glob("*.exr"), *passes.glob("*.json")]:
        file.unlink()
    for folder in (passes, alone):
        if not any(folder.iterdir()):
            folder.rmdir()

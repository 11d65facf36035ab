"""What a render farm has to know of a scene: the steps of a frame, the files it reads, and what its machines need."""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import bpy

from ...spectral_probe.model import Job, Progress, part
from ...spectral_probe.render.frame_steps import FrameStep, frame_steps
from ...spectral_probe.render_model import PassPlan
from .beginning import making_plan
from .camera_backplate import rendered_size
from .catchers import surfaces
from .cycles import check_scene
from .file_digest import named_files
from .frames import frame_restored
from .planning import Planner

_MIB = 2**20
_BYTES_A_PIXEL = 400
"""Of the pictures that a task holds at once: 16 images of three floats in Cycles, and as many while they are put together."""

_GROWTH = 2
"""Cycles holds what Blender has opened once more, as it traces rays through it."""

_LEAST_MIB = 2048
_NAMED = 3


@dataclass(frozen=True)
class SceneNeeds:
    """What a scene needs on another machine: its files, memory, and whether it renders on a GPU; and what to mind."""

    files: tuple[Path, ...]
    memory_mib: int
    gpu: bool
    warnings: tuple[str, ...]


def first_frame(
    scene: bpy.types.Scene, planner: Planner, frame: int, *, rgb_twin: bool
) -> Job[tuple[PassPlan, tuple[FrameStep, ...]]]:
    """The plan of a frame and the list of its steps; the scene is checked as for a render and comes back as it was.

    Raises
    ------
    RenderError
        If the scene cannot be rendered.
    """
    with frame_restored(scene):
        yield Progress(0.1, "Planning the passes")
        scene.frame_set(frame)
        check_scene(scene, planner.samples, own_world=planner.probe is None)
        plan = yield from part(making_plan(scene, planner), 0.1, 0.9)
        found = surfaces(scene)
        without = bool(found.catchers and found.virtual)
        return plan, frame_steps(plan, planner.samples, without=without, rgb_twin=rgb_twin)


def scene_needs(scene: bpy.types.Scene) -> SceneNeeds:
    """What the open .blend, just planned, needs on another machine."""
    import psutil

    own = Path(bpy.data.filepath).resolve()
    files = sorted({path.resolve() for path in named_files() if os.path.isfile(path)} - {own})  # noqa: PTH113 - any text may be named
    width, height = rendered_size(scene)
    taken = psutil.Process().memory_info().rss
    memory_mib = max(_LEAST_MIB, (_GROWTH * taken + _BYTES_A_PIXEL * width * height) // _MIB)
    return SceneNeeds(tuple(files), int(memory_mib), scene.cycles.device == "GPU", tuple(_to_mind()))


def _to_mind() -> Iterator[str]:
    """What will not be found on another machine."""
    named = bpy.utils.blend_paths(absolute=True, packed=False, local=False)
    gone = sorted(
        {path for path in named if not Path(path).exists() and "<" not in path}
    )  # <UDIM> stands for tiles
    if gone:
        yield f"Files that the scene names are not there: {_listed(gone)}."
    absolute = sorted(
        {
            path
            for path in bpy.utils.blend_paths(absolute=False, packed=False, local=False)
            if not path.startswith("//")
        }
    )
    if absolute:
        yield (
            f"Files named by absolute paths are found only on machines that have them there: {_listed(absolute)}. "
            "File > External Data > Make Paths Relative."
        )


def _listed(names: list[str]) -> str:
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return ", ".join(names[:_NAMED]) + more

"""The spectral render: a frame begun, its steps rendered, and put together, with the scene as it was afterwards.

Every finished step is a file (`render.pass_folder`): a render that was stopped or killed goes on where it was, as long as
the scene, the light and the settings are those it began with (`fingerprint`). Steps of a frame can be rendered by processes of
their own (`pass_task`) and put together by another (`combining`): by the same code, so the result is the same.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...spectral_probe.errors import RenderError
from ...spectral_probe.files.lock import folder_lock
from ...spectral_probe.model import Job, SpectralPanorama, finish
from ...spectral_probe.render.outputs import OutputSettings
from ...spectral_probe.render_model import PassPlan
from .beginning import FrameWords, begin
from .beginning import making_plan as _making_plan
from .combining import combine
from .missing_files import check_textures
from .planning import DEFAULT_MAX_DE2000, Passes, Planner, PlanRequest
from .render_report import SpectralRender
from .resuming import OnChange
from .step_rendering import render_frame_steps

type Array = np.ndarray[Any, Any]

__all__ = ["SpectralRender", "check_scene", "making_plan", "planned", "spectral_render"]


def spectral_render(
    scene: bpy.types.Scene,
    probe: SpectralPanorama | None,
    plan: PassPlan | None,
    directory: Path,
    *,
    samples: int,
    passes: Passes = None,
    max_de2000: float = DEFAULT_MAX_DE2000,
    full_samples: bool = False,
    swappable: Mapping[str, Array] | None = None,
    lamps_swappable: bool = False,
    rgb_twin: bool = True,
    outputs: OutputSettings | None = None,
    on_change: OnChange = "refuse",
    planner: Planner | None = None,
    words: tuple[str, ...] = (),
    files: str = "",
) -> Job[SpectralRender]:
    """Render a scene in the spectral light of a panorama, or of its own world.

    Parameters
    ----------
    scene
        A Cycles scene with a camera. It comes back exactly as it was, whatever happens.
    probe
        The light. A world made by "Light the World" turns and scales it; without one it is used as it is. None lights
        the scene with its own world.
    plan
        The passes; None makes a plan for this scene and this light. A light-basis plan must have been made for the
        layers of this light.
    directory
        Where to write passes/, the files of `render.outputs`, rgb.exr, objects.exr, plan.json and report.json, and in without/
        the same of the scene without its virtual objects, where it has shadow catchers. Finished passes of a stopped render of
        the same scene in the same light are kept, and not rendered again.
    samples
        Samples per pixel of a full pass.
    passes
        Where `plan` is None: the number of light-basis passes, "all" for the 61-wavelength reference, or None (or 0) for
        what keeps the error bound: wavelengths fitted to the scene, or light layers where light is to be exchanged.
    max_de2000
        The bound on the largest colour error that the plan may predict.
    full_samples
        Give all passes the same samples: none is estimated as a ratio of another.
    swappable
        Masks (H, W) of the panorama's regions whose light is to be exchanged after rendering, by name.
    lamps_swappable
        The scene's measured lamps are to be exchanged after rendering, too.
    rgb_twin
        Also render the scene in plain RGB, lit by the same panorama in Rec.709.
    outputs
        What is written besides xyz.exr, image.exr and render.exr, and how pictures are finished.
    on_change
        What to do with passes of an unfinished render of something else: "refuse" raises, "restart" renders anew,
        "resume" takes them as they are, with their plan and samples.
    planner
        Makes the plan; frames of an animation share one. None makes one of the words above.
    words
        The command line's words that say the same, for messages.
    files
        `file_digest.opened_files_digest`, where the scene was just opened from its .blend.

    Yields
    ------
    Progress
        Before every Cycles render.

    Returns
    -------
    SpectralRender

    Raises
    ------
    RenderError
        If the scene cannot be rendered as asked; a `resuming.SceneChangedError` if `on_change` has to be decided.
    """
    check_scene(scene, samples, own_world=probe is None)
    directory = Path(directory)
    request = PlanRequest(passes, max_de2000, full_samples, swappable or {}, lamps_swappable)
    planner = planner or Planner(probe, request, samples)
    planner = replace(planner, given=plan or planner.given)
    told = FrameWords(rgb_twin, outputs or OutputSettings(), on_change, words, files)
    with folder_lock(directory):
        frame = yield from begin(scene, planner, directory, told)
        steps = frame.steps
        yield from render_frame_steps(frame, steps)
        return (
            yield from combine(
                directory,
                checked={step.full_name for step in steps},
                kept=tuple(len(part.kept) for part in frame.parts),
            )
        )


def planned(scene: bpy.types.Scene, planner: Planner) -> PassPlan:
    """The plan that `spectral_render` makes with a planner for a scene, at once."""
    return finish(making_plan(scene, planner))


def making_plan(scene: bpy.types.Scene, planner: Planner) -> Job[PassPlan]:
    """Make the plan that `spectral_render` makes with a planner for a scene, which comes back as it was."""
    check_scene(scene, planner.samples, own_world=planner.probe is None)
    return (yield from _making_plan(scene, planner))


def check_scene(scene: bpy.types.Scene, samples: int, *, own_world: bool = False) -> None:
    """Refuse a scene that cannot be rendered spectrally; `own_world` says that its world is the light.

    Raises
    ------
    RenderError
        If it is not rendered by Cycles, has no camera, or lacks the files of its textures.
    """
    if scene.render.engine != "CYCLES":
        raise RenderError(
            f'Scene "{scene.name}" does not render with Cycles. Set Render Engine to Cycles: no other engine knows '
            "the refractive index of metals."
        )
    if scene.camera is None:
        raise RenderError(f'Scene "{scene.name}" has no camera. Add one and make it the active camera.')
    if samples < 1:
        raise RenderError(f"{samples} samples were asked for; give at least 1.")
    check_textures(scene, own_world=own_world)

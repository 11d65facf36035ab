"""All steps of a frame in the order of its list, and the shares of it that single tasks render."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..composite_model import WITHOUT_NAME
from ..errors import RenderError
from ..render_model import PassPlan, RenderStep
from .pass_folder import render_steps
from .share import Share

TWIN_STEP = "rgb"
"""Name of the step that is the RGB twin."""


@dataclass(frozen=True)
class FrameStep:
    """A step of a part of a frame.

    Parameters
    ----------
    part
        "" for the scene with all its objects, `composite_model.WITHOUT_NAME` for that without the virtual ones.
    step
        The Cycles render of the plan; None for the RGB twin.
    """

    part: str
    step: RenderStep | None

    @property
    def name(self) -> str:
        """Of its file in the part's passes, without suffix."""
        return TWIN_STEP if self.step is None else self.step.name

    @property
    def full_name(self) -> str:
        """Among all steps of the frame, such as "without/pass_02"."""
        return f"{self.part}/{self.name}" if self.part else self.name


def frame_steps(plan: PassPlan, samples: int, *, without: bool, rgb_twin: bool) -> tuple[FrameStep, ...]:
    """The list of a frame's steps: the passes of its parts, then the RGB twin of each.

    Parameters
    ----------
    plan
        The frame's plan.
    samples
        Samples of a full pass.
    without
        Whether there is the part without virtual objects, too.
    rgb_twin
        Whether each part has its RGB twin.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from spectral_probe.render.plan import reference_plan
    >>> steps = frame_steps(reference_plan(), 8, without=True, rgb_twin=True)
    >>> [step.full_name for step in (steps[0], steps[21], *steps[-2:])]
    ['pass_00', 'without/pass_00', 'rgb', 'without/rgb']
    """
    parts = ("", WITHOUT_NAME) if without else ("",)
    passes = [FrameStep(part, step) for part in parts for step in render_steps(plan, samples)]
    return (*passes, *(FrameStep(part, None) for part in parts if rgb_twin))


def chosen_steps(
    steps: Sequence[FrameStep], which: Share | str, told: str = "The frame"
) -> tuple[FrameStep, ...]:
    """The steps of a share, or that of a name; `told` is what the list belongs to.

    Where there are as many shares as steps, each is one step; of more shares, those beyond the last step are empty.

    Raises
    ------
    RenderError
        If there is no step of that name.

    Examples
    --------
    >>> from spectral_probe.render.plan import reference_plan
    >>> steps = frame_steps(reference_plan(), 8, without=False, rgb_twin=True)
    >>> [len(chosen_steps(steps, Share(k, 4))) for k in (1, 2, 3, 4)]
    [5, 6, 5, 6]
    >>> [[step.name for step in chosen_steps(steps, Share(k, 30))] for k in (1, 22, 23)]
    [['pass_00'], ['rgb'], []]
    >>> [step.name for step in chosen_steps(steps, "pass_07")]
    ['pass_07']
    """
    count = len(steps)
    if isinstance(which, Share):
        if which.of >= count:
            return tuple(steps[which.number - 1 : which.number])
        return tuple(steps[(which.number - 1) * count // which.of : which.number * count // which.of])
    found = tuple(step for step in steps if step.full_name == which)
    if not found:
        names = ", ".join(step.full_name for step in steps)
        raise RenderError(f'{told} has no pass "{which}". It has {names}.')
    return found

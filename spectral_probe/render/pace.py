"""How far a spectral render is: what is told before each step, and the time left, from samples rendered a second."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..model import Progress
from ..render_model import PassPlan, RenderStep

_MINUTE_S, _HOUR_S = 60, 3600


@dataclass
class Pace:
    """Samples that have to be rendered, those that are there, and how long those of this run took.

    `total` and `done` count samples per pixel of all steps; `rendered` those of this run alone, in `seconds`.
    """

    total: int
    done: int = 0
    rendered: int = 0
    seconds: float = 0.0

    def skip(self, samples: int) -> None:
        """Count the samples of a step that an earlier run rendered."""
        self.done += samples

    def add(self, samples: int, seconds: float) -> None:
        """Count the samples of a step that was rendered now."""
        self.done += samples
        self.rendered += samples
        self.seconds += seconds

    def seconds_left(self) -> float | None:
        """Time that the other samples will take; None before any was rendered.

        Examples
        --------
        >>> pace = Pace(total=100)
        >>> pace.add(20, 5.0)
        >>> pace.seconds_left()
        20.0
        """
        if not self.rendered:
            return None
        return (self.total - self.done) * self.seconds / self.rendered

    def progress(self, message: str) -> Progress:
        """A message with the share of the samples that are there, and the time left."""
        left = self.seconds_left()
        told = "" if left is None else f", about {in_words(left)} left"
        return Progress(self.done / self.total, message + told)


def step_message(plan: PassPlan, steps: Sequence[RenderStep], number: int, full_samples: int) -> str:
    """What is rendered in a step, by its number in `steps`; `full_samples` are those of a full pass."""
    step = steps[number]
    named = ", ".join(f"{nm:g}" for nm in dict.fromkeys(plan.wavelengths_nm[step.pass_number]))
    return f"Pass {number + 1} of {len(steps)}: {named} nm, {step.samples} of {full_samples} samples"


def in_words(seconds: float) -> str:
    """A length of time as people say it.

    Examples
    --------
    >>> [in_words(s) for s in (0.4, 20, 90, 3601, 9000)]
    ['1 s', '20 s', '2 min', '1 h', '2 h 30 min']
    """
    if seconds < _MINUTE_S:
        return f"{max(1, round(seconds))} s"
    if seconds < _HOUR_S:
        return f"{round(seconds / _MINUTE_S)} min"
    hours, minutes = divmod(round(seconds / _MINUTE_S), 60)
    return f"{hours} h {minutes} min" if minutes else f"{hours} h"

"""A shot as a job: its parameters, and the command of each of its three stages.

Render is a task for every frame and share of its passes, Combine one for every frame, Compare one for all. A command is told
once, with the job's parameters in it (`Reference`): the bundle writes their names there, the list of commands their values.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Literal

type ParameterKind = Literal["STRING", "INT", "FLOAT", "INPUT_FILE", "OUTPUT_DIRECTORY"]

FRAME, PASS = "Frame", "Pass"
"""Names of the parameters of a task."""

COMPARISON_NAME = "comparison"
"""The folder in that of the renders that Compare writes to."""

_BLENDER = ("--background", "--command", "spectral_probe")


@dataclass(frozen=True)
class Reference:
    """A parameter within a word of a command: that of the job, or of the task."""

    name: str
    of_task: bool = False


type Word = str | tuple[str | Reference, ...]
"""A word of a command: plain text, or text and parameters one after another."""


@dataclass(frozen=True)
class Parameter:
    """A parameter of the job that whoever submits it may change.

    Parameters
    ----------
    name
        In the bundle, such as "Samples".
    kind
        What it is.
    value
        As text; of a path, absolute.
    description
        What whoever submits the job reads.
    """

    name: str
    kind: ParameterKind
    value: str
    description: str


@dataclass(frozen=True)
class Stage:
    """One stage of the job: the command of its tasks, and which task parameters there are.

    Parameters
    ----------
    name
        Of the step in the bundle.
    command
        The program and its words.
    tasks
        Names of the task parameters: `FRAME`, `PASS`.
    after
        The stage that must be done before; "" of the first.
    """

    name: str
    command: tuple[Word, ...]
    tasks: tuple[str, ...]
    after: str = ""


@dataclass(frozen=True)
class FarmJob:
    """What a farm is to render.

    Parameters
    ----------
    scene
        The .blend.
    probe
        The light; None is the scene's own world.
    frames
        Ascending, each once.
    shares
        Into how many shares each frame's passes are parted.
    output
        The folder of the frames.
    samples, max_de2000
        As the words of `render`.
    plan, swappable
        Files that words of `render` name: a plan, and regions by name.
    words
        Further words of `render`, without those above.
    rgb_twin
        Whether there is an RGB render to compare with.
    blender
        The program on the farm's machines.
    memory_mib, gpu
        What a task needs.
    files
        What the scene reads besides, absolute.
    """

    scene: Path
    probe: Path | None
    frames: tuple[int, ...]
    shares: int
    output: Path
    samples: int
    max_de2000: float
    plan: Path | None = None
    swappable: tuple[tuple[str, Path], ...] = ()
    words: tuple[str, ...] = ()
    rgb_twin: bool = True
    blender: str = "blender"
    memory_mib: int = 4096
    gpu: bool = False
    files: tuple[Path, ...] = ()

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Everything that may differ from one submission to another."""
        found = [Parameter("Scene", "INPUT_FILE", str(self.scene), "The scene, a .blend file")]
        if self.probe is not None:
            found.append(Parameter("Probe", "INPUT_FILE", str(self.probe), "The light, a probe.exr"))
        if self.plan is not None:
            found.append(
                Parameter("Plan", "INPUT_FILE", str(self.plan), "The plan of passes of an earlier render")
            )
        found += [
            Parameter(region_parameter(number), "INPUT_FILE", str(path), f"Region of the light {name}"[:200])
            for number, (name, path) in enumerate(self.swappable, start=1)
        ]
        return (
            *found,
            Parameter("Output", "OUTPUT_DIRECTORY", str(self.output), "The folder of the frames"),
            Parameter("Frames", "STRING", frame_range(self.frames), "Frames, such as 1-24 or 1,5,10-20:2"),
            Parameter("Samples", "INT", str(self.samples), "Samples a pixel, as of an RGB render"),
            Parameter(
                "ErrorBound",
                "FLOAT",
                repr(self.max_de2000),
                "Colour difference (dE2000) that 99 of 100 pixels are to keep",
            ),
            Parameter("Blender", "STRING", self.blender, "Blender on the farm's machines"),
        )

    @property
    def stages(self) -> tuple[Stage, ...]:
        """The stages in their order."""
        frame: Word = ("--frame=", Reference(FRAME, of_task=True))
        output: Word = (Reference("Output"),)
        render = Stage(
            "Render",
            (
                *_verb("render-pass"), (Reference("Scene"),), *self._light, "-o", output, frame,
                "--pass", (Reference(PASS, of_task=True), f"/{self.shares}"),
                "--samples", (Reference("Samples"),), "--max-de", (Reference("ErrorBound"),),
                *self._files_named, *self.words,
            ),
            (FRAME, PASS),
        )  # fmt: skip
        combine = Stage("Combine", (*_verb("combine"), output, frame), (FRAME,), "Render")
        if not self.rgb_twin:
            return render, combine
        words = (("--frames=", Reference("Frames")), "-o", (Reference("Output"), f"/{COMPARISON_NAME}"))
        return render, combine, Stage("Compare", (*_verb("compare"), output, *words), (), "Combine")

    @property
    def tasks(self) -> int:
        """How many tasks all stages have."""
        counts = {FRAME: len(self.frames), PASS: self.shares}
        return sum(prod(counts[name] for name in stage.tasks) for stage in self.stages)

    @property
    def _light(self) -> tuple[Word, ...]:
        return ("--world",) if self.probe is None else ("--probe", (Reference("Probe"),))

    @property
    def _files_named(self) -> tuple[Word, ...]:
        """The words that name files, each a parameter: a farm may have them elsewhere."""
        words: list[Word] = [] if self.plan is None else ["--plan", (Reference("Plan"),)]
        for number, (name, _) in enumerate(self.swappable, start=1):
            words += ["--swappable", (f"{name}=", Reference(region_parameter(number)))]
        return tuple(words)


def region_parameter(number: int) -> str:
    """Name of the parameter that is the file of a swappable region, counted from 1."""
    return f"Region{number}"


def frame_range(frames: Sequence[int]) -> str:
    """Ascending frames as both we and Open Job Description list them: ranges, with steps where they are even.

    Examples
    --------
    >>> frame_range([1, 2, 3, 10]), frame_range([1, 3, 5, 7]), frame_range([-3, -2, -1, 4])
    ('1-3,10', '1-7:2', '-3--1,4')
    """
    runs: list[list[int]] = []
    for frame in frames:
        run = runs[-1] if runs else []
        if run and (len(run) == 1 or frame - run[-1] == run[1] - run[0]):
            run.append(frame)
        else:
            runs.append([frame])
    return ",".join(_run_told(run) for run in runs)


def _run_told(run: Sequence[int]) -> str:
    step = run[1] - run[0] if len(run) > 1 else 1
    if len(run) == 1 or (len(run) == 2 and step > 1):
        return ",".join(map(str, run))
    return f"{run[0]}-{run[-1]}" + (f":{step}" if step > 1 else "")


def _verb(name: str) -> tuple[Word, ...]:
    return ((Reference("Blender"),), *_BLENDER, name)

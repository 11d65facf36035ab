"""A job as a plain list of shell commands, for schedulers without Open Job Description and for loops in a shell."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping
from itertools import product

from .job import FRAME, PASS, FarmJob, Reference, Stage, Word


def command_list(job: FarmJob) -> str:
    """The content of commands.txt: a command a line, quoted for a POSIX shell; comments part the stages.

    Examples
    --------
    >>> from pathlib import Path
    >>> job = FarmJob(Path("/a b.blend"), None, (1,), 2, Path("/out"), 8, 0.5, rgb_twin=False)
    >>> print(command_list(job).splitlines()[-1])
    blender --background --command spectral_probe combine /out --frame=1
    """
    values = {parameter.name: parameter.value for parameter in job.parameters}
    lines = []
    for stage in job.stages:
        after = f", when all of {stage.after} are done" if stage.after else ""
        commands = [
            shlex.join(_filled(word, given) for word in stage.command) for given in _tasks(job, stage, values)
        ]
        lines += [f"# {stage.name}: {len(commands)} commands in any order{after}", *commands]
    return "\n".join(lines) + "\n"


def _tasks(job: FarmJob, stage: Stage, values: Mapping[str, str]) -> Iterator[dict[str, str]]:
    """The values of all parameters in each task of a stage."""
    of_task = {FRAME: [str(frame) for frame in job.frames], PASS: [str(n + 1) for n in range(job.shares)]}
    for chosen in product(*(of_task[name] for name in stage.tasks)):
        yield {**values, **dict(zip(stage.tasks, chosen, strict=True))}


def _filled(word: Word, values: Mapping[str, str]) -> str:
    if isinstance(word, str):
        return word
    return "".join(values[part.name] if isinstance(part, Reference) else part for part in word)

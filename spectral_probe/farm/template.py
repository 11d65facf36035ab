"""A job in the words of Open Job Description, `jobtemplate-2023-09`, and its values and files as job bundles have them.

Open Job Description specifications, "2023-09 Template Schemas"; AWS Deadline Cloud, "Job bundles". Nothing but texts and numbers
is written; a value that holds two braces would be taken for a reference and is refused.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..errors import RenderError
from .job import FRAME, PASS, FarmJob, Parameter, Reference, Stage, Word

type Table = dict[str, Any]

OPENJD_WORD = "--openjd"
"""Of our verbs: progress and failures in the lines that the standard reads."""

_LONGEST_NAME = 128
_LONGEST_VALUE = 1024
_SECONDS_TO_END = 60
_LEAST_BOUND = 0.001

_CONTROLS: Mapping[str, Table] = {
    "INPUT_FILE": {"control": "CHOOSE_INPUT_FILE"},
    "OUTPUT_DIRECTORY": {"control": "CHOOSE_DIRECTORY"},
    "STRING": {"control": "LINE_EDIT"},
    "INT": {"control": "SPIN_BOX"},
    "FLOAT": {"control": "SPIN_BOX", "decimals": 2, "singleStepDelta": 0.1},
}
_FILES: Mapping[str, tuple[str, str]] = {
    "Scene": ("Blender scenes", "*.blend"),
    "Probe": ("Probes", "*.exr"),
    "Plan": ("Plans", "*.json"),
}


def job_template(job: FarmJob) -> Table:
    """The content of template.yaml.

    Raises
    ------
    RenderError
        If a name or word cannot be written in a template.
    """
    for parameter in job.parameters:
        _check_text(parameter.value, parameter.name)
    for stage in job.stages:
        for word in stage.command:
            for part in (word,) if isinstance(word, str) else word:
                if isinstance(part, str):
                    _check_text(part, stage.name)
    return {
        "specificationVersion": "jobtemplate-2023-09",
        "name": _job_name(job),
        "description": "Frames rendered spectrally in parts, put together, and compared with RGB",
        "parameterDefinitions": [_definition(parameter) for parameter in job.parameters],
        "steps": [_step(job, stage) for stage in job.stages],
    }


def parameter_values(job: FarmJob) -> Table:
    """The content of parameter_values.yaml."""
    return {"parameterValues": [{"name": one.name, "value": _typed(one)} for one in job.parameters]}


def asset_references(job: FarmJob) -> Table:
    """The content of asset_references.yaml: what the scene reads besides the files that are parameters."""
    return {
        "assetReferences": {
            "inputs": {"directories": [], "filenames": [str(path) for path in job.files]},
            "outputs": {"directories": [str(job.output)]},
            "referencedPaths": [],
        }
    }


def _job_name(job: FarmJob) -> str:
    """Short enough, and of characters that the standard allows."""
    stem = "".join(letter for letter in job.scene.stem if letter.isprintable()).replace("{{", "{").strip()
    return f"Spectral render of {stem}"[:_LONGEST_NAME].rstrip()


def _definition(parameter: Parameter) -> Table:
    """A parameter's definition; paths have no default, which would have to lie in the bundle."""
    kind, control = parameter.kind, dict(_CONTROLS[parameter.kind])
    table: Table = {"name": parameter.name, "type": "PATH", "description": parameter.description}
    if kind == "INPUT_FILE":
        table |= {"objectType": "FILE", "dataFlow": "IN"}
        if parameter.name in _FILES:
            label, pattern = _FILES[parameter.name]
            control["fileFilters"] = [{"label": label, "patterns": [pattern]}]
    elif kind == "OUTPUT_DIRECTORY":
        table |= {"objectType": "DIRECTORY", "dataFlow": "OUT"}
    else:
        table |= {"type": kind, "default": _typed(parameter)}
        if kind == "INT":
            table["minValue"] = 1
        elif kind == "FLOAT":
            table["minValue"] = min(_LEAST_BOUND, float(parameter.value))
    return table | {"userInterface": control}


def _typed(parameter: Parameter) -> str | int | float:
    if parameter.kind == "INT":
        return int(parameter.value)
    return float(parameter.value) if parameter.kind == "FLOAT" else parameter.value


def _step(job: FarmJob, stage: Stage) -> Table:
    program, *words = (_referring(word) for word in (*stage.command, OPENJD_WORD))
    step: Table = {"name": stage.name}
    if stage.after:
        step["dependencies"] = [{"dependsOn": stage.after}]
    if stage.tasks:
        ranges = {FRAME: "{{Param.Frames}}", PASS: f"1-{job.shares}"}
        step["parameterSpace"] = {
            "taskParameterDefinitions": [
                {"name": name, "type": "INT", "range": ranges[name]} for name in stage.tasks
            ],
        } | ({"combination": " * ".join(stage.tasks)} if len(stage.tasks) > 1 else {})
    on_run = {
        "command": program,
        "args": words,
        "cancelation": {"mode": "NOTIFY_THEN_TERMINATE", "notifyPeriodInSeconds": _SECONDS_TO_END},
    }
    return step | {"script": {"actions": {"onRun": on_run}}, "hostRequirements": _needs(job, stage)}


def _needs(job: FarmJob, stage: Stage) -> Table:
    """What a stage asks of a machine: only rendering passes needs a GPU."""
    amounts: list[Table] = [
        {"name": "amount.worker.vcpu", "min": 1},
        {"name": "amount.worker.memory", "min": job.memory_mib},
    ]
    if job.gpu and PASS in stage.tasks:
        amounts.append({"name": "amount.worker.gpu", "min": 1})
    systems = {"name": "attr.worker.os.family", "anyOf": ["linux", "windows", "macos"]}
    return {"amounts": amounts, "attributes": [systems]}


def _referring(word: Word) -> str:
    """A word with the names of parameters in it."""
    if isinstance(word, str):
        return word
    return "".join(part if isinstance(part, str) else _reference(part) for part in word)


def _reference(reference: Reference) -> str:
    return f"{{{{{'Task.Param' if reference.of_task else 'Param'}.{reference.name}}}}}"


def _check_text(text: str, name: str) -> None:
    if "{{" in text or "}}" in text:
        raise RenderError(
            f'{name} is "{text}": two braces are a reference in a job\'s template. Give it another name.'
        )
    if any(not letter.isprintable() for letter in text):
        raise RenderError(
            f"{name} has a character that cannot be written in a job: {text!r}. Give it another name."
        )
    if len(text) > _LONGEST_VALUE:
        remedy = "Part the frames among several jobs" if name == "Frames" else "Choose a shorter path"
        raise RenderError(f"{name} is longer than {_LONGEST_VALUE} characters. {remedy}.")

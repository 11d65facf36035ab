"""The folder of a job: template.yaml, parameter_values.yaml and asset_references.yaml, or commands.txt.

`openjd_values.yaml` is parameter_values.yaml as the standard's own program, `openjd run`, takes it.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from ..errors import RenderError
from ..files.atomic import check_folder, written_together
from ..files.lock import folder_lock
from .commands import command_list
from .job import FarmJob
from .template import asset_references, job_template, parameter_values

type BundleFormat = Literal["openjd", "commands"]

TEMPLATE_NAME = "template.yaml"
VALUES_NAME, ASSETS_NAME, PLAIN_VALUES_NAME = (
    "parameter_values.yaml",
    "asset_references.yaml",
    "openjd_values.yaml",
)
COMMANDS_NAME = "commands.txt"
_NAMES = (TEMPLATE_NAME, VALUES_NAME, ASSETS_NAME, PLAIN_VALUES_NAME, COMMANDS_NAME)


def check_bundle_folder(directory: Path) -> None:
    """Refuse a folder that cannot be written to, or that holds something else than a bundle.

    Raises
    ------
    FileFormatError
        If it cannot be written to.
    RenderError
        If it holds anything else.
    """
    check_folder(directory)
    others = sorted(
        path.name
        for path in (directory.iterdir() if directory.is_dir() else ())
        if path.name not in _NAMES and not path.name.startswith(".")
    )
    if others:
        raise RenderError(
            f"{directory} holds something else than a job ({others[0]}). Choose an empty folder for the job."
        )


def write_bundle(job: FarmJob, directory: Path, kind: BundleFormat = "openjd") -> tuple[Path, ...]:
    """Write a job into a folder, whole or not at all; that of an earlier job is replaced.

    Returns
    -------
    tuple of Path
        The files.

    Raises
    ------
    RenderError
        If the folder holds something else, or a name cannot be written in a job.
    FileFormatError
        If the folder cannot be written to.
    """
    check_bundle_folder(directory)
    texts = {COMMANDS_NAME: command_list(job)} if kind == "commands" else _openjd_texts(job)
    last = COMMANDS_NAME if kind == "commands" else TEMPLATE_NAME
    with folder_lock(directory), written_together(directory, last=last, stale=_NAMES) as folder:
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8")
    return tuple(directory / name for name in texts)


def _openjd_texts(job: FarmJob) -> dict[str, str]:
    values = parameter_values(job)
    plain = {one["name"]: one["value"] for one in values["parameterValues"]}
    return {
        VALUES_NAME: _yaml(values),
        ASSETS_NAME: _yaml(asset_references(job)),
        PLAIN_VALUES_NAME: _yaml(plain),
        TEMPLATE_NAME: _yaml(job_template(job)),
    }


def _yaml(table: Mapping[str, Any]) -> str:
    import yaml

    return yaml.safe_dump(dict(table), sort_keys=False, allow_unicode=True, width=10_000)

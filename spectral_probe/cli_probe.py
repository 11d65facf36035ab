"""The words of the verb `probe`, and what they start: one capture, or a batch of many."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .cli_numbers import whole_number
from .errors import PartlyFailedError
from .model import Job

type Numbers = dict[str, Any]

TEXT = "Photographs of a mirrored ball to a spectral panorama; many captures in parallel."
EXAMPLE = "probe CAPTURE.toml -o out"
FURTHER = """\
Several files or a folder make a batch: a folder for each probe within DIR, summary.csv and summary.json. What is done and
unchanged is skipped, so that a batch that was stopped goes on where it was:
         spectral-probe probe captures/ more/hall.toml -o probes --jobs 4"""


def add_words(parser: argparse.ArgumentParser) -> None:
    """Give the verb its words, but for the folder to write to."""
    parser.add_argument(
        "capture",
        type=Path,
        nargs="+",
        metavar="CAPTURE",
        help="capture files, and folders with such files; more than one file, or a folder, make a batch",
    )
    parser.add_argument(
        "--width", type=int, help="width of the panorama in pixels (default: as fine as the photographs)"
    )
    batch = parser.add_argument_group("a batch of captures")
    batch.add_argument(
        "--jobs",
        type=whole_number,
        metavar="N",
        help="captures at a time at most (default: as many as there are processors; memory may allow fewer)",
    )
    batch.add_argument("--restart", action="store_true", help="make all, also what is done and unchanged")


def run(arguments: argparse.Namespace) -> Job[Numbers]:
    """The job that the words ask for."""
    if len(arguments.capture) == 1 and not arguments.capture[0].is_dir():
        from . import commands

        return commands.probe(arguments.capture[0], arguments.output, arguments.width)
    return _batch(arguments)


def _batch(arguments: argparse.Namespace) -> Job[Numbers]:
    from .batch import probe_many

    job = probe_many(
        arguments.capture,
        arguments.output,
        arguments.width,
        jobs=arguments.jobs,
        restart=arguments.restart,
    )
    try:
        return _to_tell((yield from job), arguments)
    except PartlyFailedError as problem:
        raise PartlyFailedError(problem.failures, _to_tell(problem.numbers, arguments)) from None


def _to_tell(numbers: Mapping[str, Any], arguments: argparse.Namespace) -> Numbers:
    """Without the table where a person reads: it has a file of its own."""
    return {key: value for key, value in numbers.items() if arguments.json or key != "table"}

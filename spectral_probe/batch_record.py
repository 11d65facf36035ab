"""What a finished capture of a batch was made from, and what of: digests of files, so that it need not be made again.

The record lies in the probe's folder, batch.json. It holds for the program's version, the width that was asked for, and the
contents of the capture file, of all files that it names, and of the outputs.
"""

from __future__ import annotations

import hashlib
import json
import os
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from .batch_captures import files_of
from .files.atomic import written_whole
from .files.capture import load_capture
from .files.json_object import UNREADABLE, number, read_object, sentences, table, text, whole

RECORD_NAME = "batch.json"

OUTPUTS = (
    "probe.exr", "layers.exr", "world.exr", "spectral.exr", "preview.png", "confidence.png", "report.json",
)  # fmt: skip
"""What `probe.write_outputs` writes."""

_FORMAT = "spectral-probe-batch-1"


@dataclass(frozen=True)
class BatchRecord:
    """A finished capture.

    Parameters
    ----------
    capture
        The capture file.
    program
        Version of the program.
    width_px
        The width that was asked for; None for as fine as the photographs.
    inputs
        Digests of the capture file and of the files that it names, by their paths from its folder.
    outputs
        Digests of the files in the probe's folder, by name.
    numbers
        What the batch's table tells of it.
    """

    capture: str
    program: str
    width_px: int | None
    inputs: Mapping[str, str]
    outputs: Mapping[str, str]
    numbers: Mapping[str, Any] = field(default_factory=dict)


def read_record(folder: Path) -> BatchRecord | None:
    """The record of a probe's folder; None where there is none, or it is damaged."""
    try:
        content = read_object(folder / RECORD_NAME)
        if content["format"] != _FORMAT:
            return None
        width = content["width_px"]
        return BatchRecord(
            text(content["capture"]),
            text(content["program"]),
            None if width is None else whole(width),
            {name: text(digest) for name, digest in table(content["inputs"]).items()},
            {name: text(digest) for name, digest in table(content["outputs"]).items()},
            {name: _cell(value) for name, value in table(content["numbers"]).items()},
        )
    except UNREADABLE:
        return None


def _cell(value: Any) -> str | float | None:
    """What may stand in a cell of the batch's table."""
    if isinstance(value, str):
        return sentences([value])[0]
    return None if value is None else value if isinstance(value, int) else number(value)


def write_record(folder: Path, record: BatchRecord) -> None:
    """Write a record, whole or not at all."""
    with written_whole(folder / RECORD_NAME) as temporary:
        content = json.dumps({"format": _FORMAT, **asdict(record)}, indent=1)
        temporary.write_text(content + "\n", encoding="utf-8")


def unchanged(record: BatchRecord, capture: Path, width_px: int | None, folder: Path) -> bool:
    """Whether a capture would be made from the same, by the same program, and its outputs are as they were written."""
    return (
        record.program == program_version()
        and record.width_px == width_px
        and set(record.outputs) == set(OUTPUTS)
        and all((folder / name).is_file() for name in OUTPUTS)
        and record.inputs == input_digests(capture)
        and record.outputs == digests_of((folder / name for name in OUTPUTS), folder)
    )


def input_digests(capture: Path) -> dict[str, str]:
    """Digests of a capture file and of all files that it names, by their paths from its folder.

    Raises
    ------
    CaptureError
        If the capture cannot be read.
    """
    return digests_of([capture, *files_of(load_capture(capture))], capture.parent)


def digests_of(files: Iterable[Path], folder: Path) -> dict[str, str]:
    """BLAKE2b digests of files' contents, by their paths from a folder."""
    return {_from(folder, path): _digest(path) for path in files}


def owners(output: Path) -> dict[str, Path]:
    """Which capture files the folders of an earlier batch are of, by the folders' names; files that are gone own nothing."""
    records = {path.parent.name: read_record(path.parent) for path in sorted(output.glob(f"*/{RECORD_NAME}"))}
    known = {name: Path(record.capture) for name, record in records.items() if record is not None}
    return {name: capture for name, capture in known.items() if capture.is_file()}


def program_version() -> str:
    """Version of this program, as its manifest says."""
    try:
        manifest = Path(__file__).resolve().parents[1] / "blender_manifest.toml"
        return str(tomllib.loads(manifest.read_text(encoding="utf-8"))["version"])
    except (OSError, ValueError, KeyError):
        pass
    try:
        return version("spectral-probe")
    except PackageNotFoundError:
        return "unknown"


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, lambda: hashlib.blake2b(digest_size=16)).hexdigest()


def _from(folder: Path, path: Path) -> str:
    try:
        return Path(os.path.relpath(path, folder)).as_posix()
    except ValueError:  # on another drive
        return path.as_posix()

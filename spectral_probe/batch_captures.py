"""Which captures a batch has: files as they are named, folders searched for files that are captures by their content."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any

from .errors import CaptureError
from .files.spectrum_file import is_spectrum_file
from .model import Capture

_LARGEST_BYTES = 4_000_000
"""A file of text that is longer is no capture file."""

_PLAIN_NAMES = frozenset({"capture"})
"""Stems that say nothing; the folder's name stands for them."""

TAKEN = frozenset({"summary.csv", "summary.json"})
"""Names in a batch's folder that no capture may have."""


@dataclass(frozen=True)
class BatchCapture:
    """A capture of a batch: its file, and the folder within the batch's folder that its probe is written to."""

    path: Path
    folder: Path

    @property
    def name(self) -> str:
        """What it is called: its folder's name."""
        return self.folder.name


def find_captures(given: Sequence[Path], output: Path) -> list[Path]:
    """The capture files among files and folders, each once, in the order of their paths.

    A folder is searched with all folders in it, but for hidden ones, links, and `output`. A TOML file in it is a capture if it
    has a `[[view]]`; one that is no longer valid TOML and has such a line is one, too: it fails with the line to correct.

    Raises
    ------
    CaptureError
        If a file is not there, or no capture is in a folder.
    """
    found: dict[Path, None] = {}
    for path in given:
        if path.is_dir():
            inside = [file for file in _toml_files(path, output.resolve()) if _is_capture(file)]
            if not inside:
                raise CaptureError(
                    f"{path} has no capture file: no .toml with a [[view]]. Give another folder, or the files."
                )
            found |= dict.fromkeys(file.resolve() for file in inside)
        elif path.is_file():
            found[path.resolve()] = None
        else:
            raise CaptureError(f"There is no capture file at {path}. Check the path.")
    return sorted(found)


def named(paths: Sequence[Path], output: Path, owners: Mapping[str, Path]) -> list[BatchCapture]:
    """Captures with the folders of their probes.

    A capture is called as its file, or as its folder where the file is "capture.toml"; where that is taken, the folder's name
    goes before it, and then numbers follow. One that has a folder from an earlier batch keeps it, whatever came after it.

    Parameters
    ----------
    paths
        Capture files, sorted.
    output
        The folder of the batch.
    owners
        Names in it that captures have, with the capture files that they are of.

    Examples
    --------
    >>> captures = [Path("/a/ball.toml"), Path("/b/ball.toml"), Path("/gym/capture.toml")]
    >>> [capture.name for capture in named(captures, Path("/out"), {})]
    ['ball', 'b_ball', 'gym']
    >>> [capture.name for capture in named(captures, Path("/out"), {"ball": Path("/b/ball.toml")})]
    ['a_ball', 'ball', 'gym']
    """
    kept = {path: name for name, path in owners.items()}
    taken = {name.casefold() for name in (*owners, *TAKEN)}
    folders = []
    for path in paths:
        name = kept.get(path)
        if name is None:
            name = next(name for name in _names(path) if name.casefold() not in taken)
            taken.add(name.casefold())
        folders.append(BatchCapture(path, output / name))
    return folders


def files_of(capture: Capture) -> list[Path]:
    """The files that a capture names and its probe depends on, in the order of their paths."""
    found: set[Path] = set()
    for value in _values(capture):
        path = Path(value) if isinstance(value, Path) or is_spectrum_file(value) else None
        if path is not None and path.is_dir():  # one of the files in it has the camera's curves
            found |= {file for file in path.iterdir() if file.is_file()}
        elif path is not None and path.is_file():
            found.add(path)
    return sorted(found)


def _names(path: Path) -> Iterator[str]:
    folder = path.parent.name or "capture"
    stem = folder if path.stem.casefold() in _PLAIN_NAMES else path.stem
    yield stem
    above = path.parent.parent.name if stem == folder else folder
    longer = f"{above}_{stem}" if above else stem
    yield longer
    number = 2
    while True:
        yield f"{longer}_{number}"
        number += 1


def _toml_files(folder: Path, output: Path) -> Iterator[Path]:
    for place, folders, files in os.walk(folder):
        folders[:] = [
            name for name in folders if not name.startswith(".") and (Path(place) / name).resolve() != output
        ]
        for name in files:
            if name.lower().endswith(".toml") and not name.startswith("."):
                yield Path(place) / name


def _is_capture(path: Path) -> bool:
    try:
        if path.stat().st_size > _LARGEST_BYTES:
            return False
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return False
    try:
        views = tomllib.loads(text).get("view")
    except (ValueError, RecursionError):
        return any(line.strip().startswith("[[view]]") for line in text.splitlines())
    return isinstance(views, list) and any(isinstance(view, dict) and "photos" in view for view in views)


def _values(thing: Any) -> Iterator[str | Path]:
    """Texts and paths anywhere in the settings."""
    if isinstance(thing, str | Path):
        yield thing
    elif is_dataclass(thing):
        for field in fields(thing):
            yield from _values(getattr(thing, field.name))
    elif isinstance(thing, tuple | list):
        for item in thing:
            yield from _values(item)

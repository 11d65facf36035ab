"""Files that were moved, found again by their names in a folder and all that is in it."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from ..errors import FileFormatError
from ..model import Job, Progress

_FOLDERS_A_STEP = 200
"""Folders that are looked through between two steps of the job."""


def find_files(folder: Path, wanted: Iterable[str]) -> Job[dict[str, Path]]:
    r"""Look for files by name in a folder and below it.

    Of several files of one name it is the one whose folders are called most like those it had, then the one that lies
    highest. Links to folders are not followed.

    Parameters
    ----------
    folder
        Where to look.
    wanted
        The paths that the files had, of whatever system.

    Yields
    ------
    Progress

    Returns
    -------
    dict
        Where each was found; what was not found is left out.

    Raises
    ------
    FileFormatError
        If there is no such folder.

    Examples
    --------
    >>> import tempfile
    >>> from spectral_probe.model import finish
    >>> folder = Path(tempfile.mkdtemp())
    >>> (folder / "shots").mkdir()
    >>> (folder / "shots" / "v0.dng").touch()
    >>> found = finish(find_files(folder, ["D:\\gym\\shots\\v0.dng", "/gym/v1.dng"]))
    >>> [new.relative_to(folder).as_posix() for new in found.values()]
    ['shots/v0.dng']
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise FileFormatError(
            f"{folder} is no folder. Choose the one that the files are in, or one above it."
        )
    parts = {old: _parts(old) for old in wanted}
    candidates: dict[str, list[Path]] = {names[-1]: [] for names in parts.values() if names}
    for count, (place, _, files) in enumerate(os.walk(folder)):
        if count % _FOLDERS_A_STEP == 0:
            yield Progress(0.0, f"Looking in {place}")
        for name in candidates.keys() & files:
            candidates[name].append(Path(place) / name)
    return best_of(parts, candidates)


def best_of(parts: Mapping[str, tuple[str, ...]], candidates: Mapping[str, list[Path]]) -> dict[str, Path]:
    """The likeliest candidate of each old path, given as the parts of its name."""
    found = {}
    for old, names in parts.items():
        if names and (there := candidates[names[-1]]):
            found[old] = min(there, key=lambda path: (-_alike(names, path.parts), len(path.parts), path))
    return found


def _parts(path: str) -> tuple[str, ...]:
    return tuple(part for part in re.split(r"[\\/]+", path) if part)


def _alike(one: tuple[str, ...], other: tuple[str, ...]) -> int:
    """How many names two paths share, from their ends."""
    pairs = zip(reversed(one), reversed(other), strict=False)
    return next((count for count, (a, b) in enumerate(pairs) if a != b), min(len(one), len(other)))

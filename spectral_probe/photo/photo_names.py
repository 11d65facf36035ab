"""What the name of a photograph's file says: its number, and the view it was taken from where it names one."""

from __future__ import annotations

import re
from pathlib import Path

_DIGITS = re.compile(r"(\d+)")
_VIEW_WORDS = "view|v|position|pos|angle|camera|cam|side|station|stand|azimuth|az|direction|dir|bearing"
_VIEW = re.compile(rf"(?:^|(?<=[^a-z]))({_VIEW_WORDS})[ _-]*(\d{{1,3}})(?!\d)")
_LAST_NUMBER = re.compile(r"(\d+)\D*$")

_COUNTER_DIGITS = 4
"""Cameras count with at least so many digits (DSC01234, IMG_0012); people with fewer."""


def natural_key(path: Path) -> tuple[tuple[int, int, str], ...]:
    """Sort key that puts 2 before 10, and folders together.

    Examples
    --------
    >>> [path.name for path in sorted(map(Path, ("t80.jpg", "t1000.jpg", "t320.jpg")), key=natural_key)]
    ['t80.jpg', 't320.jpg', 't1000.jpg']
    """
    parts = _DIGITS.split(f"{path.parent.as_posix()}/{path.stem}{path.suffix}".casefold())
    return tuple((0, int(part), "") if part.isdigit() else (1, 0, part) for part in parts)


def view_label(path: Path) -> str | None:
    """The view that a name states by a word and a number; None where it does not.

    Examples
    --------
    >>> [view_label(Path(name)) for name in ("view0_1.dng", "v0-2.jpg", "Gym pos 12 dark.tif", "IMG_0012.jpg", "DSCV0012.jpg")]
    ['view 0', 'v 0', 'gym pos 12', None, None]
    """
    stem = path.stem.casefold()
    found = _VIEW.search(stem)
    if found is None:
        return None
    before = _DIGITS.sub("#", stem[: found.start()])
    return f"{before}{found[1]} {int(found[2])}"


def series_label(path: Path) -> str:
    """What the names of one series have in common: all before the last number, the camera's own counters left out.

    Examples
    --------
    >>> [series_label(Path(name)) for name in ("Ball40.jpg", "set1_3.jpg", "IMG_0012-2.jpg", "left.jpg")]
    ['ball', 'set1', 'img_#', '']
    """
    stem = path.stem.casefold()
    found = _LAST_NUMBER.search(stem)
    if found is None:
        return ""
    before = stem[: found.start()].rstrip(" _-.")
    return _DIGITS.sub(lambda number: number[1] if len(number[1]) < 3 else "#", before)


def counter(path: Path) -> int | None:
    """The camera's own count in the name, or None where the number is not one.

    Examples
    --------
    >>> [counter(Path(name)) for name in ("IMG_0012.CR3", "DSC01234.ARW", "t80.jpg", "view0_1.dng")]
    [12, 1234, None, None]
    """
    found = _LAST_NUMBER.search(path.stem)
    return int(found[1]) if found is not None and len(found[1]) >= _COUNTER_DIGITS else None

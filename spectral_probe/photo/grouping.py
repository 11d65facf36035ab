"""Which photographs are one bracket, and where the next view begins: told by what their files say of how they were taken.

Photographs of one view share folder, kind, camera, lens, focal length, aperture and size. Among those, in the order they were
taken, a new view begins where an exposure comes again, or after a pause. Where the files say no exposure, names and brightness
decide. Every photograph ends up in exactly one view, except a converted picture whose raw file is there too (`beside_raw`).
"""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median, multimode
from typing import Literal

from .metadata import PhotoRecord
from .photo_names import counter, natural_key, series_label, view_label

type Hint = Literal["one photograph", "uneven", "no exposure", "same moment"]

SAME_EXPOSURE_EV = 0.1
"""Exposures closer than this are the same: shutter speeds are rounded in EXIF by less (1/125 stands for 1/128)."""

LEAST_RANGE_EV = 0.9
"""A bracket covers at least so much; photographs that differ by less were metered anew, each in its own view."""

LEAST_BRIGHTNESS_RATIO = 1.4
"""The same for the mean of stored values: sRGB makes 1.37 of one exposure step."""

LONGEST_PAUSE_S = 120.0
"""Nobody takes longer from one exposure of a bracket to the next, the exposure itself not counted."""

_PAUSES = 6.0
"""A pause so many times the usual one ends a bracket: whoever releases a burst then walks to the next place."""

_SHORTEST_PAUSE_S = 6.0
_PAUSE_COUNT = 3
"""Missing numbers in the camera's count, where there are no dates: more than so many times the usual step, and than so many."""

_MOST_EXPOSURES = 30
"""In a bracket: a bound on the search."""

_SAME_SIZE = 0.05
"""Relative difference of sides cut by hand."""


@dataclass(frozen=True)
class ViewGroup:
    """Photographs of one view, in the order they were taken, and what should be said of them."""

    photos: tuple[PhotoRecord, ...]
    hints: tuple[Hint, ...] = ()


@dataclass(frozen=True)
class Grouping:
    """All views, in the order they were taken, single photographs among brackets last: they may show no ball.

    `beside_raw` are converted pictures whose raw files are in a view.
    """

    views: tuple[ViewGroup, ...]
    beside_raw: tuple[PhotoRecord, ...] = ()
    cameras: tuple[str, ...] = ()
    """The cameras that took them, where their files name them."""


def group_photographs(records: Iterable[PhotoRecord]) -> Grouping:
    """Sort photographs into views.

    Parameters
    ----------
    records
        The photographs in any order; one that comes twice counts once.

    Examples
    --------
    >>> from ..model import Exposure
    >>> taken = [(f"IMG_{i:04}.DNG", 10.0 * i, (0.01, 0.1)[i % 2]) for i in range(4)]
    >>> grouping = group_photographs(PhotoRecord(Path(name), "raw", taken_s=at, exposure=Exposure(s)) for name, at, s in taken)
    >>> [[photo.name for photo in view.photos] for view in grouping.views]
    [['IMG_0000.DNG', 'IMG_0001.DNG'], ['IMG_0002.DNG', 'IMG_0003.DNG']]
    """
    once = {record.path: record for record in records}
    developed = {record.path.with_suffix("") for record in once.values() if record.encoding == "raw"}
    kept: list[PhotoRecord] = []
    beside_raw: list[PhotoRecord] = []
    for record in once.values():
        copy = record.encoding == "converted" and record.path.with_suffix("") in developed
        (beside_raw if copy else kept).append(record)
    labels = _view_labels(kept)
    brackets = [
        bracket
        for alike in _alike(kept, labels)
        for bracket in _brackets(alike, named=alike[0].path in labels)
    ]
    brackets.sort(key=lambda bracket: _order(bracket[0], by_time=all(p.taken_s is not None for p in kept)))
    return Grouping(
        _with_hints(brackets),
        tuple(sorted(beside_raw, key=lambda record: natural_key(record.path))),
        tuple(sorted({record.camera for record in kept if record.camera})),
    )


def _order(record: PhotoRecord, *, by_time: bool) -> tuple[float, object]:
    return (record.taken_s or 0.0) if by_time else 0.0, natural_key(record.path)


# ---------------------------------------------------------------- what can be one bracket at all


def _view_labels(records: Sequence[PhotoRecord]) -> dict[Path, str]:
    """The views that names state, in folders where they tell more than one apart (`_v2` may be a version of all)."""
    labels = {record.path: label for record in records if (label := view_label(record.path)) is not None}
    several = defaultdict(set)
    for path, label in labels.items():
        several[path.parent].add(label)
    return {path: label for path, label in labels.items() if len(several[path.parent]) > 1}


def _alike(records: Sequence[PhotoRecord], labels: Mapping[Path, str]) -> list[list[PhotoRecord]]:
    """Photographs that could be of one view, by what does not change within a bracket."""
    classes = defaultdict(list)
    for record in records:
        focal_mm, f_number = record.focal_mm, record.f_number
        key = (
            record.path.parent,
            record.encoding,
            record.camera,
            record.lens,
            None if focal_mm is None else round(focal_mm, 1),
            None if f_number is None else round(f_number, 1),
            record.exposure is None,
            labels.get(record.path),
        )
        classes[key].append(record)
    return [part for alike in classes.values() for part in _of_one_size(alike)]


def _of_one_size(records: Sequence[PhotoRecord]) -> list[list[PhotoRecord]]:
    """Parts of nearly equal size: those cut by hand differ by some pixels, those turned or scaled by far more."""
    parts: list[list[PhotoRecord]] = []
    for record in sorted(records, key=lambda record: record.size_px or (0, 0)):
        part = next((part for part in parts if _same_size(part[0].size_px, record.size_px)), None)
        if part is None:
            parts.append([record])
        else:
            part.append(record)
    return parts


def _same_size(one: tuple[int, int] | None, other: tuple[int, int] | None) -> bool:
    if one is None or other is None:
        return one is other
    return all(abs(a - b) <= _SAME_SIZE * max(a, b) for a, b in zip(one, other, strict=True))


# ---------------------------------------------------------------- where the next bracket begins


def _brackets(alike: Sequence[PhotoRecord], *, named: bool) -> list[list[PhotoRecord]]:
    """Split photographs that could be one bracket into those that are; not where their names say that they are one view."""
    if alike[0].exposure is None:
        return _unstated(sorted(alike, key=lambda record: natural_key(record.path)), named=named)
    by_time = all(record.taken_s is not None for record in alike)
    shots = sorted(alike, key=lambda record: _order(record, by_time=by_time))
    if named:
        return [shots]
    brackets: list[list[PhotoRecord]] = []
    for bracket in _split(shots):
        brackets += [bracket] if _range_ev(bracket) >= LEAST_RANGE_EV else [[shot] for shot in bracket]
    return brackets


def _unstated(shots: Sequence[PhotoRecord], *, named: bool) -> list[list[PhotoRecord]]:
    """Photographs whose files say no exposure: a view where the name says so; else series, if their brightness differs."""
    if named:
        return [list(shots)]
    series = defaultdict(list)
    for shot in shots:
        series[series_label(shot.path)].append(shot)
    brackets: list[list[PhotoRecord]] = []
    for photos in series.values():
        known = [photo.brightness for photo in photos if photo.brightness is not None]
        flat = bool(known) and max(known) < LEAST_BRIGHTNESS_RATIO * min(known)
        merged = photos[0].encoding == "radiance"  # one file holds all exposures already
        brackets += [[photo] for photo in photos] if flat or merged else [photos]
    return brackets


def _split(shots: Sequence[PhotoRecord]) -> list[list[PhotoRecord]]:
    """The fewest brackets without an exposure that comes again; of several ways, the one that cuts at the longest pauses.

    Shortest path over the places to cut: `best[end]` holds the number of brackets of the first `end` photographs, the negated
    sum of the pauses at their cuts (a row that clearly begins anew counts as the longest), and where the last one begins.
    """
    values = [_ev(shot) for shot in shots]
    pauses, limit = _pauses(shots)
    best: list[tuple[int, float, int]] = [(0, 0.0, 0)]
    for end in range(1, len(shots) + 1):
        ways = []
        for start in range(end - 1, max(-1, end - 1 - _MOST_EXPOSURES), -1):
            inside = values[start:end]
            if any(abs(inside[0] - value) < SAME_EXPOSURE_EV for value in inside[1:]):
                break
            if not any(_begins_anew(inside[: count + 1]) for count in range(3, len(inside))):
                brackets, paused, before = best[start]
                clear = _begins_anew(values[before : start + 1])
                ways.append((brackets + 1, paused - (limit if clear else min(pauses[start], limit)), start))
            if pauses[start] > limit:
                break
        best.append(min(ways, key=lambda way: (way[0], way[1], -way[2])))
    found: list[list[PhotoRecord]] = []
    end = len(shots)
    while end:
        start = best[end][2]
        found.insert(0, list(shots[start:end]))
        end = start
    return found


def _begins_anew(values: Sequence[float]) -> bool:
    """Whether the last of these exposures begins a new row.

    It does where exposures rose (or fell) through three photographs, turn round, and come nearer than half a step to one that
    was taken: a row that starts again with slightly other values. An exposure beyond both ends widens the row instead.
    """
    *before, last = values
    run: list[float] = []
    for value in reversed(before):
        if len(run) > 1 and (value - run[-1]) * (run[-1] - run[-2]) <= 0:
            break
        run.append(value)
    if len(run) < 3 or (last - run[0]) * (run[0] - run[1]) >= 0:
        return False
    step = median(abs(one - other) for one, other in itertools.pairwise(run))
    return min(abs(last - value) for value in run) < 0.5 * step


def _pauses(shots: Sequence[PhotoRecord]) -> tuple[list[float], float]:
    """The pause before every photograph (0 before the first), and the longest that a bracket may have.

    In seconds; where not all have a date, in missing numbers of the camera's count; without both there is none.
    """
    times = [shot.taken_s for shot in shots if shot.taken_s is not None]
    numbers = [number for shot in shots if (number := counter(shot.path)) is not None]
    if len(times) == len(shots):
        exposures_s = [shot.exposure.time_s if shot.exposure else 0.0 for shot in shots]
        pauses = [
            max(0.0, later - at - s)
            for (at, later), s in zip(itertools.pairwise(times), exposures_s, strict=False)
        ]
        limit = max(_PAUSES * median(pauses or [0.0]), _SHORTEST_PAUSE_S)
        return [0.0, *pauses], min(limit, LONGEST_PAUSE_S)
    if len(numbers) == len(shots):
        pauses = [float(abs(later - number) - 1) for number, later in itertools.pairwise(numbers)]
        return [0.0, *pauses], _PAUSE_COUNT * max(median(pauses or [0.0]), 1.0)
    return [0.0] * len(shots), 1.0


def _ev(shot: PhotoRecord) -> float:
    return math.log2(shot.exposure.relative) if shot.exposure is not None else 0.0


def _range_ev(shots: Sequence[PhotoRecord]) -> float:
    values = [_ev(shot) for shot in shots]
    return max(values) - min(values)


# ---------------------------------------------------------------- what should be said


def _with_hints(brackets: Sequence[Sequence[PhotoRecord]]) -> tuple[ViewGroup, ...]:
    """The views, each with what the user should look at."""
    usual = max(multimode(len(bracket) for bracket in brackets), default=0)
    moments = defaultdict(set)
    for number, bracket in enumerate(brackets):
        for shot in bracket:
            if shot.taken_s is not None:
                moments[(shot.camera, shot.taken_s, shot.exposure)].add(number)
    views = []
    for number, bracket in enumerate(brackets):
        hints: list[Hint] = []
        if len(bracket) == 1 and usual > 1:
            hints.append("one photograph")
        elif len(bracket) != usual:
            hints.append("uneven")
        if any(shot.exposure is None and shot.encoding != "radiance" for shot in bracket):
            hints.append("no exposure")
        if any(number in numbers and len(numbers) > 1 for numbers in moments.values()):
            hints.append("same moment")
        views.append(ViewGroup(tuple(bracket), tuple(hints)))
    return tuple(sorted(views, key=lambda view: "one photograph" in view.hints))

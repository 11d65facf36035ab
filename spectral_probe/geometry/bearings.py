"""Bearings for views of which nobody has said where the camera stood: evenly round the ball."""

from __future__ import annotations

from collections.abc import Sequence


def even_bearings_deg(views: int, first_deg: float = 0.0, *, clockwise: bool = True) -> list[float]:
    """Compass bearings in [0, 360) of so many views, evenly round the ball.

    Examples
    --------
    >>> even_bearings_deg(3), even_bearings_deg(2)
    ([0.0, 120.0, 240.0], [0.0, 180.0])
    >>> even_bearings_deg(4, 45.0, clockwise=False)
    [45.0, 315.0, 225.0, 135.0]
    """
    step = (360.0 if clockwise else -360.0) / max(views, 1)
    return [round((first_deg + number * step) % 360.0, 4) % 360.0 for number in range(views)]


def are_even(bearings_deg: Sequence[float]) -> bool:
    """Whether bearings are those that `even_bearings_deg` gives by default: as good as not given.

    Examples
    --------
    >>> are_even([0.0, 120.0, 240.0]), are_even([0.0, 118.0, 240.0]), are_even([])
    (True, False, True)
    """
    pairs = zip(bearings_deg, even_bearings_deg(len(bearings_deg)), strict=True)
    return all(abs(bearing - even) < 0.01 for bearing, even in pairs)


def bearings_between_deg(known_deg: Sequence[float], views: int) -> list[float]:
    """Bearings for further views: each in the middle of the widest gap that those before it left.

    Examples
    --------
    >>> bearings_between_deg([0.0, 90.0], 2)
    [225.0, 157.5]
    """
    taken = sorted(bearing % 360.0 for bearing in known_deg)
    added: list[float] = []
    for _ in range(views):
        gaps = [
            ((later - bearing) % 360.0 or 360.0, bearing)
            for bearing, later in zip(taken, [*taken[1:], *taken[:1]], strict=True)
        ]
        width, start = max(gaps, key=lambda gap: gap[0], default=(0.0, 0.0))
        added.append(round((start + width / 2) % 360.0, 4))
        taken = sorted([*taken, added[-1]])
    return added

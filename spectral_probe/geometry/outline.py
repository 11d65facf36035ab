"""The ball's outline in photographs, found automatically or given."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import OutlineError
from ..model import FloatArray, Outline, Photograph
from .circle_search import EVIDENCE_RADIUS_PX, Circle, best_circle, find_circles, full_turn, polar_evidence
from .rim import Ellipse, Rim, fit_rim

ENOUGH_COVERAGE = 0.44
"""Share of the visible outline that must have an edge along it. Without a ball, the best circles of the
rooms tried reach 0.36; balls, down to dim, blurred and half hidden ones, 0.48 to 0.95."""

ENOUGH_SIGNIFICANCE = 40.0
OWN_SHARE = 0.6
"""A photograph's own evidence counts when its coverage is this share of the bracket's best or more."""

SAME_PLACE = 0.004
"""Outlines that agree to this share of the radius are taken to be one: the camera stood still."""

CUT_SHARE = 0.005
"""How far, in radii, an outline may leave the frame: the outermost 0.5 % of the radius shows only the last
11 degrees behind the ball, where no mirrored ball resolves anything."""


def detect_outline(photographs: Photograph | Sequence[Photograph]) -> Outline:
    """Find the ball's outline in the frame of the first photograph.

    Parameters
    ----------
    photographs
        One photograph or the bracket of a view. All that show the ball at the same place are used together.

    Returns
    -------
    Outline
        In pixels of the first photograph.

    Raises
    ------
    OutlineError
        There is no ball, or the frame cuts it.
    """
    if isinstance(photographs, Photograph):
        photographs = [photographs]
    return detect_outlines(photographs)[0]


def detect_outlines(photographs: Sequence[Photograph]) -> list[Outline]:
    """Find the ball in every photograph of a bracket, each in its own frame.

    Photographs of one size are searched together, so that one that is too dark or too bright borrows from the
    others. Where the camera stood still they share one outline, fitted to all of them.
    Photographs of different sizes (crops) share only the radius.

    Parameters
    ----------
    photographs
        The bracket of one view.

    Returns
    -------
    list of Outline
        One per photograph.

    Raises
    ------
    OutlineError
        There is no ball in the bracket, or the frame cuts it.
    """
    if not photographs:
        raise OutlineError("There is no photograph to find the ball in. List photos in the view.")
    groups: dict[tuple[int, ...], list[int]] = {}
    for index, photograph in enumerate(photographs):
        groups.setdefault(photograph.pixels.shape[:2], []).append(index)
    found: dict[int, Rim] = {}
    for members in groups.values():
        rims = _outlines_of_one_size([photographs[index] for index in members])
        found.update(zip(members, rims or (), strict=False))
    if not found:
        raise OutlineError(_no_ball(photographs[0]))
    _share_radius(photographs, found)
    outlines = []
    for index, photograph in enumerate(photographs):
        if index not in found:
            raise OutlineError(_no_ball(photograph))
        outline = _as_outline(found[index])
        check_in_frame(outline, (photograph.pixels.shape[1], photograph.pixels.shape[0]))
        outlines.append(outline)
    return outlines


def outline_from_circle(x_px: float, y_px: float, radius_px: float) -> Outline:
    """Outline for a circle that the user gives, with points all round it.

    Examples
    --------
    >>> outline_from_circle(400, 300, 100).points_px.shape
    (360, 2)
    """
    values = (x_px, y_px, radius_px)
    if not (np.isfinite(values).all() and radius_px > 0.0):
        raise OutlineError(
            "An outline needs a centre and a positive radius. Write outline = [cx, cy, r] in pixels."
        )
    angles = full_turn(360)
    points = np.stack([x_px + radius_px * np.cos(angles), y_px + radius_px * np.sin(angles)], axis=-1)
    return Outline((x_px, y_px), (radius_px, radius_px), 0.0, points, 0.0)


def check_in_frame(outline: Outline, size_px: tuple[int, int]) -> None:
    """Refuse an outline that leaves the frame of (width, height) by more than a sliver of the rim.

    Examples
    --------
    >>> check_in_frame(outline_from_circle(50, 50, 45), (100, 100))
    >>> check_in_frame(outline_from_circle(40, 50, 45), (100, 100))
    Traceback (most recent call last):
    ...
    spectral_probe.errors.OutlineError: The ball touches the left edge of the frame. Photograph it whole, or
    ...
    """
    width, height = size_px
    ellipse = Ellipse(*outline.centre_px, *outline.semi_axes_px, outline.angle_rad)
    angles = full_turn(720)
    radius = ellipse.radius_at(angles)
    x = ellipse.x + radius * np.cos(angles)
    y = ellipse.y + radius * np.sin(angles)
    over = {
        "left": -float(x.min()),
        "right": float(x.max()) - width,
        "top": -float(y.min()),
        "bottom": float(y.max()) - height,
    }
    edge = max(over, key=lambda name: over[name])
    if over[edge] > max(1.0, CUT_SHARE * ellipse.radius):
        raise OutlineError(
            f"The ball touches the {edge} edge of the frame. "
            "Photograph it whole, or give its outline (outline = [cx, cy, r])."
        )


def _no_ball(photograph: Photograph) -> str:
    return (
        f"No mirrored ball was found in {photograph.path.name}. "
        "Give its outline in the view (outline = [cx, cy, r] in pixels), or photograph the ball larger."
    )


def _as_outline(rim: Rim) -> Outline:
    ellipse = rim.ellipse
    return Outline(
        (ellipse.x, ellipse.y), (ellipse.major, ellipse.minor), ellipse.angle_rad, rim.points_px, rim.rms_px
    )


def _outlines_of_one_size(photographs: Sequence[Photograph]) -> list[Rim] | None:
    """One rim per photograph, or None where there is no ball."""
    chosen = _choose(find_circles(photographs))
    if chosen is None:
        return None
    return _follow(photographs, chosen)


def _choose(circles: Sequence[Circle]) -> Circle | None:
    """The most significant circle that is well enough covered with edges."""
    for circle in circles:
        if circle.coverage >= ENOUGH_COVERAGE and circle.significance >= ENOUGH_SIGNIFICANCE:
            return circle
    return None


def _follow(photographs: Sequence[Photograph], circle: Circle) -> list[Rim]:
    """From the bracket's circle to a rim in each photograph."""
    own = [
        best_circle(polar_evidence(one, circle, EVIDENCE_RADIUS_PX, 0.12), circle, 0.05)
        for one in photographs
    ]
    enough = OWN_SHARE * max(one.coverage for one in own)
    clear = [index for index, one in enumerate(own) if one.coverage >= enough]
    rims = {index: fit_rim([photographs[index]], own[index]) for index in clear}
    middle = np.median([_place(rims[index]) for index in clear], axis=0)
    spread = max(float(np.abs(_place(rims[index]) - middle).max()) for index in clear)
    start = Circle(*(float(value) for value in middle))
    if len(clear) > 1 and spread < max(0.6, SAME_PLACE * start.radius):
        together = fit_rim([photographs[index] for index in clear], start)
        return [together] * len(photographs)
    # The camera moved: each photograph for itself, and those that show too little as the one next to them.
    return [rims[min(clear, key=lambda other: abs(other - index))] for index in range(len(photographs))]


def _place(rim: Rim) -> FloatArray:
    return np.array([rim.ellipse.x, rim.ellipse.y, rim.ellipse.radius])


def _share_radius(photographs: Sequence[Photograph], found: dict[int, Rim]) -> None:
    """Search again, with the others' radius, in photographs that found no ball or one of another radius."""
    if len(photographs) < 2:
        return
    radius = float(np.median([rim.ellipse.radius for rim in found.values()]))
    for index, photograph in enumerate(photographs):
        rim = found.get(index)
        if rim is not None and abs(rim.ellipse.radius / radius - 1.0) < 0.03:
            continue
        circles = find_circles([photograph], radius)
        if circles and circles[0].coverage > 0.2:
            found[index] = fit_rim([photograph], circles[0])

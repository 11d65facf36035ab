"""The ball's outline in photographs, found automatically or given."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import OutlineError
from ..model import FloatArray, Outline, Photograph
from ..photo.align import register
from .circle_search import Circle, find_circles, full_turn, outermost
from .rim import Ellipse, Rim, fit_rim

ENOUGH_COVERAGE = 0.44
"""Share of the visible outline that must have an edge along it. Without a ball, the best circles of the
rooms tried reach 0.36; balls, down to dim, blurred and half hidden ones, 0.48 to 0.95."""

ENOUGH_SIGNIFICANCE = 40.0

HOLDING_SHARE = 0.5
"""A circle round the best one is preferred to it when it is this share as significant."""

KNOWN_RADIUS_COVERAGE = 0.25
"""The same where another photograph of the bracket has told the radius already."""

CUT_SHARE = 0.045
"""How far, in radii, an outline may leave the frame. A cut of 4.5 % hides 0.7 % of the ball's picture, all of it near the rim,
where the world behind the ball is squeezed together and the other views see better; the rest of the rim tells where
the cut part lies."""


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

    The photographs are registered to each other by what the ball shows, and one outline is fitted to all of
    them together, so that one that is too dark or too bright borrows from the others. They may be crops of
    different sizes; the ball's size in pixels must be the same.

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
        There is no ball in the bracket, or the frame of the first photograph cuts it.
    """
    if not photographs:
        raise OutlineError("There is no photograph to find the ball in. List photos in the view.")
    circles = _circles(photographs)
    shifts = register(photographs, [(one.x, one.y, one.radius) for one in circles])
    clearest = max(range(len(photographs)), key=lambda index: circles[index].significance)
    start = circles[clearest].moved(-shifts[clearest])
    rim = fit_rim(photographs, shifts, start)
    outlines = [_as_outline(rim, shift) for shift in shifts]
    # What a later photograph cuts off, the first and the others have.
    height, width = photographs[0].clipped.shape
    check_in_frame(outlines[0], (width, height))
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


def _as_outline(rim: Rim, shift_px: FloatArray) -> Outline:
    ellipse = rim.ellipse.moved(shift_px)
    return Outline(
        (ellipse.x, ellipse.y),
        (ellipse.major, ellipse.minor),
        ellipse.angle_rad,
        rim.points_px + shift_px,
        rim.rms_px,
    )


def _circles(photographs: Sequence[Photograph]) -> list[Circle]:
    """Roughly where the ball is in each photograph; those of one size are searched together."""
    groups: dict[tuple[int, ...], list[int]] = {}
    for index in _best_exposed_first(photographs):
        groups.setdefault(photographs[index].pixels.shape[:2], []).append(index)
    found: dict[int, Circle] = {}
    radius = None
    for members in groups.values():
        circle = _search([photographs[index] for index in members], radius)
        if circle is None:
            continue
        radius = radius or circle.radius
        found.update(dict.fromkeys(members, circle))
    missing = [photographs[index] for index in range(len(photographs)) if index not in found]
    if missing:
        raise OutlineError(_no_ball(missing[0]))
    return [found[index] for index in range(len(photographs))]


def _best_exposed_first(photographs: Sequence[Photograph]) -> list[int]:
    """The photographs' order, those with most pixels neither clipped nor dark first."""

    def well_exposed(index: int) -> float:
        photograph = photographs[index]
        step = max(1, min(photograph.clipped.shape) // 200)
        level = photograph.pixels[::step, ::step].mean(axis=-1)
        return float(np.mean((level > 0.03) & ~photograph.clipped[::step, ::step]))

    return sorted(range(len(photographs)), key=well_exposed, reverse=True)


def _search(photographs: Sequence[Photograph], radius_px: float | None) -> Circle | None:
    """The ball's circle in photographs of one size: first where it has the radius that others gave it."""
    if radius_px is not None:
        near = find_circles(photographs, radius_px)
        if near and near[0].coverage >= KNOWN_RADIUS_COVERAGE:
            return near[0]
    good = [
        circle
        for circle in find_circles(photographs)
        if circle.coverage >= ENOUGH_COVERAGE and circle.significance >= ENOUGH_SIGNIFICANCE
    ]
    if not good:
        return None
    chosen = good[0]
    for circle in good[1:]:
        # Something round that the ball reflects may be sharper than the ball; it lies within the ball's outline.
        inside = np.hypot(circle.x - chosen.x, circle.y - chosen.y) + chosen.radius < circle.radius
        if inside and circle.significance > HOLDING_SHARE * chosen.significance:
            chosen = circle
    return outermost(photographs[:: max(1, len(photographs) // 3)], chosen)

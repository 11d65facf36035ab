"""The ball's outline in photographs, found automatically or given."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import OutlineError
from ..model import FloatArray, Outline, Photograph
from ..photo.align import register
from .ball import GIVEN_ERROR_PX, INDEPENDENT_ARCS, MODEL_ERROR_PX, correlated
from .circle_search import find_circles
from .ellipse import Ellipse, full_turn
from .rim import Rim, fit_rim
from .unrolled import Circle, outermost

ENOUGH_COVERAGE = 0.44
"""Share of the visible outline that must have an edge along it. Without a ball, the best circles of the
rooms tried reach 0.36; balls, down to dim, blurred and half hidden ones, 0.48 to 0.95."""

ENOUGH_SIGNIFICANCE = 40.0

HOLDING_SHARE = 0.5
"""A circle round the best one is preferred to it when it is this share as significant."""

KNOWN_RADIUS_COVERAGE = 0.25
"""Coverage that is enough where another photograph of the bracket has told the radius already."""

CLEARER = 1.5
"""A circle of another radius must be so many times as significant as one of the radius known."""

ANOTHER_COVERAGE, ANOTHER_SHARE = 0.6, 0.5
"""A second ball must be this clear, and this share as significant as the first."""

SAME_RADIUS = 0.06
"""Radii of one ball in photographs of one scale differ by less than this, as roughly as they are known by then."""

CUT_SHARE = 0.045
"""How far, in radii, an outline may leave the frame. A cut of 4.5 % hides 0.7 % of the ball's picture, all of it near the rim,
where the world behind the ball is squeezed together and the other views see better; the rest of the rim tells where
the cut part lies."""


@dataclass(frozen=True)
class FoundBall:
    """The ball in the photographs of one view.

    `outlines` has one outline per photograph, in its own frame; `shifts_px` (x, y) says where each photograph's ball lies from
    the first's. `others` are further balls in the picture as (x, y, radius), in pixels of the first photograph. `warnings`
    are sentences for the user.
    """

    outlines: tuple[Outline, ...]
    shifts_px: tuple[FloatArray, ...]
    others: tuple[tuple[float, float, float], ...] = ()
    warnings: tuple[str, ...] = ()


def find_ball(photographs: Sequence[Photograph], ball_at: tuple[float, float] | None = None) -> FoundBall:
    """Find the mirrored ball in every photograph of a view.

    The photographs are registered to each other by what the ball shows, and one outline is fitted to all of
    them together, so that one that is too dark or too bright borrows from the others. They may be crops of
    different sizes; the ball's size in pixels must be the same.

    Parameters
    ----------
    photographs
        The bracket of one view, or one photograph.
    ball_at
        A point on the ball in the first photograph, where there is more than one ball.

    Raises
    ------
    OutlineError
        There is no ball in the bracket, or the frame of the first photograph cuts it.
    """
    if not photographs:
        raise OutlineError("There is no photograph to find the ball in. List photos in the view.")
    sightings = _sightings(photographs, ball_at)
    shifts = register(photographs, [(one.circle.x, one.circle.y, one.circle.radius) for one in sightings])
    clearest = max(range(len(photographs)), key=lambda index: sightings[index].circle.significance)
    rim = fit_rim(photographs, shifts, sightings[clearest].circle.moved(-shifts[clearest]))
    outlines = tuple(outline_of_rim(rim, shift) for shift in shifts)
    check_in_frame(outlines[0], _size(photographs[0]))
    others = sightings[0].others
    warnings = _two_balls(photographs[0], rim, others, ball_at) + _cut_later(photographs, outlines)
    named = tuple((one.x, one.y, one.radius) for one in others)
    return FoundBall(outlines, tuple(shifts), named, tuple(warnings))


def outline_from_circle(x_px: float, y_px: float, radius_px: float) -> Outline:
    """Outline for a circle that the user gives, with points all round it; half a pixel is assumed as its error.

    Examples
    --------
    >>> outline_from_circle(400, 300, 100).points_px.shape
    (360, 2)
    """
    return outline_given((x_px, y_px, radius_px))


def outline_given(values: Sequence[float]) -> Outline:
    """Outline that the user gives: a circle (x, y, radius), or an ellipse (x, y, semi-axis, semi-axis, angle in degrees).

    Lengths are pixels; the angle is that of the first semi-axis, from +x towards +y. Half a pixel is assumed as its error.

    Examples
    --------
    >>> outline_given((400, 300, 90, 100, 0)).semi_axes_px  # the major one comes first
    (100.0, 90.0)
    """
    x_px, y_px, first_px, second_px, angle_deg = (
        float(value) for value in (*values, *((values[2], 0.0) if len(values) == 3 else ()))
    )
    if not (np.isfinite(values).all() and first_px > 0.0 and second_px > 0.0):
        raise OutlineError(
            "An outline needs a centre and a positive radius. Write outline = [cx, cy, r] in pixels."
        )
    if second_px > first_px:
        first_px, second_px, angle_deg = second_px, first_px, angle_deg + 90.0
    angle_rad = float(np.radians(angle_deg % 180.0))
    points = Ellipse(x_px, y_px, first_px, second_px, angle_rad).points(full_turn(360))
    error = (GIVEN_ERROR_PX, GIVEN_ERROR_PX)
    return Outline((x_px, y_px), (first_px, second_px), angle_rad, points, 0.0, error)


def check_in_frame(outline: Outline, size_px: tuple[int, int], given: bool = False) -> None:
    """Refuse an outline that leaves the frame of (width, height) by more than a sliver of the rim.

    `given` says that the user gave the outline, and so cannot be told to give it.

    Examples
    --------
    >>> check_in_frame(outline_from_circle(50, 50, 45), (100, 100))
    """
    ellipse = Ellipse.of(outline)
    over = _overhang(ellipse, size_px)
    allowed = max(1.0, CUT_SHARE * ellipse.radius)
    edges = [name for name, value in over.items() if value > allowed]
    if not edges:
        return
    opposite = {"left", "right"} <= set(edges) or {"top", "bottom"} <= set(edges)
    if given:
        x, y = outline.centre_px
        raise OutlineError(
            f"The outline given (centre {x:.0f}, {y:.0f}, radius {ellipse.radius:.0f}) leaves the frame of "
            f"{size_px[0]} x {size_px[1]} pixels at the {_listed(edges)}. Correct it, or photograph the ball whole."
        )
    if opposite:
        raise OutlineError(
            f"The ball is larger than the frame: its rim lies outside at the {_listed(edges)}. Photograph it whole."
        )
    raise OutlineError(
        f"The ball touches the {_listed(edges)} edge of the frame. "
        "Photograph it whole, or give its outline (outline = [cx, cy, r])."
    )


def _overhang(ellipse: Ellipse, size_px: tuple[int, int]) -> dict[str, float]:
    """How far an outline leaves the frame at each of its edges, in pixels."""
    x, y = ellipse.points(full_turn(720)).T
    width, height = size_px
    return {
        "left": -float(x.min()),
        "right": float(x.max()) - width,
        "top": -float(y.min()),
        "bottom": float(y.max()) - height,
    }


def _listed(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def _size(photograph: Photograph) -> tuple[int, int]:
    height, width = photograph.clipped.shape
    return width, height


def _cut_later(photographs: Sequence[Photograph], outlines: Sequence[Outline]) -> list[str]:
    """Photographs after the first that cut the ball: what they miss the others must have, but it is worth saying."""
    cut = []
    for photograph, outline in zip(photographs[1:], outlines[1:], strict=True):
        ellipse = Ellipse.of(outline)
        if max(_overhang(ellipse, _size(photograph)).values()) > max(1.0, CUT_SHARE * ellipse.radius):
            cut.append(photograph.path.name)
    return (
        [
            f"The frame cuts the ball in {_listed(cut)}: what is missing there comes from the other photographs."
        ]
        if cut
        else []
    )


def _two_balls(
    photograph: Photograph, rim: Rim, others: Sequence[Circle], ball_at: tuple[float, float] | None
) -> list[str]:
    if not others or ball_at is not None:
        return []
    ellipse = rim.ellipse
    places = [(ellipse.x, ellipse.y, ellipse.radius), *((one.x, one.y, one.radius) for one in others)]
    text = [f"at ({x:.0f}, {y:.0f}) radius {radius:.0f}" for x, y, radius in places]
    count = {2: "Two", 3: "Three"}.get(len(places), str(len(places)))
    told = (
        f"{count} balls are in {photograph.path.name}: {_listed(text)}; the larger, {text[0]}, is used. "
        "Write ball_at = [x, y] to choose."
    )
    return [told]


def _no_ball(photograph: Photograph, ball_at: tuple[float, float] | None = None) -> str:
    where = "" if ball_at is None else f" round ball_at = [{ball_at[0]:g}, {ball_at[1]:g}]"
    return (
        f"No mirrored ball was found{where} in {photograph.path.name}. "
        "Give its outline in the view (outline = [cx, cy, r] in pixels), or photograph the ball whole and larger."
    )


def outline_of_rim(rim: Rim, shift_px: FloatArray) -> Outline:
    """The outline of a rim, in a photograph whose ball lies `shift_px` (x, y) from where it is in the first one."""
    ellipse = rim.ellipse.moved(shift_px)
    return Outline(
        (ellipse.x, ellipse.y),
        (ellipse.major, ellipse.minor),
        ellipse.angle_rad,
        rim.points_px + shift_px,
        rim.rms_px,
        _errors(rim),
    )


def _errors(rim: Rim) -> tuple[float, float]:
    """Standard errors of centre and radius in pixels: the points' scatter over how many of them are independent."""
    away = rim.points_px - [rim.ellipse.x, rim.ellipse.y]
    angles = np.arctan2(away[:, 1], away[:, 0])
    residuals = np.linalg.norm(away, axis=-1) - rim.ellipse.radius_at(angles)
    independent = len(residuals) / correlated(residuals[np.argsort(angles)])
    error = np.hypot(rim.rms_px / np.sqrt(max(independent, 1.0)), MODEL_ERROR_PX / np.sqrt(INDEPENDENT_ARCS))
    return float(np.sqrt(2.0) * error), float(error)


# ---------------------------------------------------------------- which circle is the ball


@dataclass(frozen=True)
class _Sighting:
    """Where the ball seems to be in a photograph, and `others` in it."""

    circle: Circle
    others: tuple[Circle, ...] = ()


def _sightings(photographs: Sequence[Photograph], ball_at: tuple[float, float] | None) -> list[_Sighting]:
    """Roughly where the ball is in each photograph; those of one size are searched together, the best exposed first."""
    groups: dict[tuple[int, ...], list[int]] = {}
    for index in _best_exposed_first(photographs):
        groups.setdefault(photographs[index].clipped.shape, []).append(index)
    if ball_at is not None:  # the point is one of the first photograph's
        own = photographs[0].clipped.shape
        groups = {own: groups[own], **groups}
    found: dict[int, _Sighting] = {}
    radius = None
    for members in groups.values():
        pictures = [photographs[index] for index in members]
        sighting = _search(pictures, radius, ball_at if 0 in members else None)
        if sighting is None:
            continue
        radius = radius or sighting.circle.radius
        _check_scale(
            photographs[members[0]],
            sighting.circle.radius,
            photographs[next(iter(found), members[0])],
            radius,
        )
        found.update(dict.fromkeys(members, sighting))
    missing = [photographs[index] for index in range(len(photographs)) if index not in found]
    if missing:
        raise OutlineError(_no_ball(missing[0], ball_at))
    return [found[index] for index in range(len(photographs))]


def _check_scale(photograph: Photograph, radius_px: float, other: Photograph, other_px: float) -> None:
    """Refuse photographs of one view at different scales; crops of different sizes are well."""
    if abs(radius_px / other_px - 1.0) > SAME_RADIUS:
        raise OutlineError(
            f"The ball has a radius of {radius_px:.0f} pixels in {photograph.path.name} and of {other_px:.0f} in "
            f"{other.path.name}. Give the photographs of a view at one size; crops of it are well."
        )


def _best_exposed_first(photographs: Sequence[Photograph]) -> list[int]:
    """The photographs' order, those with most pixels neither clipped nor dark first."""

    def well_exposed(index: int) -> float:
        photograph = photographs[index]
        step = max(1, min(photograph.clipped.shape) // 200)
        level = photograph.pixels[::step, ::step].mean(axis=-1)
        return float(np.mean((level > 0.03) & ~photograph.clipped[::step, ::step]))

    return sorted(range(len(photographs)), key=well_exposed, reverse=True)


def _search(
    photographs: Sequence[Photograph], radius_px: float | None, ball_at: tuple[float, float] | None
) -> _Sighting | None:
    """The ball in photographs of one size, and other balls; None without any.

    Where other photographs have told the radius, that is looked for first.
    """
    near = find_circles(photographs, radius_px)[:1] if radius_px is not None and ball_at is None else []
    if near and near[0].coverage >= ENOUGH_COVERAGE:
        return _Sighting(near[0])
    circles = [one for one in find_circles(photographs) if one.coverage >= ENOUGH_COVERAGE]
    if near and near[0].coverage >= KNOWN_RADIUS_COVERAGE:
        # Few edges speak for the known radius: a clear ball of another one speaks against the scale.
        return _Sighting(
            max([near[0], *circles], key=lambda one: one.significance / (CLEARER if one in circles else 1.0))
        )
    good = [one for one in circles if one.significance >= ENOUGH_SIGNIFICANCE]
    seen = good
    if ball_at is not None:
        good = [one for one in good if np.hypot(one.x - ball_at[0], one.y - ball_at[1]) < one.radius]
    if not good:
        return None
    chosen = outermost(photographs[:: max(1, len(photographs) // 3)], _apart(good)[0])
    return _Sighting(chosen, tuple(one for one in _apart(seen) if _disjoint(one, chosen)))


def _apart(circles: Sequence[Circle]) -> list[Circle]:
    """Of circles, the most significant first, those of separate balls, the largest ball first."""
    balls: list[Circle] = []
    for circle in circles:
        clear = (
            circle.coverage >= ANOTHER_COVERAGE
            and circle.significance >= ANOTHER_SHARE * circles[0].significance
        )
        if all(_disjoint(circle, ball) for ball in balls) and (clear or not balls):
            balls.append(_holding(circle, circles))
    return sorted(balls, key=lambda ball: -ball.radius)


def _disjoint(one: Circle, other: Circle) -> bool:
    return bool(np.hypot(one.x - other.x, one.y - other.y) > 0.9 * (one.radius + other.radius))


def _holding(chosen: Circle, circles: Sequence[Circle]) -> Circle:
    """The ball's circle, where something round that the ball reflects is sharper than the ball: it lies within it."""
    for circle in circles:
        inside = np.hypot(circle.x - chosen.x, circle.y - chosen.y) + chosen.radius < circle.radius
        if inside and circle.significance > HOLDING_SHARE * chosen.significance:
            chosen = circle
    return chosen

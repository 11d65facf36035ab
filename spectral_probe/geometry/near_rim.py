"""The ball's rim next to an outline that somebody drew: where automatic search fails, or to correct it by hand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import OutlineError
from ..model import Outline, Photograph
from ..photo.align import register
from .ellipse import Ellipse
from .outline import FoundBall, check_in_frame, outline_of_rim
from .rim import fit_rim
from .unrolled import Circle, best_circle, polar_evidence

NEAR_SHARE = 0.15
"""A rim further from the outline drawn, in radii, is not the one that was meant."""

ENOUGH_COVERAGE = 0.4
"""Share of the rim that must have an edge along it: circles that follow no rim reach 0.36 (`outline.ENOUGH_COVERAGE`)."""

_LEVELS = ((60.0, 0.25, 0.1), (120.0, 0.12, 0.025))
"""Radius in pixels, ring looked at and reach, both in radii: from a drawn outline to one that `fit_rim` can begin from."""


def find_ball_near(photographs: Sequence[Photograph], given: Outline) -> FoundBall:
    """The rim next to an outline drawn by hand to within some 10 % of its radius, in all photographs of a view together.

    Parameters
    ----------
    photographs
        The bracket of one view, or one photograph.
    given
        The outline in the first photograph.

    Returns
    -------
    FoundBall
        The rim with its edge points. Where there is none near, the outline as it was given, and a warning.

    Raises
    ------
    OutlineError
        There is no photograph, or the frame of the first one cuts the ball.
    """
    if not photographs:
        raise OutlineError("There is no photograph to find the ball in. List photos in the view.")
    start = Ellipse.of(given)
    shifts = register(photographs, [(start.x, start.y, start.radius)] * len(photographs))
    circle = Circle(start.x, start.y, start.radius)
    for level_px, span, reach in _LEVELS:
        circle = best_circle(polar_evidence(photographs, shifts, circle, level_px, span), circle, reach)
    rim = fit_rim(photographs, shifts, circle)
    found = rim.ellipse
    away = np.hypot(found.x - start.x, found.y - start.y) + abs(found.radius - start.radius)
    height, width = photographs[0].clipped.shape
    outlines = tuple(outline_of_rim(rim, shift) for shift in shifts)
    if rim.coverage < ENOUGH_COVERAGE or away > NEAR_SHARE * start.radius:
        check_in_frame(given, (width, height), given=True)
        told = f"No rim lies near the outline drawn in {photographs[0].path.name}: it is used as it is."
        return FoundBall((given,) * len(photographs), tuple(shifts), warnings=(told,))
    check_in_frame(outlines[0], (width, height))
    return FoundBall(outlines, tuple(shifts))

"""Circles in a photograph that could be a mirrored ball's outline, to a few thousandths of the radius.

Two steps: edge pixels of a small logarithmic picture vote along their gradients for centres at many radii;
the best candidates are then unrolled and scored by the share of the circumference that has an edge along it (`unrolled`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..model import BoolArray, FloatArray, Photograph
from .edges import Gradients, log_gradients, shrunk, strongest_channel
from .unrolled import EVIDENCE_RADIUS_PX, Circle, best_circle, divergence, polar_evidence

SHORT_SIDE_PX = 360
"""Short side of the small picture that votes."""

RADIUS_RANGE = (0.03, 0.62)
"""Radii looked for, as shares of the short side; over half a side, so that a ball cut by the frame is found
too."""

CANDIDATES = 16
CLEAR_COVERAGE, CLEAR_SIGNIFICANCE = 0.6, 150.0
"""With a circle as clear as this among the first, no further candidates are looked at."""


def find_circles(photographs: Sequence[Photograph], radius_px: float | None = None) -> list[Circle]:
    """Circles that photographs of one size and nearly one frame speak for, the most significant first.

    Parameters
    ----------
    photographs
        A bracket of one view, or one photograph.
    radius_px
        Known radius of the ball, to which 3 % are then added and taken away.
    """
    size = photographs[0].pixels.shape[:2]
    scale = min(1.0, SHORT_SIDE_PX / min(size))
    edges = [strongest_channel(*log_gradients(shrunk(one.pixels, scale), one)) for one in photographs]
    short = min(edges[0].magnitude.shape)
    if radius_px is None:
        radii = np.geomspace(RADIUS_RANGE[0] * short, RADIUS_RANGE[1] * short, 76)
    else:
        radii = np.geomspace(0.97 * radius_px * scale, 1.03 * radius_px * scale, 7)
    votes, padding = _vote(edges, radii)
    found = []
    # Three exposures of a bracket decide as well as eleven, and in a quarter of the time.
    judges = photographs[:: max(1, len(photographs) // 3)]
    still = [np.zeros(2)] * len(judges)
    for x, y, radius in _peaks(votes, radii, padding):
        start = Circle(x / scale, y / scale, radius / scale)
        evidence = polar_evidence(judges, still, start, EVIDENCE_RADIUS_PX, 0.2)
        reach = 0.09 if radius_px is None else 0.04
        found.append(best_circle(evidence, start, reach))
        clear = found[-1].coverage > CLEAR_COVERAGE and found[-1].significance > CLEAR_SIGNIFICANCE
        if clear and len(found) >= 4:
            break
    return sorted(found, key=lambda circle: -circle.significance)


def _ridges(gradients: Gradients) -> BoolArray:
    """Pixels whose gradient is the largest along its own direction."""
    import cv2

    height, width = gradients.magnitude.shape
    rows, columns = np.mgrid[:height, :width].astype(np.float32)
    unit_x = gradients.x / (gradients.magnitude + 1e-9)
    unit_y = gradients.y / (gradients.magnitude + 1e-9)
    ahead = cv2.remap(gradients.magnitude, columns + unit_x, rows + unit_y, cv2.INTER_LINEAR)
    behind = cv2.remap(gradients.magnitude, columns - unit_x, rows - unit_y, cv2.INTER_LINEAR)
    ridge = (gradients.magnitude >= ahead) & (gradients.magnitude > behind)
    ridge[:2] = ridge[-2:] = False
    ridge[:, :2] = ridge[:, -2:] = False
    return np.asarray(ridge)


def _vote(edges: Sequence[Gradients], radii_px: FloatArray) -> tuple[FloatArray, int]:
    """Votes (R, H + 2 p, W + 2 p) for centres, as shares of the circumference, and the padding p."""
    import cv2

    height, width = edges[0].magnitude.shape
    padding = int(0.15 * min(height, width))
    shape = (height + 2 * padding, width + 2 * padding)
    points = np.concatenate([_voters(gradients) for gradients in edges])
    x, y, unit_x, unit_y, weight = points.T
    votes = np.zeros((len(radii_px), *shape), np.float32)
    for index, radius in enumerate(radii_px):
        total = np.zeros(shape[0] * shape[1])
        for side in (radius, -radius):
            column = np.floor(x + side * unit_x).astype(int) + padding
            row = np.floor(y + side * unit_y).astype(int) + padding
            inside = (column >= 0) & (row >= 0) & (column < shape[1]) & (row < shape[0])
            places = row[inside] * shape[1] + column[inside]
            total += np.bincount(places, weight[inside], minlength=len(total))
        sigma = 0.7 + 0.025 * radius
        smooth = cv2.GaussianBlur(total.reshape(shape).astype(np.float32), (0, 0), sigma)
        votes[index] = smooth * (sigma**2 / (radius * len(edges)))  # 2 pi sigma^2 / (2 pi r E)
    return votes, padding


def _voters(gradients: Gradients) -> FloatArray:
    """Edge pixels as rows (x, y, unit gradient x, y, weight); the weight is relative to the edges around."""
    import cv2

    magnitude = gradients.magnitude
    around = cv2.GaussianBlur(magnitude, (0, 0), 0.05 * min(magnitude.shape)) + 0.01
    relative = magnitude / around
    chosen = _ridges(gradients) & (relative > 0.5) & (magnitude > 0.008)
    rows, columns = np.nonzero(chosen)
    strength = magnitude[chosen]
    return np.stack(
        [
            columns + 0.5,
            rows + 0.5,
            gradients.x[chosen] / strength,
            gradients.y[chosen] / strength,
            np.minimum(relative[chosen], 2.0) / 2.0,
        ],
        axis=1,
    )


def _peaks(votes: FloatArray, radii_px: FloatArray, padding: int) -> list[tuple[float, float, float]]:
    """The most significant peaks as (x, y, radius) in the small picture."""
    typical = votes.mean(axis=(1, 2))
    score = np.empty_like(votes)
    for index, radius in enumerate(radii_px):
        score[index] = np.pi * radius * divergence(1.3 * votes[index], 1.3 * typical[index])
    peaks: list[tuple[float, float, float]] = []
    for _ in range(CANDIDATES):
        level, row, column = np.unravel_index(int(score.argmax()), score.shape)
        if score[level, row, column] <= 0.0:
            break
        radius = float(radii_px[level])
        peaks.append((float(column) - padding + 0.5, float(row) - padding + 0.5, radius))
        near = np.abs(np.log(radii_px / radius)) < 0.1
        reach = 0.1 * radius + 1.0
        top, left = max(0, int(row - reach)), max(0, int(column - reach))
        score[near, top : int(row + reach) + 1, left : int(column + reach) + 1] = -1.0
    return peaks

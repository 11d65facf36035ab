"""Circles in a photograph that could be a mirrored ball's outline, to a few thousandths of the radius.

Two steps: edge pixels of a small logarithmic picture vote along their gradients for centres at many radii;
the best candidates are then unrolled to (angle, radius) and scored by the share of the circumference that
has an edge along it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from ..model import BoolArray, FloatArray, Photograph
from .edges import EdgeField, edge_field, shrunk
from .unrolled import EVIDENCE_RADIUS_PX, Circle, best_circle, divergence, polar_evidence, ring_field

SHORT_SIDE_PX = 360
"""Short side of the small picture that votes."""

MIDDLE_SIDE_PX = 1000
"""Short side of the picture in which candidates are judged, but for small ones."""

RADIUS_RANGE = (0.03, 0.75)
"""Radii looked for, as shares of the short side; over half a side, so that a ball cut by the frame is found
too."""

RADIUS_STEP = 1.04
KNOWN_RADIUS_REACH = 0.03
CANDIDATES = 16


def find_circles(photographs: Sequence[Photograph], radius_px: float | None = None) -> list[Circle]:
    """Circles that photographs of one size and nearly one frame speak for, the most significant first.

    Parameters
    ----------
    photographs
        A bracket of one view, or one photograph.
    radius_px
        Known radius of the ball, to which 3 % are then added and taken away.
    """
    levels = _Levels(photographs)
    edges, scale = levels.at(SHORT_SIDE_PX / min(levels.size_px))
    short = min(edges.magnitude.shape)
    if radius_px is None:
        smallest, largest = RADIUS_RANGE[0] * short, RADIUS_RANGE[1] * short
        count = int(np.log(largest / smallest) / np.log(RADIUS_STEP)) + 1
        radii = np.geomspace(smallest, largest, count)
    else:
        known = radius_px * scale
        radii = np.geomspace((1.0 - KNOWN_RADIUS_REACH) * known, (1.0 + KNOWN_RADIUS_REACH) * known, 7)
    votes, padding = _vote(edges, radii)
    found = []
    for x, y, radius in _peaks(votes, radii, padding):
        start = Circle(x / scale, y / scale, radius / scale)
        field, size = levels.round(start)
        there = start.scaled(size)
        evidence = polar_evidence(field, there, 0.2)
        best = best_circle(evidence, there, 0.09 if radius_px is None else 0.04)
        found.append(best.scaled(1.0 / size))
    return sorted(found, key=lambda circle: -circle.merit)


class _Levels:
    """The edges of a bracket at several sizes, each worked out when first asked for."""

    def __init__(self, photographs: Sequence[Photograph]) -> None:
        # Three exposures of a bracket decide as well as eleven, and in a quarter of the time.
        self.judges = few(photographs)
        self.pictures, self.ratio = _reduced(self.judges, MIDDLE_SIDE_PX)
        height, width = photographs[0].clipped.shape
        self.size_px = (width, height)
        self.fields: dict[float, EdgeField] = {}

    def at(self, scale: float) -> tuple[EdgeField, float]:
        """The edges of the whole frame in a picture of about this size over the photographs', and its exact size."""
        shrink = min(1.0, scale / self.ratio)
        if shrink not in self.fields:
            height, width = self.pictures[0].clipped.shape
            still = [np.zeros(2)] * len(self.pictures)
            self.fields[shrink] = edge_field(self.pictures, still, (0, 0, width, height), shrink)
        # Coordinates in the field are those of `pictures`.
        return self.fields[shrink], shrink * self.ratio

    def round(self, circle: Circle) -> tuple[EdgeField, float]:
        """Edges round a circle at about the radius wanted, and the size of the field's coordinates over the photographs'."""
        radius = circle.radius * self.ratio
        if radius < 0.7 * EVIDENCE_RADIUS_PX and self.ratio < 1.0:
            still = [np.zeros(2)] * len(self.judges)
            place = (circle.x, circle.y, circle.radius)
            return ring_field(self.judges, still, place, EVIDENCE_RADIUS_PX, 0.2), 1.0
        halvings = max(0, int(np.log2(radius / (0.7 * EVIDENCE_RADIUS_PX))))
        return self.at(self.ratio * 0.5**halvings)[0], self.ratio


def few(photographs: Sequence[Photograph]) -> Sequence[Photograph]:
    """At most three of a bracket, spread over it."""
    return photographs[:: -(-len(photographs) // 3)]


def _reduced(photographs: Sequence[Photograph], short_side_px: int) -> tuple[list[Photograph], float]:
    """Photographs made smaller, to a short side, and by how much; small ones stay as they are."""
    height, width = photographs[0].clipped.shape
    ratio = min(1.0, short_side_px / min(height, width))
    if ratio == 1.0:
        return list(photographs), 1.0
    small = [shrunk(one.pixels, ratio) for one in photographs]
    nowhere = np.zeros(
        small[0].shape[:2], bool
    )  # levels tell what is clipped; its mask is not looked at here
    reduced = [
        replace(one, pixels=pixels, clipped=nowhere) for one, pixels in zip(photographs, small, strict=True)
    ]
    return reduced, small[0].shape[1] / width


def _ridges(field: EdgeField) -> BoolArray:
    """Pixels whose gradient is the largest along its own direction."""
    height, width = field.magnitude.shape
    rows, columns = np.mgrid[:height, :width].astype(np.float32)
    unit_x = field.x / (field.magnitude + np.float32(1e-9))
    unit_y = field.y / (field.magnitude + np.float32(1e-9))
    ahead = cv2.remap(field.magnitude, columns + unit_x, rows + unit_y, cv2.INTER_LINEAR)
    behind = cv2.remap(field.magnitude, columns - unit_x, rows - unit_y, cv2.INTER_LINEAR)
    ridge = (field.magnitude >= ahead) & (field.magnitude > behind)
    ridge[:2] = ridge[-2:] = False
    ridge[:, :2] = ridge[:, -2:] = False
    return np.asarray(ridge)


def _vote(field: EdgeField, radii_px: FloatArray) -> tuple[FloatArray, int]:
    """Votes (R, H + 2 p, W + 2 p) for centres, as shares of the circumference, and the padding p."""
    height, width = field.magnitude.shape
    padding = int(0.15 * min(height, width))
    shape = (height + 2 * padding, width + 2 * padding)
    x, y, unit_x, unit_y, weight = _voters(field)
    votes = np.zeros((len(radii_px), *shape), np.float32)
    for index, radius in enumerate(radii_px):
        step_x, step_y = np.float32(radius) * unit_x, np.float32(radius) * unit_y
        column = (np.concatenate([x + step_x, x - step_x]) + padding).astype(np.int32)
        row = (np.concatenate([y + step_y, y - step_y]) + padding).astype(np.int32)
        inside = (column >= 0) & (row >= 0) & (column < shape[1]) & (row < shape[0])
        places = (row * shape[1] + column)[inside]
        total = np.bincount(places, np.concatenate([weight, weight])[inside], minlength=shape[0] * shape[1])
        sigma = 0.7 + 0.025 * radius
        smooth = cv2.GaussianBlur(total.reshape(shape).astype(np.float32), (0, 0), sigma)
        votes[index] = smooth * (sigma**2 / radius)  # 2 pi sigma^2 / (2 pi r)
    return votes, padding


def _voters(field: EdgeField) -> FloatArray:
    """Edge pixels as columns of (x, y, unit gradient x, y, weight); the weight is relative to the edges around."""
    magnitude = field.magnitude
    around = cv2.GaussianBlur(magnitude, (0, 0), 0.05 * min(magnitude.shape)) + np.float32(0.01)
    relative = magnitude / around
    chosen = _ridges(field) & (relative > 0.5) & (magnitude > 0.008)
    rows, columns = np.nonzero(chosen)
    strength = magnitude[chosen]
    return np.stack(
        [
            columns + 0.5,
            rows + 0.5,
            field.x[chosen] / strength,
            field.y[chosen] / strength,
            np.minimum(relative[chosen], 2.0) / 2.0,
        ]
    ).astype(np.float32)


def _peaks(votes: FloatArray, radii_px: FloatArray, padding: int) -> list[tuple[float, float, float]]:
    """The most significant peaks as (x, y, radius) in the small picture."""
    score = np.zeros_like(votes)
    for index, radius in enumerate(radii_px):
        typical = 1.3 * float(votes[index].mean())
        above = 1.3 * votes[index] > max(typical, 0.05)  # elsewhere no circle is worth a logarithm
        score[index][above] = np.pi * radius * divergence(1.3 * votes[index][above], typical)
    peaks: list[tuple[float, float, float]] = []
    best = score.max(axis=(1, 2))
    for _ in range(CANDIDATES):
        level = int(best.argmax())
        if best[level] <= 0.0:
            break
        row, column = np.unravel_index(int(score[level].argmax()), score[level].shape)
        radius = float(radii_px[level])
        peaks.append((float(column) - padding + 0.5, float(row) - padding + 0.5, radius))
        near = np.nonzero(np.abs(np.log(radii_px / radius)) < 0.1)[0]
        reach = 0.1 * radius + 1.0
        top, left = max(0, int(row - reach)), max(0, int(column - reach))
        for other in near:
            score[other, top : int(row + reach) + 1, left : int(column + reach) + 1] = 0.0
            best[other] = score[other].max()
    return peaks

"""The ring round a circle unrolled to (angle, radius), and circles and ellipses scored by the edges along them.

A mirrored ball's outline may be lighter or darker than what is behind it, and both on one ball, so only the direction of
an edge counts, never its sign. What tells a ball from other round things is the inside: a mirrored ball squeezes the
world into arcs along its rim, and nothing does so outside.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from ..model import BoolArray, FloatArray, Photograph
from .edges import EdgeField, edge_field
from .ellipse import full_turn, harmonics

ANGLES = 256
NEIGHBOURS, NOISE = 1.5, 0.012
"""An edge counts in full when its gradient is `NEIGHBOURS` times the mean one around plus `NOISE` per
pixel."""

FAINT, FAINT_COVERAGE, FAINT_SIGNIFICANCE = 0.1, 0.65, 80.0
"""For circles outside the chosen one: the `NEIGHBOURS` that lets faint edges count, and what they must reach. Round balls
found rightly the best such circle reaches 0.57; round a ring inside the ball the true rim reached 0.73."""

INSIDE_BAND, GAP_PX = 0.06, 1.5
"""Width in radii of the bands inside and outside a circle that are compared, and their distance from it in pixels of the
unrolled picture. Within a ball's rim gradients run across it: (radial^2 - tangential^2) / (radial^2 + tangential^2) is 0.6 to
0.9 there, in rooms and outdoors alike, and 0.0 to 0.3 just outside."""

SEARCH_WEIGHTS, REFINED_REACH, WORTH_WEIGHT = (1.5, 0.3), 0.03, 0.6
"""What that contrast counts for against the share of edges: when a circle is looked for, and when it is then laid on the edges,
within so many radii; and when outlines that lie on edges are compared."""

EVIDENCE_RADIUS_PX = 120.0
"""Radius to which a candidate is scaled before it is unrolled."""


@dataclass(frozen=True)
class Circle:
    """A circle in pixels of the photograph (pixel centres at integer + 0.5) and how much speaks for it.

    `coverage` is the share of the visible circumference with an edge along it, `significance` the log
    likelihood ratio (in nats) of that many edges against the edge density around it, `visible` the share of
    it within the frame. `contrast` says how much more things run along the circle just inside than just outside, at most 1.
    """

    x: float
    y: float
    radius: float
    coverage: float = 0.0
    significance: float = 0.0
    visible: float = 1.0
    contrast: float = 0.0

    @property
    def merit(self) -> float:
        """What speaks for its being a ball's outline: edges along it, and a squeezed world within."""
        return self.significance * max(self.contrast, 0.02)

    def moved(self, shift_px: FloatArray) -> Circle:
        """The circle elsewhere: `shift_px` (x, y) is added to its centre."""
        return replace(self, x=self.x + float(shift_px[0]), y=self.y + float(shift_px[1]))

    def scaled(self, size: float) -> Circle:
        """The circle in a picture of another size."""
        return replace(self, x=self.x * size, y=self.y * size, radius=self.radius * size)


@dataclass(frozen=True)
class PolarEvidence:
    """Edges along circles round a centre.

    `strength` (A, R) in 0..1 at `angles_rad` (A,) and `offsets_px` (R,) from the circle's radius; `visible`
    (A, R) is False where nothing can be seen; `scale` is the size of the unrolled picture over the photograph's;
    `inside_out` (A, R) says how much more things run along the circle just inside than just outside.
    """

    strength: FloatArray
    visible: BoolArray
    angles_rad: FloatArray
    offsets_px: FloatArray
    scale: float
    inside_out: FloatArray


def ring_field(
    photographs: Sequence[Photograph],
    shifts_px: Sequence[FloatArray],
    circle: tuple[float, float, float],
    level_radius_px: float,
    span: float,
) -> EdgeField:
    """The edges of a bracket in the box round a circle (x, y, radius) widened by `span` radii, at a given radius."""
    x, y, radius = circle
    scale = min(1.0, level_radius_px / radius)
    reach = (1.0 + span) * radius + 6.0 / scale
    return edge_field(photographs, shifts_px, (x - reach, y - reach, x + reach, y + reach), scale)


def polar_evidence(
    field: EdgeField,
    circle: Circle,
    span: float,
    bulge_px: FloatArray | None = None,
    neighbours: float = NEIGHBOURS,
) -> PolarEvidence:
    """Unroll the ring of +- `span` radii round a circle and find edges along it.

    `bulge_px` (A,) is added to the radius at each angle, where the outline is known not to be round.
    """
    scale = float(field.scale.mean())
    angles = full_turn(ANGLES)
    offsets = np.linspace(-span, span, int(4.0 * span * circle.radius * scale) + 5) * circle.radius
    radius = circle.radius + offsets + np.zeros((ANGLES, 1))
    if bulge_px is not None:
        radius += bulge_px[:, None]
    cosine, sine = np.cos(angles)[:, None], np.sin(angles)[:, None]
    map_x = ((circle.x + cosine * radius - field.corner_px[0]) * field.scale[0] - 0.5).astype(np.float32)
    map_y = ((circle.y + sine * radius - field.corner_px[1]) * field.scale[1] - 0.5).astype(np.float32)
    x, y, magnitude = (
        cv2.remap(one, map_x, map_y, cv2.INTER_LINEAR) for one in (field.x, field.y, field.magnitude)
    )
    visible = cv2.remap(field.inside.astype(np.float32), map_x, map_y, cv2.INTER_LINEAR) > 0.99
    radial = np.abs(x * cosine + y * sine)
    radial = np.where((radial > 0.9 * magnitude) & visible, radial, 0.0)
    around = cv2.blur(magnitude, (max(3, len(offsets) // 2) | 1, 15), borderType=cv2.BORDER_REPLICATE)
    peak = (radial >= np.roll(radial, 1, axis=1)) & (radial > np.roll(radial, -1, axis=1))
    strength = np.minimum(1.0, radial / (neighbours * around + NOISE))
    strength = np.where(peak, strength, 0.0).astype(np.float32)
    tolerance = np.exp(-0.5 * (np.arange(-4, 5) / 2.0) ** 2)[None].astype(np.float32)
    strength = np.minimum(cv2.filter2D(strength, -1, tolerance, borderType=cv2.BORDER_CONSTANT), 1.0)
    radially, along = (x * cosine + y * sine) ** 2, (y * cosine - x * sine) ** 2
    tangency = np.where(visible, (radially - along) / (radially + along + np.float32(NOISE**2)), 0.0)
    contrast = _inside_out(tangency, scale * (offsets[1] - offsets[0]), scale * circle.radius)
    return PolarEvidence(strength, visible, angles, offsets, scale, contrast)


def _inside_out(tangency: FloatArray, step_px: float, radius_px: float) -> FloatArray:
    """How much more tangential things are in a band just inside than in one just outside of each place (A, R)."""
    width = max(3, round(INSIDE_BAND * radius_px / step_px))
    gap = round(GAP_PX / step_px)
    sums = np.cumsum(np.pad(tangency, ((0, 0), (width + gap + 1, width + gap)), mode="edge"), axis=1)
    at = np.arange(tangency.shape[1]) + width + gap
    outside = sums[:, at + gap + width] - sums[:, at + gap]
    inside = sums[:, at - gap] - sums[:, at - gap - width]
    return np.asarray((inside - outside) / width)


def shares_along(
    evidence: PolarEvidence, change: FloatArray, every: int = 1
) -> tuple[FloatArray, FloatArray]:
    """Share of the visible circumference with edges, and share visible, of outlines changed by (N, 3 or 5)."""
    edges, count = _sums_along(evidence, evidence.strength, change, every)
    return edges / np.maximum(count, 1), count / len(evidence.angles_rad[::every])


def _sums_along(
    evidence: PolarEvidence, values: FloatArray, change: FloatArray, every: int
) -> tuple[FloatArray, FloatArray]:
    """Sums (N,) of values (A, R) along outlines where they are visible, and the number of places they are."""
    angles = evidence.angles_rad[::every]
    steps = len(evidence.offsets_px)
    step = evidence.offsets_px[1] - evidence.offsets_px[0]
    # A column of nothing on both sides takes in whatever leaves the ring.
    seen = np.pad(evidence.visible[::every], ((0, 0), (1, 1)))
    table = np.where(seen, np.pad(values[::every], ((0, 0), (1, 1))), 0.0).astype(np.float32)
    shape = (harmonics(angles, change.shape[1]).T / step).astype(np.float32)
    place = change.astype(np.float32) @ shape
    place += np.float32(1.5 - evidence.offsets_px[0] / step)
    np.clip(place, 0.0, steps + 1.0, out=place)
    index = place.astype(np.int32)
    index += np.arange(len(angles), dtype=np.int32) * (steps + 2)
    return table.ravel().take(index).sum(axis=1), seen.ravel().take(index).sum(axis=1, dtype=np.int32)


def best_circle(
    evidence: PolarEvidence, start: Circle, reach: float, weights: Sequence[float] = SEARCH_WEIGHTS
) -> Circle:
    """The circle within +- `reach` radii of `start` (in x, y and radius) that is most likely a ball's outline.

    First the one within which things run along it and outside which they do not: that is hardly ever mistaken, but blurred
    edges at the rim draw it outwards. Then, near that one, the circle that most edges lie along. `weights` are what the first
    counts for against the second in each of the steps.
    """
    best, contrast = np.zeros(3), 0.0
    for step, weight in enumerate(weights):
        value = evidence.strength + weight * evidence.inside_out
        most = reach if step == 0 else min(REFINED_REACH, reach)
        steps = np.linspace(-most, most, 13) * start.radius
        for every in (3, 1) if step == 0 else (2, 1, 1):  # some of the angles tell enough to begin with
            change = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3) + best
            total, count = _sums_along(evidence, value, change, every)
            visible = count / len(evidence.angles_rad[::every])
            score = total / np.maximum(count, 1) * visible**0.3  # leaving the frame must not pay
            best = change[int(score.argmax())]
            steps = np.linspace(-1.0, 1.0, 5) * (steps[1] - steps[0])
        if step == 0:
            total, count = _sums_along(evidence, evidence.inside_out, best[None], 1)
            contrast = float(total[0] / max(int(count[0]), 1))
    return replace(_judged(evidence, start, best), contrast=contrast)


def _judged(evidence: PolarEvidence, start: Circle, change: FloatArray) -> Circle:
    """The circle `start` changed by (x, y, radius), with what speaks for it."""
    share, visible = (float(value[0]) for value in shares_along(evidence, change[None]))
    seen = evidence.visible
    typical = float(evidence.strength[seen].mean()) if seen.any() else 1.0
    samples = np.pi * start.radius * evidence.scale  # one independent edge every two pixels
    x, y, radius = (float(value) for value in change[:3])
    return Circle(
        start.x + x,
        start.y + y,
        start.radius + radius,
        share,
        float(samples * visible * divergence(share, typical)),
        visible,
    )


def edges_along(evidence: PolarEvidence, change: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Strength of the edge (A,) along an outline, and where (A,) one could be seen."""
    offset = harmonics(evidence.angles_rad, len(change)) @ change
    column = np.abs(evidence.offsets_px[None] - offset[:, None]).argmin(axis=1)
    row = np.arange(ANGLES)
    shown = evidence.visible[row, column]
    return np.where(shown, evidence.strength[row, column], 0.0), shown


def worth(evidence: PolarEvidence, change: FloatArray) -> float:
    """Share of the visible rim with an edge along an outline changed by (3 or 5,), and its contrast for a part."""
    value = evidence.strength + WORTH_WEIGHT * evidence.inside_out
    total, count = _sums_along(evidence, value, change[None], 1)
    return float(total[0] / max(int(count[0]), 1) * (count[0] / ANGLES) ** 0.3)


def outermost(photographs: Sequence[Photograph], shifts_px: Sequence[FloatArray], circle: Circle) -> Circle:
    """The ball's own circle where `circle` may be one inside it, made by the edges of the wall behind the ball.

    That wall is reflected in a ring along the rim, and its edges can be far stronger than the rim
    itself, which shows the same wall on both sides. So a weak circle outside a strong one counts if it is there nearly
    all round; things behind the ball are not concentric with it.
    """
    for _ in range(2):
        field = ring_field(
            photographs, shifts_px, (circle.x, circle.y, circle.radius), EVIDENCE_RADIUS_PX, 0.2
        )
        evidence = polar_evidence(field, circle, 0.2, neighbours=FAINT)
        sideways = np.linspace(-0.08, 0.08, 17) * circle.radius
        outwards = np.arange(0.03, 0.16, 0.007) * circle.radius
        change = np.stack(np.meshgrid(sideways, sideways, outwards, indexing="ij"), axis=-1).reshape(-1, 3)
        around = np.hypot(change[:, 0], change[:, 1]) <= change[:, 2] + 0.005 * circle.radius
        change = change[around]  # only circles that hold this one
        share, visible = shares_along(evidence, change)
        share = np.where(visible > 0.8, share, 0.0)
        best = int(share.argmax())
        beyond = evidence.strength[:, evidence.offsets_px > 0.03 * circle.radius]
        samples = np.pi * circle.radius * evidence.scale * visible[best]
        significance = float(samples * divergence(float(share[best]), float(beyond.mean())))
        if share[best] < FAINT_COVERAGE or significance < FAINT_SIGNIFICANCE:
            break
        x, y, radius = (float(value) for value in change[best])
        circle = replace(
            circle.moved(np.array([x, y])),
            radius=circle.radius + radius,
            coverage=float(share[best]),
            significance=significance,
            visible=float(visible[best]),
        )
    return circle


def divergence(share: FloatArray | float, expected: FloatArray | float) -> FloatArray:
    """How surprising a share above the expected one is: the Kullback-Leibler divergence of two coins, in nats.

    Examples
    --------
    >>> float(divergence(0.5, 0.5)), round(float(divergence(0.9, 0.5)), 3)
    (0.0, 0.368)
    """
    k = np.clip(share, 1e-3, 0.999)
    p = np.clip(expected, 1e-3, 0.95)
    return np.where(k > p, k * np.log(k / p) + (1.0 - k) * np.log((1.0 - k) / (1.0 - p)), 0.0)

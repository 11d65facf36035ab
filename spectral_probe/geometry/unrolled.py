"""The ring round a circle unrolled to (angle, radius), and circles judged by the edges along them.

A mirrored ball's outline may be lighter or darker than what is behind it, and both on one ball, so only the direction of
an edge counts, never its sign.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..model import BoolArray, FloatArray, Photograph
from .edges import log_gradients, shrunk, strongest_channel
from .ellipse import full_turn

ANGLES = 256
NEIGHBOURS, NOISE = 1.5, 0.012
"""An edge counts in full when its gradient is `NEIGHBOURS` times the mean one around plus `NOISE` per
pixel."""

FAINT, FAINT_COVERAGE, FAINT_SIGNIFICANCE = 0.1, 0.65, 80.0
"""For circles outside the chosen one: the `NEIGHBOURS` that lets faint edges count, and what they must reach. Round balls
found rightly the best such circle reaches 0.57; round a ring inside the ball the true rim reached 0.73."""

INSIDE_BAND, INSIDE_WEIGHT = 0.08, 0.5
"""A mirrored ball squeezes the world into arcs along its rim, and nothing does so outside. Of circles with
much the same edges, the one with more arcs in a band of 8 % of the radius inside it than outside is
preferred."""

EVIDENCE_RADIUS_PX = 120.0
"""Radius to which a candidate is scaled before it is unrolled."""


@dataclass(frozen=True)
class Circle:
    """A circle in pixels of the photograph (pixel centres at integer + 0.5) and how much speaks for it.

    `coverage` is the share of the visible circumference with an edge along it, `significance` the log
    likelihood ratio (in nats) of that many edges against the edge density around it, `visible` the share of
    it within the frame.
    """

    x: float
    y: float
    radius: float
    coverage: float = 0.0
    significance: float = 0.0
    visible: float = 1.0

    def moved(self, shift_px: FloatArray) -> Circle:
        """The circle elsewhere: `shift_px` (x, y) is added to its centre."""
        return replace(self, x=self.x + float(shift_px[0]), y=self.y + float(shift_px[1]))


@dataclass(frozen=True)
class PolarEvidence:
    """Edges along circles round a centre.

    `strength` (A, R) in 0..1 at `angles_rad` (A,) and `offsets_px` (R,) from the circle's radius; `visible`
    (A, R) is False outside the frame; `scale` is the size of the unrolled picture over the photograph's.
    """

    strength: FloatArray
    visible: BoolArray
    angles_rad: FloatArray
    offsets_px: FloatArray
    scale: float
    inside_out: FloatArray


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


def harmonics(angles_rad: FloatArray, count: int) -> FloatArray:
    """The first `count` of cos, sin, 1, cos 2a, sin 2a (A, count): changes of x, y, radius and ellipticity."""
    turns = [np.cos(angles_rad), np.sin(angles_rad), np.ones_like(angles_rad)]
    turns += [np.cos(2.0 * angles_rad), np.sin(2.0 * angles_rad)]
    return np.stack(turns[:count], axis=-1)


def polar_evidence(
    photographs: Sequence[Photograph],
    shifts_px: Sequence[FloatArray],
    circle: Circle,
    level_radius_px: float,
    span: float,
    bulge_px: FloatArray | None = None,
    neighbours: float | None = None,
) -> PolarEvidence:
    """Unroll the ring of +- `span` radii round a circle, at `level_radius_px`, and find edges along it.

    The gradients of log radiance do not depend on the exposure: those of all photographs are averaged, each
    weighted by how well it is exposed there. The ball of each photograph lies `shifts_px` from the circle.
    `bulge_px` (A,) is added to the radius at each angle, where the outline is known not to be round.
    """
    import cv2

    scale = min(1.0, level_radius_px / circle.radius)
    angles = full_turn(ANGLES)
    offsets = np.linspace(-span, span, int(4.0 * span * circle.radius * scale) + 5) * circle.radius
    radius = circle.radius + offsets + np.zeros((ANGLES, 1))
    if bulge_px is not None:
        radius += bulge_px[:, None]
    x = circle.x + np.cos(angles)[:, None] * radius
    y = circle.y + np.sin(angles)[:, None] * radius
    fields = [
        _polar_gradients(one, x + shift[0], y + shift[1], scale)
        for one, shift in zip(photographs, shifts_px, strict=True)
    ]
    total = np.sum([weight for _, _, weight in fields], axis=0)
    along_x, along_y = (
        np.sum([field[axis] * field[2][..., None] for field in fields], axis=0) / total[..., None]
        for axis in (0, 1)
    )
    gradients = strongest_channel(along_x, along_y)
    radial = np.abs(gradients.x * np.cos(angles)[:, None] + gradients.y * np.sin(angles)[:, None])
    height, width = photographs[0].clipped.shape
    x, y = x + shifts_px[0][0], y + shifts_px[0][1]
    margin = 1.0 / scale
    visible = (x > margin) & (y > margin) & (x < width - margin) & (y < height - margin)
    radial = np.where((radial > 0.9 * gradients.magnitude) & visible, radial, 0.0)
    around = cv2.blur(
        gradients.magnitude, (max(3, len(offsets) // 2) | 1, 15), borderType=cv2.BORDER_REPLICATE
    )
    peak = (radial >= np.roll(radial, 1, axis=1)) & (radial > np.roll(radial, -1, axis=1))
    strength = np.minimum(1.0, radial / ((NEIGHBOURS if neighbours is None else neighbours) * around + NOISE))
    strength = np.where(peak, strength, 0.0).astype(np.float32)
    tolerance = np.exp(-0.5 * (np.arange(-4, 5) / 2.0) ** 2)[None].astype(np.float32)
    strength = cv2.filter2D(strength, -1, tolerance, borderType=cv2.BORDER_CONSTANT)
    strength = np.minimum(strength, 1.0)
    contrast = _inside_out(strength, scale * (offsets[1] - offsets[0]), scale * circle.radius)
    return PolarEvidence(strength, visible, angles, offsets, scale, contrast)


def _inside_out(strength: FloatArray, step_px: float, radius_px: float) -> FloatArray:
    """How many more edges run along the circle just inside than just outside of each place."""
    width = max(2, round(INSIDE_BAND * radius_px / step_px))
    gap = round(2.0 / step_px)
    sums = np.cumsum(np.pad(strength, ((0, 0), (width + gap + 1, width + gap)), mode="edge"), axis=1)
    n = strength.shape[1]
    at = np.arange(n) + width + gap
    outside = sums[:, at + gap + width] - sums[:, at + gap]
    inside = sums[:, at - gap] - sums[:, at - gap - width]
    return (inside - outside) / width


def _polar_gradients(
    photograph: Photograph, x: FloatArray, y: FloatArray, scale: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Gradients (A, R, 3) along x and y, and the weight (A, R), of a photograph scaled down, at places in it."""
    import cv2

    height, width = photograph.clipped.shape
    reach = 6.0 / scale
    left, top = (int(np.clip(a.min() - reach, 0, side - 8)) for a, side in ((x, width), (y, height)))
    right = int(np.clip(x.max() + reach + 1, left + 8, width))
    bottom = int(np.clip(y.max() + reach + 1, top + 8, height))
    picture = shrunk(photograph.pixels[top:bottom, left:right], scale)
    along_x, along_y = log_gradients(picture, photograph)
    level = picture.max(axis=-1)
    weight = np.minimum(level / 0.05, 1.0)
    if not photograph.scene_referred_float:
        weight *= np.clip((0.97 - level) / 0.2, 0.0, 1.0)
    weight = cv2.erode(weight.astype(np.float32), np.ones((3, 3), np.uint8)) + np.float32(1e-3)
    map_x = ((x - left) * (picture.shape[1] / (right - left)) - 0.5).astype(np.float32)
    map_y = ((y - top) * (picture.shape[0] / (bottom - top)) - 0.5).astype(np.float32)
    along_x, along_y, weight = (
        cv2.remap(a, map_x, map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        for a in (along_x, along_y, weight)
    )
    return along_x, along_y, weight


def best_circle(evidence: PolarEvidence, start: Circle, reach: float) -> Circle:
    """The circle within +- `reach` radii of `start` (in x, y and radius) that has most edges along it."""
    steps = np.linspace(-reach, reach, 13) * start.radius
    best, best_share, best_visible = np.zeros(3), 0.0, 1.0
    for every in (3, 1, 1):  # a third of the angles tells enough to begin with
        change = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3) + best
        share, visible, contrast = shares_along(evidence, change, every)
        score = (share + INSIDE_WEIGHT * contrast) * visible**0.3  # leaving the frame must not pay
        top = int(score.argmax())
        best, best_share, best_visible = change[top], float(share[top]), float(visible[top])
        steps = np.linspace(-1.0, 1.0, 5) * (steps[1] - steps[0])
    seen = evidence.visible
    typical = float(evidence.strength[seen].mean()) if seen.any() else 1.0
    samples = np.pi * start.radius * evidence.scale * best_visible  # one independent edge every two pixels
    return Circle(
        start.x + float(best[0]),
        start.y + float(best[1]),
        start.radius + float(best[2]),
        coverage=best_share,
        significance=float(samples * divergence(best_share, typical)),
        visible=best_visible,
    )


def outermost(photographs: Sequence[Photograph], circle: Circle) -> Circle:
    """The ball's own circle where `circle` may be one inside it, made by the edges of the wall behind the ball.

    That wall is reflected in a ring along the rim, and its edges can be far stronger than the rim
    itself, which shows the same wall on both sides. So a weak circle outside a strong one counts if it is there nearly
    all round; things behind the ball are not concentric with it.
    """
    still = [np.zeros(2)] * len(photographs)
    for _ in range(2):
        evidence = polar_evidence(photographs, still, circle, EVIDENCE_RADIUS_PX, 0.2, neighbours=FAINT)
        sideways = np.linspace(-0.08, 0.08, 17) * circle.radius
        outwards = np.arange(0.03, 0.16, 0.007) * circle.radius
        change = np.stack(np.meshgrid(sideways, sideways, outwards, indexing="ij"), axis=-1).reshape(-1, 3)
        around = np.hypot(change[:, 0], change[:, 1]) <= change[:, 2] + 0.005 * circle.radius
        change = change[around]  # only circles that hold this one
        share, visible, _ = shares_along(evidence, change)
        share = np.where(visible > 0.8, share, 0.0)
        best = int(share.argmax())
        beyond = evidence.strength[:, evidence.offsets_px > 0.03 * circle.radius]
        samples = np.pi * circle.radius * evidence.scale * visible[best]
        significance = float(samples * divergence(float(share[best]), float(beyond.mean())))
        if share[best] < FAINT_COVERAGE or significance < FAINT_SIGNIFICANCE:
            break
        x, y, radius = (float(value) for value in change[best])
        circle = Circle(
            circle.x + x,
            circle.y + y,
            circle.radius + radius,
            float(share[best]),
            significance,
            float(visible[best]),
        )
    return circle


def shares_along(
    evidence: PolarEvidence, change: FloatArray, every: int = 1
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Share of the visible circumference with edges, and share visible, of outlines changed by (N, 3 or 5)."""
    angles = evidence.angles_rad[::every]
    offset = change @ harmonics(angles, change.shape[1]).T
    step = evidence.offsets_px[1] - evidence.offsets_px[0]
    column = np.round((offset - evidence.offsets_px[0]) / step).astype(int)
    inside = (column >= 0) & (column < len(evidence.offsets_px))
    column = np.clip(column, 0, len(evidence.offsets_px) - 1)
    row = np.arange(len(evidence.angles_rad))[None, ::every]
    visible = evidence.visible[row, column] & inside
    edges = np.where(visible, evidence.strength[row, column], 0.0).sum(axis=1)
    count = visible.sum(axis=1)
    contrast = np.where(visible, evidence.inside_out[row, column], 0.0).sum(axis=1)
    return edges / np.maximum(count, 1), count / len(angles), contrast / np.maximum(count, 1)

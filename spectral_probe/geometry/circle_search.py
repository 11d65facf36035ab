"""Circles in a photograph that could be a mirrored ball's outline, to a few thousandths of the radius.

Two steps: edge pixels of a small logarithmic picture vote along their gradients for centres at many radii;
the best candidates are then unrolled to (angle, radius) and scored by the share of the circumference that
has an edge along it. A mirrored ball's outline may be lighter or darker than what is behind it, and both on
one ball, so only the direction of an edge counts, never its sign.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..model import BoolArray, FloatArray, Photograph

SHORT_SIDE_PX = 360
"""Short side of the small picture that votes."""

RADIUS_RANGE = (0.03, 0.62)
"""Radii looked for, as shares of the short side; over half a side, so that a ball cut by the frame is found
too."""

CANDIDATES = 16
CLEAR_COVERAGE, CLEAR_SIGNIFICANCE = 0.6, 150.0
"""With a circle as clear as this among the first, no further candidates are looked at."""

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
    edges = [_strongest_channel(*log_gradients(shrunk(one.pixels, scale), one)) for one in photographs]
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


# ---------------------------------------------------------------- edges


@dataclass(frozen=True)
class Gradients:
    """Gradient of log radiance (H, W) by components, of whichever colour channel has the strongest."""

    x: FloatArray
    y: FloatArray
    magnitude: FloatArray


def shrunk(pixels: FloatArray, scale: float) -> FloatArray:
    """A picture (H, W, 3) reduced by averaging; scale 1 leaves it alone."""
    import cv2

    if scale >= 1.0:
        return pixels
    height, width = pixels.shape[:2]
    size = (max(4, round(width * scale)), max(4, round(height * scale)))
    return np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA))


def log_gradients(pixels: FloatArray, photograph: Photograph) -> tuple[FloatArray, FloatArray]:
    """Gradient (x, y), each (H, W, 3), of the logarithm of a picture that was cut from `photograph`."""
    import cv2

    if photograph.scene_referred_float:
        floor, top = 0.01 * max(float(np.median(pixels)), 1e-6), np.inf
    else:
        floor, top = (0.01 if photograph.display_referred else 0.002), 1.0
    logarithm = np.log(np.clip(pixels, 0.0, top) + floor).astype(np.float32)
    logarithm = cv2.GaussianBlur(logarithm, (0, 0), 1.0)
    along_x = cv2.Scharr(logarithm, cv2.CV_32F, 1, 0) / 32.0
    along_y = cv2.Scharr(logarithm, cv2.CV_32F, 0, 1) / 32.0
    return np.asarray(along_x), np.asarray(along_y)


def _strongest_channel(along_x: FloatArray, along_y: FloatArray) -> Gradients:
    """Of gradients by channel (..., 3), that of the channel where it is the strongest."""
    magnitude = np.hypot(along_x, along_y)
    channel = magnitude.argmax(axis=-1)[..., None]
    x, y, m = (np.take_along_axis(a, channel, axis=-1)[..., 0] for a in (along_x, along_y, magnitude))
    return Gradients(x, y, m)


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


# ---------------------------------------------------------------- votes


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


# ---------------------------------------------------------------- unrolled


def full_turn(count: int) -> FloatArray:
    """`count` angles spread evenly over a turn, in radians."""
    return (np.arange(count) + 0.5) * (2.0 * np.pi / count)


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
    gradients = _strongest_channel(along_x, along_y)
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

"""A ball on a ground under sky and window, seen from above: rendered with and without it by shared samples of a few lines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from spectral_probe.composite_model import ObjectCoverage

type Array = npt.NDArray[np.floating[Any]]

_WINDOW = np.array([0.6, 0.3, 0.74]) / np.linalg.norm([0.6, 0.3, 0.74])
BALL = np.array([0.35, 0.08, 0.05])
GROUND = 0.5


@dataclass(frozen=True)
class Simulation:
    """`with_`, `without` (H, W, 3), the ball's coverage, and each pixel's distance from its centre in radii."""

    with_: Array
    without: Array
    coverage: ObjectCoverage
    distance: Array


def simulate(size: int, samples: int, *, seed: int = 0, across: float = 8.0) -> Simulation:
    """Render `across` radii of ground, the ball in the middle."""
    random = np.random.default_rng(seed)
    rows, columns = np.mgrid[:size, :size]
    with_, without = np.zeros((2, size, size, 3))
    covered = np.zeros((size, size))
    for _ in range(samples):
        x = ((columns + random.random((size, size))) / size - 0.5) * across
        y = ((rows + random.random((size, size))) / size - 0.5) * across
        share, turn = random.random((2, size, size))
        reach = np.sqrt(share)
        direction = np.stack(
            [reach * np.cos(2 * np.pi * turn), reach * np.sin(2 * np.pi * turn), np.sqrt(1 - share)], -1
        )
        sky = (0.6 + 0.4 * direction[..., 2:]) * np.array([0.9, 1.0, 1.2])
        sky += 14 * np.exp(60 * (direction @ _WINDOW - 1))[..., None] * np.array([1.2, 1.0, 0.8])
        from_centre = np.stack([x, y, np.full_like(x, -1.0)], -1)
        towards = (from_centre * direction).sum(-1)
        meets = (towards < 0) & (towards**2 > (from_centre**2).sum(-1) - 1)
        on_ball = x**2 + y**2 < 1
        covered += on_ball
        without += GROUND * sky
        with_ += np.where(on_ball[..., None], BALL, GROUND * np.where(meets[..., None], BALL, sky))
    cover = (covered / samples).astype(np.float32)
    distance = np.hypot((columns + 0.5) / size - 0.5, (rows + 0.5) / size - 0.5) * across
    return Simulation(
        (with_ / samples).astype(np.float32),
        (without / samples).astype(np.float32),
        ObjectCoverage({"ball": cover}, cover, 1 - cover),
        distance,
    )


@pytest.fixture(scope="session")
def exact() -> Simulation:
    """With so many samples that their noise does not count."""
    return simulate(96, 800, seed=9)


@pytest.fixture(scope="session")
def noisy() -> Simulation:
    """With as few as a preview has."""
    return simulate(96, 16, seed=1)


@pytest.fixture(scope="session")
def wide() -> Simulation:
    """Much ground round a small ball."""
    return simulate(160, 8, seed=2, across=30.0)

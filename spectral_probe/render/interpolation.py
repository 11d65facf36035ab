"""How a scene's transport at a few wavelengths tells it at all of them.

Transport, what a scene does with light between lamp and camera, is a sum of products of the scene's own reflectances. The
covariance of random ones says how its value at one wavelength follows from its values at others: best linear prediction,
under the constraint that constants are kept (ordinary kriging; Cressie, Statistics for Spatial Data, 1993, sect. 3.2). The
wavelengths are chosen one after another, and then exchanged one by one, to make the expected error in a linearised CIELAB
smallest.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..model import FloatArray
from ..spectra.colorimetry import colour_matching_functions, white_xyz
from ..spectra.grid import STEP_NM

NUGGET = 1e-6
"""Share of the mean variance added on the diagonal: keeps the interpolation from amplifying noise."""

MOST_BOUNCES = 3
"""Reflections in a path of light, at most, by which errors are predicted."""

_DARK = 0.01
"""Luminance below which an error is not weighed higher for being in the dark: there CIELAB is nearly linear."""


def random_products(surfaces: FloatArray, count: int, seed: int) -> FloatArray:
    """Random products of one to three reflectances, (count, L), of the surfaces (N, L)."""
    generator = np.random.default_rng(seed)
    factors = np.array(surfaces[generator.integers(len(surfaces), size=(count, MOST_BOUNCES))], float)
    bounces = generator.integers(1, MOST_BOUNCES + 1, size=count)
    factors[np.arange(MOST_BOUNCES) >= bounces[:, None]] = 1.0
    return np.asarray(factors.prod(1))


def path_shares(count: int, seed: int) -> FloatArray:
    """Shares (2, count), summing to one, of two paths that reach a pixel; half of the pixels are reached by one only."""
    generator = np.random.default_rng(seed)
    second = generator.random(count) * (generator.random(count) < 0.5)
    return np.stack([1.0 - second, second])


def second_moment(samples: FloatArray) -> FloatArray:
    """Second moment (L, L) of spectra (N, L), each weighed by how CIELAB sees an error in it, with a nugget."""
    luminance = np.maximum(samples @ colour_matching_functions()[:, 1], 0.0)
    luminance = luminance / colour_matching_functions()[:, 1].sum()
    scaled = samples * np.maximum(luminance, _DARK)[:, None] ** (-2.0 / 3.0)
    moment = scaled.T @ scaled / len(scaled)
    size = len(moment)
    return np.asarray(moment + NUGGET * np.trace(moment) / size * np.eye(size))


def lab_metric(lights: FloatArray) -> FloatArray:
    """(L, L) matrix G: the squared error of a transport e (L,) in linearised CIELAB is e G e, in the mean over the lights.

    The lights (M, L) are of luminance 1, and the white is that of D65.
    """
    cmf = colour_matching_functions() * STEP_NM
    to_lab = np.array([[0.0, 116.0, 0.0], [500.0, -500.0, 0.0], [0.0, 200.0, -200.0]]) / 3.0
    seen = (cmf / white_xyz()) @ to_lab.T
    return np.asarray((seen @ seen.T) * (lights.T @ lights) / len(lights))


def interpolation_weights(
    nodes: Sequence[int], moment: FloatArray, *, keep_constants: bool = True
) -> FloatArray:
    """(P, L) weights by which values at the nodes predict those at every wavelength.

    Parameters
    ----------
    nodes
        (P,) indices of the wavelengths that are known.
    moment
        (L, L) second moment of what is predicted.
    keep_constants
        Predict a constant exactly: the columns sum to one.
    """
    size, rows = len(nodes), list(nodes)
    within, target = moment[np.ix_(rows, rows)], moment[rows]
    if keep_constants:
        system = np.ones((size + 1, size + 1))
        system[size, size] = 0.0
        system[:size, :size] = within
        target = np.concatenate([target, np.ones((1, len(moment)))])
        weights: FloatArray = np.linalg.solve(system, target)[:size]
    else:
        weights = np.linalg.solve(within, target)
    weights[:, rows] = np.eye(size)  # the nugget would blur what is known exactly
    return weights


class NodeChoice:
    """The best wavelengths for predicting samples of a second moment, by how the metric sees the errors.

    `nodes(n)` are n indices in ascending order. Each size starts from the one before.
    """

    def __init__(self, moment: FloatArray, metric: FloatArray, *, keep_constants: bool = True) -> None:
        self.moment, self.metric, self.keep_constants = moment, metric, keep_constants
        self._chosen: list[list[int]] = [[]]

    def nodes(self, count: int) -> list[int]:
        """Indices of this many wavelengths."""
        while len(self._chosen) <= count:
            self._chosen.append(self._exchanged(self._added(self._chosen[-1])))
        return sorted(self._chosen[count])

    def weights(self, count: int) -> FloatArray:
        """The interpolation (count, L) from them."""
        return interpolation_weights(self.nodes(count), self.moment, keep_constants=self.keep_constants)

    def _unexplained(self, nodes: Sequence[int]) -> FloatArray:
        """Second moment (L, L) of what the nodes leave open."""
        left = self.moment.copy()
        for number, node in enumerate(nodes):
            row = left[node]
            if (
                number == 0 and self.keep_constants
            ):  # a constant of unknown size: the limit of a large variance
                left = left - row - row[:, None] + row[node]
            elif row[node] > 0:
                left = left - np.outer(row, row) / row[node]
        return left

    def expected_error(self, nodes: Sequence[int]) -> float:
        """Expected squared error of the interpolation from some nodes, in the metric."""
        return float((self._unexplained(nodes) * self.metric).sum())

    def _added(self, nodes: list[int]) -> list[int]:
        """The nodes and the one that explains most of the error they leave."""
        left = self._unexplained(nodes)
        if not nodes and self.keep_constants:
            return [min(range(len(left)), key=lambda node: self.expected_error([node]))]
        variance = np.diagonal(left)
        explained = np.einsum("ij,jk,ik->i", left, self.metric, left, optimize=True)
        gain = np.where(variance > 1e-9 * np.trace(self.moment), explained, 0.0) / np.maximum(
            variance, 1e-300
        )
        gain[nodes] = -1.0
        return [*nodes, int(np.argmax(gain))]

    def _exchanged(self, nodes: list[int]) -> list[int]:
        """Move each node in turn to where the error is smallest, once round; never makes the error larger."""
        if len(nodes) in (1, len(self.moment)):
            return nodes
        for _ in range(len(nodes)):
            nodes = self._added(nodes[1:])
        return nodes

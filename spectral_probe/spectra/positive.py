"""Spectra without negative power, held by weights of a basis."""

from __future__ import annotations

import numpy as np

from ..errors import SpectralDataError
from ..model import FloatArray, IntArray
from ..parallel import product

_CLIPPINGS = 3
"""How often negative parts are cut off and what is left is brought back into the span of the basis."""

_MARGIN = np.float32(1e-5)
"""Lowest value of a spectrum, relative to the basis's positive spectrum of its size, that counts as positive: above rounding."""

_TINY = np.float32(1e-30)


def positive_weights(basis: FloatArray, lights: FloatArray) -> FloatArray:
    """Weights (K,) of a spectrum that is positive throughout.

    That is the mean light, or the light whose projection into the basis has the highest minimum.

    Parameters
    ----------
    basis
        (K, L) orthonormal functions.
    lights
        (N, L).

    Raises
    ------
    SpectralDataError
        If there is none.

    Examples
    --------
    >>> positive_weights(np.eye(2), np.array([[1.0, 3.0], [3.0, 1.0]])).tolist()
    [1.0, 1.0]
    """
    relative = (lights / lights.mean(-1, keepdims=True)) @ basis.T
    candidates = np.concatenate([relative.mean(0, keepdims=True), relative])
    lowest = (candidates @ basis).min(-1)
    if lowest.max() <= 0:
        raise SpectralDataError(
            "No light of these families is positive in their basis. Choose fewer lamp families."
        )
    return np.asarray(candidates[0] if lowest[0] > 0.02 else candidates[int(lowest.argmax())])


def negative(weights: FloatArray, functions: FloatArray, safe: FloatArray) -> IntArray:
    """Numbers of the weights (K, P) whose spectra have parts that are not positive.

    Parameters
    ----------
    weights
        (K, P) float32.
    functions
        (K, L) float32 of the basis.
    safe
        (K,) `positive_weights`.

    Examples
    --------
    >>> spectra = np.array([[1.0, 2.0], [1.0, -1.0]], np.float32)
    >>> negative(spectra, np.eye(2, dtype=np.float32), np.ones(2, np.float32)).tolist()
    [1]
    """
    safe_size = _size(weights, functions, safe) * safe[:, None]
    above_floor = product(functions.T, weights - _MARGIN * safe_size)
    return np.flatnonzero(above_floor.min(0) <= 0)


def lifted(
    weights: FloatArray, columns: FloatArray, functions: FloatArray, seen: FloatArray, safe: FloatArray
) -> FloatArray:
    """Without negative parts: clipped, brought back into the span, and to the level that the responses have.

    A last move towards a positive spectrum, just as far as it takes, removes what the span cannot.

    Parameters
    ----------
    weights, functions, safe
        As in `negative`.
    columns
        (C, P) camera responses.
    seen
        (K, C) responses to the functions.
    """
    for _ in range(_CLIPPINGS):
        spectra = product(functions.T, weights)
        np.maximum(spectra, 0, out=spectra)
        weights = product(functions, spectra)
    fitted = product(seen.T, weights)
    level = (fitted * columns).sum(0) / np.maximum((fitted * fitted).sum(0), _TINY)
    weights = weights * np.maximum(level, 0)
    size = _size(weights, functions, safe)
    goal = (functions.T @ safe)[:, None] * size
    spectra = product(functions.T, weights)
    floor = _MARGIN * goal
    gap = np.maximum(goal - spectra, _TINY)
    share = np.where(spectra < floor, (2 * floor - spectra) / gap, 0).max(0)
    return np.asarray(weights + np.clip(share, 0, 1) * (size * safe[:, None] - weights))


def _size(weights: FloatArray, functions: FloatArray, safe: FloatArray) -> FloatArray:
    """Factors (P,) that give the positive spectrum the sizes of the spectra of weights (K, P)."""
    sums = functions.sum(-1)
    return np.asarray(np.maximum((sums[:, None] * weights).sum(0) / (sums * safe).sum(), 0))

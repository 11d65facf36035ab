"""Bases for spectra of light: principal components (eq. 7), and the smallest basis that holds given spectra."""

from __future__ import annotations

import numpy as np

from ..model import FloatArray


def principal_components(lights: FloatArray, components: int) -> FloatArray:
    """First principal components of a set of lights, without centring (eq. 7).

    Parameters
    ----------
    lights
        (N, L) spectra; their levels count, so give them unit norm where every light is to count alike.
    components
        K, how many.

    Returns
    -------
    ndarray
        (K, L) orthonormal basis functions; each has a positive sum.

    Examples
    --------
    >>> from .library import training_lights
    >>> basis = principal_components(training_lights(["daylight"]), 3)
    >>> bool(np.allclose(basis @ basis.T, np.eye(3)))
    True
    """
    _, _, rows = np.linalg.svd(lights, full_matrices=False)
    basis = rows[:components]
    return basis * np.where(basis.sum(-1, keepdims=True) < 0, -1.0, 1.0)


def spanning(spectra: FloatArray, most: int, tolerance: float, first: FloatArray | None = None) -> FloatArray:
    """The fewest orthonormal functions that hold spectra.

    Parameters
    ----------
    spectra
        (N, L), none of them black.
    most
        Functions at most.
    tolerance
        Relative error that any of the spectra may have; 0 for `most` functions whatever they are needed for.
    first
        (M, L) spectra that must be held exactly, M <= `most`.

    Returns
    -------
    ndarray
        (K, L), M <= K <= `most`.

    Examples
    --------
    >>> spanning(np.array([[1.0, 1.0, 0.0], [2.0, 0.0, 0.0], [3.0, 1.0, 0.0]]), 3, 1e-6).shape
    (2, 3)
    """
    fixed = (
        np.zeros((0, spectra.shape[1])) if first is None else np.linalg.qr(np.asarray(first, float).T)[0].T
    )
    spectra = spectra / np.linalg.norm(spectra, axis=-1, keepdims=True)
    rest = spectra - spectra @ fixed.T @ fixed
    _, vectors = np.linalg.eigh(rest.T @ rest)
    found = np.concatenate([fixed, vectors.T[::-1]])[:most]
    basis = np.linalg.qr(found.T)[0].T
    count = most
    while tolerance > 0 and count > max(1, len(fixed)):
        if not_held(spectra, basis[: count - 1]) > tolerance:
            break
        count -= 1
    return np.asarray(basis[:count])


def not_held(spectra: FloatArray, basis: FloatArray) -> float:
    """Largest share of the norm of any of the spectra (N, L) that orthonormal functions (K, L) do not hold.

    Examples
    --------
    >>> not_held(np.array([[3.0, 4.0]]), np.array([[1.0, 0.0]]))
    0.8
    """
    rest = spectra - spectra @ basis.T @ basis
    norms = np.linalg.norm(spectra, axis=-1)
    return float((np.linalg.norm(rest, axis=-1) / np.maximum(norms, 1e-30)).max(initial=0.0))

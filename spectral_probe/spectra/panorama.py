"""Spectra of a panorama's directions, which it holds as weights of bases, some rows at a time."""

from __future__ import annotations

import numpy as np

from ..large import let_go
from ..model import FloatArray, SpectralPanorama
from ..parallel import in_parallel, product, row_blocks


def panorama_spectra(panorama: SpectralPanorama, rows: slice) -> FloatArray:
    """Spectral radiance of some rows, an image for each wavelength: (L, h, W) float32, per nm."""
    index = panorama.basis_index[rows]
    weights = panorama.weights[rows].reshape(index.size, -1)
    functions = panorama.bases.astype(np.float32)
    used = np.unique(index)
    if len(used) == 1:
        return product(functions[used[0]].T, weights.T).reshape(-1, *index.shape)
    spectra = np.empty((functions.shape[-1], index.size), np.float32)
    for basis in used:
        chosen = np.flatnonzero(index == basis)
        spectra[:, chosen] = product(functions[basis].T, weights[chosen].T)
    return spectra.reshape(-1, *index.shape)


def negative_fraction(panorama: SpectralPanorama) -> float:
    """Share of the spectral samples of all directions that are below zero: only the paper's method leaves any."""

    def negative(rows: slice) -> int:
        count = int((panorama_spectra(panorama, rows) < 0).sum())
        let_go(panorama.weights)
        return count

    height, width = panorama.valid.shape
    count = sum(in_parallel(negative, row_blocks(width, height)))
    return float(count / (panorama.valid.size * panorama.bases.shape[-1]))

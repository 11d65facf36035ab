"""Spectra without negative parts."""

import numpy as np

from spectral_probe.spectra.positive import lifted, negative


def test_negative_spectra_are_found_and_become_positive_at_their_level():
    functions = np.linalg.qr(np.random.default_rng(0).random((61, 3)))[0].T.astype(np.float32)
    safe = (functions @ np.ones(61)).astype(np.float32)
    if (functions.T @ safe).min() <= 0:
        safe = (functions @ (functions.T @ safe > 0)).astype(np.float32)
    dented = safe + np.float32(6) * np.array([0, 1, 0], np.float32)
    weights = np.stack([safe, dented], axis=-1)
    low = negative(weights, functions, safe)
    seen = (functions @ np.random.default_rng(1).random((61, 3))).astype(np.float32)
    columns = seen.T @ weights
    found = lifted(weights[:, low], columns[:, low], functions, seen, safe)
    assert low.tolist() == [1]
    assert (functions.T @ found).min() > 0

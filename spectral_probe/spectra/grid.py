"""The wavelength grid on which spectra are exchanged: 400-700 nm in 5 nm steps, 61 samples, the paper's."""

from __future__ import annotations

import numpy as np

from ..errors import SpectralDataError
from ..model import FloatArray

STEP_NM = 5.0
WAVELENGTHS_NM: FloatArray = np.arange(400.0, 700.0 + STEP_NM / 2, STEP_NM)
WAVELENGTHS_NM.flags.writeable = False


def resample(
    wavelengths_nm: FloatArray,
    values: FloatArray,
    onto_nm: FloatArray = WAVELENGTHS_NM,
    *,
    name: str = "the spectrum",
) -> FloatArray:
    """Sampled spectra onto another wavelength grid, piecewise linearly.

    Parameters
    ----------
    wavelengths_nm
        (N,) wavelengths of the samples, in any order.
    values
        (..., N) samples.
    onto_nm
        (L,) the grid wanted.
    name
        What the spectrum is called in an error message.

    Returns
    -------
    ndarray
        (..., L).

    Raises
    ------
    SpectralDataError
        If the samples do not cover `onto_nm`.

    Examples
    --------
    >>> resample(np.array([400.0, 700.0]), np.array([0.0, 3.0]), np.array([400.0, 500.0, 700.0])).tolist()
    [0.0, 1.0, 3.0]
    """
    order = np.argsort(wavelengths_nm)
    known, values = np.asarray(wavelengths_nm, float)[order], np.asarray(values, float)[..., order]
    first, last = float(onto_nm.min()), float(onto_nm.max())
    if len(known) < 2 or known[0] > first or known[-1] < last:
        covered = f"{known[0]:g}-{known[-1]:g} nm" if len(known) else "no wavelength"
        raise SpectralDataError(
            f"{name} covers {covered}, but {first:g}-{last:g} nm is needed. Give a file that covers it."
        )
    rows = values.reshape(-1, len(known))
    return np.stack([np.interp(onto_nm, known, row) for row in rows]).reshape(
        (*values.shape[:-1], len(onto_nm))
    )


def resampling_matrix(
    wavelengths_nm: FloatArray, onto_nm: FloatArray = WAVELENGTHS_NM, *, name: str = "the spectrum"
) -> FloatArray:
    """Matrix (N, L) that takes samples (..., N) onto another grid, as `resample` does; for images, in one product.

    A sample stands for the light half a step to both sides of it: the first and the last are continued that far.

    Raises
    ------
    SpectralDataError
        If the samples do not cover `onto_nm`.

    Examples
    --------
    >>> buckets_nm = np.array([402.5, 500.0, 697.5])
    >>> (np.array([1.0, 2.0, 4.0]) @ resampling_matrix(buckets_nm))[[0, 20, 60]].tolist()
    [1.0, 2.0, 4.0]
    """
    order = np.argsort(wavelengths_nm)
    known, identity = np.asarray(wavelengths_nm, float)[order], np.eye(len(wavelengths_nm))[order]
    if len(known) > 1:
        ends = (known[0] - (known[1] - known[0]) / 2, known[-1] + (known[-1] - known[-2]) / 2)
        known = np.concatenate([ends[:1], known, ends[1:]])
        identity = identity[[0, *range(len(identity)), -1]]
    return resample(known, identity.T, onto_nm, name=name)

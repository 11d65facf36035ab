"""The basis in which light is recovered: principal components of the lights that may be there (eq. 7).

Three channels fix three weights, so the three basis functions decide what can be recovered. `principal_components` is
the paper's choice. `best_basis` chooses the three functions that a minimum-mean-square-error estimate from these three
channels needs, for lights of the given families and for those lights reflected by surfaces, which is most of what a
panorama shows.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..model import FloatArray
from .library import check_families, surface_reflectances, training_lights

_DIRECT_LIGHT_WEIGHT = 10.0
"""How much a directly seen light counts against a reflected one in the prior.

Measured on a simulated capture with known truth (median dE2000 of lamps / windows / all else, GFC of windows / all else):
2 gives 0.34 / 0.69 / 0.53, 0.9991 / 0.9965; 4 gives 0.27 / 0.73 / 0.59, 0.9997 / 0.9956; 10 gives 0.26 / 0.74 / 0.62,
0.9999 / 0.9945. Daylight of 4000-15000 K seen directly keeps a GFC above 0.9965 with 10 (0.995 with 4).
"""


def principal_components(lights: FloatArray, components: int) -> FloatArray:
    """First principal components of a set of lights, without centring (eq. 7).

    Parameters
    ----------
    lights
        (N, L) spectra.
    components
        K, how many.

    Returns
    -------
    ndarray
        (K, L) orthonormal basis functions; the first has a positive sum.

    Examples
    --------
    >>> basis = principal_components(training_lights(["daylight"]), 3)
    >>> bool(np.allclose(basis @ basis.T, np.eye(3)))
    True
    """
    _, _, rows = np.linalg.svd(lights, full_matrices=False)
    basis = rows[:components]
    return basis * np.where(basis.sum(-1, keepdims=True) < 0, -1.0, 1.0)


def prior_covariance(families: Sequence[str]) -> FloatArray:
    """Second moment of the light a panorama of these lamp families shows, (L, L).

    Spectra are scaled to unit norm, families count alike; lights seen directly and lights reflected by the surfaces
    of a ColorChecker both belong to it.
    """
    reflectances = surface_reflectances()
    moments = []
    for family in check_families(families):
        direct = _unit_norm(training_lights([family]))
        reflected = _unit_norm((direct[:, None] * reflectances).reshape(-1, direct.shape[-1]))
        moments.append(
            _DIRECT_LIGHT_WEIGHT * direct.T @ direct / len(direct) + reflected.T @ reflected / len(reflected)
        )
    return np.asarray(sum(moments)) / (len(moments) * (1.0 + _DIRECT_LIGHT_WEIGHT))


def best_basis(covariance: FloatArray, channels: FloatArray) -> FloatArray:
    """The basis of the minimum-mean-square-error estimate of light from a camera's channels.

    For light of second moment C seen through channels R the best linear estimate from noise-free responses lies in
    the span of C R (Wiener), and inverting the responses within that span (eq. 10) is that estimate.

    Parameters
    ----------
    covariance
        C (L, L).
    channels
        R (L, K) sensitivities, with the reflectance of the ball.

    Returns
    -------
    ndarray
        (K, L) orthonormal basis functions.
    """
    return principal_components((covariance @ channels).T, channels.shape[-1])


def _unit_norm(spectra: FloatArray) -> FloatArray:
    return spectra / np.linalg.norm(spectra, axis=-1, keepdims=True)

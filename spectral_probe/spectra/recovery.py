"""Spectra from camera responses: the weights of eq. 8 by eq. 10, with the incidence angle of every pixel.

A camera channel sees k = sum over wavelengths of E(lambda) S(theta, lambda) R_k(lambda) with the light E, the ball's
reflectance S and the sensitivity R. With E = weights @ basis this is weights @ A(theta), A(theta) = basis (S R),
and the weights are responses @ A(theta)^-1.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..errors import SpectralDataError
from ..model import FloatArray
from .basis import best_basis, principal_components, prior_covariance
from .grid import STEP_NM
from .library import training_lights
from .metals import ball_reflectance

METHODS = ("family", "paper")
"""`family`: non-negative, in the best basis for the lamp families and for their light reflected by surfaces.
`paper`: direct inversion in the first three principal components of the lamp families (eq. 7-10)."""

_COSINES = 91
"""Incidence angles at which A(theta)^-1 is tabulated, evenly in the cosine; between them it is interpolated."""

_FINE_COSINES = 8192
"""Entries of the table that images are looked up in: half a step changes a metal's reflectance by less than 1e-4."""

_NOMINAL_COSINE = 0.8
"""Incidence angle for which the basis is chosen; which one hardly matters (a metal's reflectance is smooth)."""

_FLAT_CONFIDENCE_AT = 0.5
"""Relative error at which confidence is one half."""


@dataclass(frozen=True)
class SpectralRecovery:
    """How one camera, ball and choice of lamp families turn responses into spectra.

    Parameters
    ----------
    basis
        (3, L) basis functions.
    sensitivities
        (L, 3) camera sensitivities.
    reflectances
        (N, L) reflectance of the ball at the cosines of incidence 0..1, evenly spaced.
    covariance
        (L, L) second moment of the light expected, for the confidence.
    safe_weights
        (3,) weights of a spectrum that is positive everywhere, or None to leave negative spectra as they are.
    method
        One of `METHODS`.
    """

    basis: FloatArray
    sensitivities: FloatArray
    reflectances: FloatArray
    covariance: FloatArray
    safe_weights: FloatArray | None
    method: str

    @cached_property
    def inverses(self) -> FloatArray:
        """A(theta)^-1 at the tabulated cosines, (N, 3, 3)."""
        mixing = np.einsum("kl,nl,lc->nkc", self.basis, self.reflectances, self.sensitivities) * STEP_NM
        return np.asarray(np.linalg.inv(mixing))

    def weights(self, responses: FloatArray, cos_incidence: FloatArray) -> FloatArray:
        """Weights of the basis for camera responses (eq. 10): spectra, not yet without negative parts.

        Parameters
        ----------
        responses
            (..., 3) linear camera RGB.
        cos_incidence
            (...) cosine of the incidence angle on the ball.

        Returns
        -------
        ndarray
            (..., 3) float32. Spectra are per nm in units of the responses. `non_negative` is the next step.
        """
        responses = np.asarray(responses, np.float32)
        cosines = np.broadcast_to(np.asarray(cos_incidence, np.float32), responses.shape[:-1])
        channels = [np.array(responses[..., channel]) for channel in range(3)]
        row = (np.clip(cosines, 0.0, 1.0) * np.float32(_FINE_COSINES - 1) + np.float32(0.5)).astype(np.intp)
        weights = np.empty(responses.shape, np.float32)
        for basis in range(3):
            tables = self._fine_inverses[:, basis]
            weights[..., basis] = sum(
                np.take(table, row, mode="clip") * channel
                for table, channel in zip(tables, channels, strict=True)
            )
        return weights

    @cached_property
    def _fine_inverses(self) -> FloatArray:
        """A(theta)^-1 by channel and basis function, (3, 3, N) float32, at so many cosines that the nearest will do."""
        fine = np.linspace(0.0, 1.0, _FINE_COSINES)
        coarse = np.linspace(0.0, 1.0, len(self.inverses))
        entries = self.inverses.reshape(len(self.inverses), -1).T
        table = np.stack([np.interp(fine, coarse, entry) for entry in entries])
        return np.asarray(table.reshape(*self.inverses.shape[1:], _FINE_COSINES), np.float32)

    def _interpolated(self, table: FloatArray, cos_incidence: FloatArray) -> FloatArray:
        position = np.clip(np.asarray(cos_incidence, np.float32), 0.0, 1.0) * (len(table) - 1)
        lower = np.minimum(position.astype(np.intp), len(table) - 2)
        share = (position - lower.astype(np.float32))[..., *(None,) * (table.ndim - 1)]
        table = table.astype(np.float32)
        return np.asarray(table[lower] + share * (table[lower + 1] - table[lower]))

    def non_negative(self, weights: FloatArray) -> FloatArray:
        """Move spectra that dip below zero towards a positive one of the same size, just as far as it takes.

        The paper's method leaves them as they are.
        """
        if self.safe_weights is None:
            return weights
        safe = np.asarray(self.safe_weights, np.float32)
        basis = self.basis.astype(np.float32)
        safe_spectrum = safe @ basis
        flat = weights.reshape(-1, 3)
        size = np.maximum(flat @ basis.sum(-1) / safe_spectrum.sum(), 0.0)
        share = np.zeros(len(flat), np.float32)
        for spectrum, anchor in zip(
            basis.T, safe_spectrum, strict=True
        ):  # a wavelength at a time: little memory
            value = flat @ spectrum
            gap = size * anchor - value
            share = np.maximum(share, np.where(value < 0, -value / np.maximum(gap, 1e-30), 0.0))
        share = np.minimum(share * np.float32(1 + 1e-5), 1.0)[:, None]
        moved = flat + share * (size[:, None] * safe - flat)
        return np.asarray(moved.reshape(weights.shape), np.float32)

    def relative_error(
        self, weights: FloatArray, variance: FloatArray, cos_incidence: FloatArray
    ) -> FloatArray:
        """Expected relative RMS error of the recovered spectra, (...).

        Three parts: what three channels cannot see of lights like those expected (the posterior of the prior), more
        where the light is unlike them (its Mahalanobis distance), and the noise of the photographs.

        Parameters
        ----------
        weights
            (..., 3).
        variance
            (..., 3) variance of the responses.
        cos_incidence
            (...).
        """
        norm_squared = np.maximum(
            (np.asarray(weights, np.float32) ** 2).sum(-1), 1e-30
        )  # the basis is orthonormal
        unlike = np.maximum(self._mahalanobis_squared(weights) / norm_squared / 3.0, 1.0)
        inverse_squared = self._interpolated(self.inverses**2, cos_incidence).sum(-1)
        noise = (np.asarray(variance, np.float32) * inverse_squared).sum(-1) / norm_squared
        return np.asarray(np.sqrt(self._unseen_share * unlike + noise))

    def confidence(self, weights: FloatArray, variance: FloatArray, cos_incidence: FloatArray) -> FloatArray:
        """Confidence in 0..1: 1 / (1 + (e / 0.5)^2) for an expected relative error e; (...) float32."""
        error = self.relative_error(weights, variance, cos_incidence)
        return np.asarray(1.0 / (1.0 + (error / _FLAT_CONFIDENCE_AT) ** 2), np.float32)

    @cached_property
    def _unseen_share(self) -> float:
        """Share of the expected light's energy outside the basis."""
        seen = np.trace(self.basis @ self.covariance @ self.basis.T)
        return float(1.0 - seen / np.trace(self.covariance))

    def _mahalanobis_squared(self, weights: FloatArray) -> FloatArray:
        precision = np.linalg.inv(self.basis @ self.covariance @ self.basis.T) * float(
            np.trace(self.covariance)
        )
        return np.asarray(np.einsum("...k,kj,...j->...", weights, precision.astype(np.float32), weights))


def error_of_confidence(confidence: float) -> float:
    """The expected relative error that a confidence stands for: the inverse of `SpectralRecovery.confidence`.

    Examples
    --------
    >>> error_of_confidence(0.5)
    0.5
    """
    return float(_FLAT_CONFIDENCE_AT * np.sqrt(1.0 / max(confidence, 1e-6) - 1.0))


def spectral_recovery(
    sensitivities: FloatArray,
    ball_material: str | Mapping[str, float],
    families: Sequence[str],
    method: str = "family",
) -> SpectralRecovery:
    """Prepare the recovery of spectra for a camera, a ball and the lamp families that may be present.

    Parameters
    ----------
    sensitivities
        (61, 3) camera sensitivities.
    ball_material
        As in `metals.ball_reflectance`.
    families
        Lamp families of `library.FAMILIES`, or "automatic".
    method
        One of `METHODS`.

    Raises
    ------
    SpectralDataError
        If the method, a family or the material is unknown.

    Examples
    --------
    A light of the family comes back from its camera responses:

    >>> from .camera import camera_sensitivities
    >>> from .colorimetry import illuminant
    >>> camera = camera_sensitivities("Nikon 5100 (NPL)")
    >>> recovery = spectral_recovery(camera, "SUS304", ["incandescent", "daylight"])
    >>> light = illuminant("A")
    >>> responses = (light * ball_reflectance("SUS304", np.array(0.5))) @ camera * 5
    >>> estimate = recovery.weights(responses, np.array(0.5)) @ recovery.basis
    >>> bool(np.linalg.norm(estimate - light) / np.linalg.norm(light) < 0.03)
    True
    """
    if method not in METHODS:
        raise SpectralDataError(
            f'There is no recovery method "{method}". Choose one of {", ".join(METHODS)}.'
        )
    reflectances = ball_reflectance(ball_material, np.linspace(0.0, 1.0, _COSINES))
    covariance = prior_covariance(families)
    lights = training_lights(families)
    if method == "paper":
        basis, safe = principal_components(lights, 3), None
    else:
        nominal = reflectances[round(_NOMINAL_COSINE * (_COSINES - 1))]
        basis = best_basis(covariance, sensitivities * nominal[:, None])
        safe = _positive_weights(basis, lights)
    return SpectralRecovery(basis, np.asarray(sensitivities), reflectances, covariance, safe, method)


def _positive_weights(basis: FloatArray, lights: FloatArray) -> FloatArray:
    """Weights of the mean light if its projection is positive, else of the projected light with the highest minimum."""
    relative = (lights / lights.mean(-1, keepdims=True)) @ basis.T
    candidates = np.concatenate([relative.mean(0, keepdims=True), relative])
    lowest = (candidates @ basis).min(-1)
    if lowest.max() <= 0:
        raise SpectralDataError(
            "No light of these families is positive in their basis. Choose fewer lamp families."
        )
    return np.asarray(candidates[0] if lowest[0] > 0 else candidates[int(lowest.argmax())])

"""The ball divided out (eq. 11): from what the camera saw in the ball to what it would have seen of the light itself.

A channel sees k = sum over wavelengths of E S(theta) R with the light E, the ball's reflectance S and the sensitivity R. Had the
camera looked at the light itself it would have seen the sum of E R. Where S differs with the wavelength the two are not simply
proportional; what is left over is estimated from the other channels.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..model import FloatArray

_COSINES = 91
"""Incidence angles at which the correction is computed, evenly in the cosine."""

_FINE_COSINES = 8192
"""Entries of the table that images are looked up in: half a step changes a metal's reflectance by less than 1e-4."""

NOISE = 0.005
"""Standard deviation of the responses that estimates reckon with, relative to the brightest channel."""


def incidence_cosines() -> FloatArray:
    """Cosines of incidence, (91,) from grazing (0) to normal (1), at which a ball's reflectance is wanted."""
    return np.linspace(0.0, 1.0, _COSINES)


@dataclass(frozen=True)
class IncidenceCorrection:
    """Camera responses to the light itself from responses to its image in the ball, by the cosine of incidence.

    `matrices` (N, C, C) are those of the cosines 0..1, evenly spaced: responses (C,) times the matrix are the responses to the
    light itself.
    """

    matrices: FloatArray

    def light_responses(self, responses: FloatArray, cos_incidence: FloatArray) -> FloatArray:
        """Responses to the light itself.

        Parameters
        ----------
        responses
            (..., C) linear camera responses to the light's image in the ball.
        cos_incidence
            (...) cosine of the incidence angle on the ball.

        Returns
        -------
        ndarray
            (..., C) float32.
        """
        return self._applied(self._fine, responses, cos_incidence)

    def light_variance(self, variance: FloatArray, cos_incidence: FloatArray) -> FloatArray:
        """Variance (..., C) of `light_responses`, from that of the responses."""
        return self._applied(self._fine_squared, variance, cos_incidence)

    def _applied(self, table: FloatArray, values: FloatArray, cos_incidence: FloatArray) -> FloatArray:
        values = np.asarray(values, np.float32)
        cosines = np.broadcast_to(np.asarray(cos_incidence, np.float32), values.shape[:-1])
        row = (np.clip(cosines, 0.0, 1.0) * np.float32(_FINE_COSINES - 1) + np.float32(0.5)).astype(np.intp)
        channels = [np.array(values[..., channel]) for channel in range(values.shape[-1])]
        result = np.empty(values.shape, np.float32)
        for wanted in range(values.shape[-1]):
            result[..., wanted] = sum(
                np.take(entries, row, mode="clip") * channel
                for entries, channel in zip(table[:, wanted], channels, strict=True)
            )
        return result

    @cached_property
    def _fine(self) -> FloatArray:
        """The matrices by given and wanted channel, (C, C, N) float32, at so many cosines that the nearest will do."""
        fine = np.linspace(0.0, 1.0, _FINE_COSINES)
        coarse = np.linspace(0.0, 1.0, len(self.matrices))
        entries = self.matrices.reshape(len(self.matrices), -1).T
        table = np.stack([np.interp(fine, coarse, entry) for entry in entries])
        return np.asarray(table.reshape(*self.matrices.shape[1:], _FINE_COSINES), np.float32)

    @cached_property
    def _fine_squared(self) -> FloatArray:
        return np.asarray(self._fine**2)


def incidence_correction(
    sensitivities: FloatArray, reflectances: FloatArray, moment: FloatArray, noise: float = NOISE
) -> IncidenceCorrection:
    """The best linear correction for light of a known second moment.

    Parameters
    ----------
    sensitivities
        R (L, C).
    reflectances
        S (N, L) at `incidence_cosines`.
    moment
        (L, L) second moment of the light expected. For one of rank C, the span of C basis functions, and next to no noise the
        correction is exact within that span: this is eq. 10 with the incidence angle of every pixel.
    noise
        Standard deviation of the responses relative to the brightest.

    Examples
    --------
    >>> identity = incidence_correction(np.eye(3), np.ones((91, 3)), np.eye(3)).matrices
    >>> bool(np.allclose(identity, np.eye(3)))
    True
    """
    mirrored = reflectances[:, :, None] * sensitivities  # (N, L, C)
    seen = np.einsum("nlc,lm,nmd->ncd", mirrored, moment, mirrored)
    direct = np.einsum("nlc,lm,md->ncd", mirrored, moment, sensitivities)
    power = np.einsum("ncc->nc", seen)
    factor = (
        np.einsum("ncc->nc", direct) / power
    )  # channel by channel, and the other channels for what is left
    scale = factor[:, None, :] * np.eye(seen.shape[-1])
    variance = noise**2 * power.max(-1)[:, None, None] * np.eye(seen.shape[-1])
    return IncidenceCorrection(scale + np.linalg.solve(seen + variance, direct - seen @ scale))

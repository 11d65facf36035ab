"""Calibration by one known light: three channel gains, and the reflectance of the ball itself.

A channel that sees light of spectral radiance L through sensitivity R_k answers k = g_k sum of L R_k over wavelengths, seen in
a ball of reflectance S with L S in place of L. Published sensitivities R_k are often normalised channel by channel, so that
the factors g_k between the channels are lost (and the one of all three, the absolute scale, is never known): one known
light gives them back.

What the ball does to the colours of a card beside it, against the card seen directly in the same photographs, is its
reflectance seen by three channels, whatever their gains. Three numbers fix a smooth curve: the factor by which the modelled
reflectance is wrong.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import SpectralDataError
from ..model import FloatArray
from .grid import STEP_NM, WAVELENGTHS_NM

_GREEN = 1

_LEAST_SHARE = 1e-4
"""A light that a channel sees less than this share of the brightest channel's response says nothing of its gain."""


def channel_gains(
    measured: FloatArray, light: FloatArray, sensitivities: FloatArray, *, absolute: bool = False
) -> FloatArray:
    """What the responses of each channel are to be multiplied by for the sensitivities to explain a known light.

    Parameters
    ----------
    measured
        (3,) responses to the light.
    light
        (L,) its spectral radiance, with the ball's reflectance on it where it was seen in the ball.
    sensitivities
        (L, 3) of the camera, as published.
    absolute
        Whether the unit of `light` is the one that recovered spectra are to have. Otherwise green keeps its level.

    Returns
    -------
    ndarray
        (3,) predicted over measured responses. Dividing the sensitivities by it is the same as multiplying the responses.

    Raises
    ------
    SpectralDataError
        If a channel does not see the light.

    Examples
    --------
    >>> curves = np.eye(3).repeat([20, 21, 20], axis=0)
    >>> channel_gains(np.array([50.0, 105.0, 200.0]), np.ones(61), curves).round(3).tolist()
    [2.0, 1.0, 0.5]
    """
    predicted = light @ sensitivities * STEP_NM
    for name, values in (("the camera's curves", predicted), ("the photographs", np.asarray(measured))):
        if not (np.isfinite(values).all() and (values > _LEAST_SHARE * np.abs(values).max()).all()):
            raise SpectralDataError(
                f"By {name} a channel does not see the light of the calibration. Take a light that red, green and blue see."
            )
    gains = predicted / measured
    return np.asarray(gains if absolute else gains / gains[_GREEN])


@dataclass(frozen=True)
class BallCorrection:
    """How the ball's reflectance differs from the modelled one.

    `factor` (L,) is measured over modelled reflectance at the incidence where the model is `modelled` (L,). `channel_factors`
    (3,) are what it was fitted to. `exceeds` is True where the reflectance would be above 1, and was cut there.
    """

    factor: FloatArray
    modelled: FloatArray
    channel_factors: tuple[float, float, float]
    exceeds: bool

    def applied(self, reflectance: FloatArray) -> FloatArray:
        """Corrected reflectance of modelled ones (..., L) at other angles of incidence.

        Where the ball is brighter than modelled its absorptance 1 - S is scaled, by the same share at every angle: a metal's
        absorptance falls with the angle as a whole, and at grazing incidence everything reflects everything. Where it is
        darker (tarnished, dusty) the reflectance is scaled.

        Examples
        --------
        >>> half = BallCorrection(np.full(61, 1.2), np.full(61, 0.5), (1.2, 1.2, 1.2), False)
        >>> half.applied(np.array([[0.5], [1.0]]) * np.ones(61))[:, 0].round(3).tolist()
        [0.6, 1.0]
        """
        absorptance = np.maximum(1.0 - self.modelled, 1e-9)
        share = np.clip((1.0 - self.factor * self.modelled) / absorptance, 0.0, None)
        brighter = 1.0 - (1.0 - reflectance) * share
        return np.asarray(np.where(self.factor > 1.0, brighter, reflectance * self.factor))


def ball_correction(
    mirrored: FloatArray,
    direct: FloatArray,
    light: FloatArray,
    sensitivities: FloatArray,
    reflectance: FloatArray,
) -> BallCorrection:
    """What a card seen in the ball and directly says of the ball's reflectance.

    Parameters
    ----------
    mirrored, direct
        (3,) responses to the card in the ball, and to the card itself, in the same photographs.
    light
        (L,) spectral radiance of the card, relative. It weighs the wavelengths within each channel, no more.
    sensitivities
        (L, 3) of the camera; their gains do not matter.
    reflectance
        (L,) of the ball as modelled, at the incidence at which it mirrors the card.

    Returns
    -------
    BallCorrection
        The flattest factor c(lambda), the one of least squared slope, with which
        sum(L S c R_k) / sum(L R_k) = mirrored / direct for all three channels.

    Raises
    ------
    SpectralDataError
        If a response is not positive, or the three cannot be explained by any positive smooth reflectance.

    Notes
    -----
    A curve of least curvature would go on beyond the outer channels as a straight line: for measured steel modelled by eq. 11,
    and for chrome modelled as steel, it was 1.6 to 4 times further from the truth than the flattest one, and 0.5 % of noise
    moved it by twice as much.
    """
    mirrored, direct = np.asarray(mirrored, float), np.asarray(direct, float)
    if not ((mirrored > 0).all() and (direct > 0).all()):
        raise SpectralDataError(
            "The card is black in a channel, in the ball or seen directly. Give ball_patch_px and patch_px on the card."
        )
    ratio = mirrored / direct
    weights = light[:, None] * sensitivities / (light @ sensitivities)  # (L, 3), each of sum 1
    seen = (weights * reflectance[:, None]).T
    factor = _flattest(seen, ratio)
    if not (factor > 0).all():
        raise SpectralDataError(
            f"The ball returns {ratio[0]:.2f}, {ratio[1]:.2f} and {ratio[2]:.2f} of the card's red, green and blue: no smooth "
            "reflectance does that. Check ball_patch_px and patch_px."
        )
    exceeds = bool((factor * reflectance > 1.0).any())
    factors = ratio / seen.sum(-1)
    return BallCorrection(
        np.minimum(factor, 1.0 / reflectance),
        np.asarray(reflectance, float),
        (float(factors[0]), float(factors[1]), float(factors[2])),
        exceeds,
    )


def _flattest(rows: FloatArray, values: FloatArray) -> FloatArray:
    """The curve c (L,) of least squared slope with rows (M, L) @ c = values (M,), by Lagrange multipliers."""
    count, conditions = len(WAVELENGTHS_NM), len(rows)
    slope = np.diff(np.eye(count), axis=0)
    system = np.zeros((count + conditions,) * 2)
    system[:count, :count] = slope.T @ slope
    system[:count, count:] = rows.T
    system[count:, :count] = rows
    return np.asarray(np.linalg.solve(system, np.r_[np.zeros(count), values])[:count])

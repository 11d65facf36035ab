"""Linear estimates of one kind of light from a camera's channels, and what errors they make on lights they have not seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import SpectralDataError
from ..model import BoolArray, FloatArray
from .basis import principal_components
from .incidence import NOISE
from .prior import ALIKE, LightClass


@dataclass(frozen=True)
class ClassEstimate:
    """The estimate of one kind of light.

    Parameters
    ----------
    name
        The kind: a lamp family, or another name of `prior`.
    share
        Its a-priori probability.
    direct
        Whether the light is seen directly, or from a surface; None if it may be either.
    operator
        (C, L): responses times this are the spectrum.
    precision
        (C, C) inverse of the second moment of the responses to light of unit norm.
    error
        (L, L) second moment of the errors on spectra of unit norm: each estimated without itself and those like it.
    """

    name: str
    share: float
    direct: bool | None
    operator: FloatArray
    precision: FloatArray
    error: FloatArray


def wiener_estimate(light_class: LightClass, channels: FloatArray) -> ClassEstimate:
    """The minimum-mean-square-error estimate of a class of light.

    Parameters
    ----------
    light_class
        The class.
    channels
        (L, C) sensitivities times the wavelength step.
    """
    responses = light_class.spectra @ channels
    everything = _Sums.over(light_class, responses, slice(None))
    operator, precision = _wiener(everything)
    errors = []
    for tried, others in light_class.folds():
        without, _ = _wiener(everything.minus(_Sums.over(light_class, responses, ~others)))
        errors.append(light_class.spectra[tried] - responses[tried] @ without)
    return ClassEstimate(
        light_class.name, light_class.share, light_class.direct, operator, precision, _second_moment(errors)
    )


@dataclass(frozen=True)
class _Sums:
    """Second moments of some spectra: of the responses to them (C, C), of responses and spectra (C, L), and their share."""

    seen: FloatArray
    crossed: FloatArray
    share: float

    @classmethod
    def over(cls, light_class: LightClass, responses: FloatArray, some: BoolArray | slice) -> _Sums:
        shares = light_class.shares[some]
        weighted = responses[some] * shares[:, None]
        return cls(weighted.T @ responses[some], weighted.T @ light_class.spectra[some], float(shares.sum()))

    def minus(self, other: _Sums) -> _Sums:
        return _Sums(self.seen - other.seen, self.crossed - other.crossed, self.share - other.share)


def _wiener(sums: _Sums) -> tuple[FloatArray, FloatArray]:
    """Operator (C, L) and precision (C, C)."""
    seen = sums.seen / sums.share
    precision = np.linalg.inv(seen + _noise(np.diag(seen)))
    return precision @ (sums.crossed / sums.share), precision


def _noise(power: FloatArray) -> FloatArray:
    """Covariance (C, C) of the noise that is reckoned with, from the channels' mean squares (C,), photo set by photo set."""
    brightest = power.reshape(-1, 3).max(-1) if len(power) % 3 == 0 else np.array([power.max()] * len(power))
    return np.diag(NOISE**2 * np.repeat(brightest, len(power) // len(brightest)))


def inverse_estimate(lights: FloatArray, channels: FloatArray, basis: FloatArray) -> ClassEstimate:
    """The paper's estimate: the responses inverted within as many principal components as there are channels (eq. 10).

    Parameters
    ----------
    lights
        (N, L) spectra of unit norm.
    channels
        (L, C) sensitivities times the wavelength step.
    basis
        (C, L) the first principal components of the lights.

    Raises
    ------
    SpectralDataError
        If the channels cannot tell the components apart.
    """
    responses = lights @ channels
    alike = lights @ lights.T > ALIKE
    errors = []
    for light, response, near in zip(lights, responses, alike, strict=True):
        own = principal_components(
            lights[~near] if np.count_nonzero(~near) >= len(basis) else lights, len(basis)
        )
        errors.append((light - response @ _inverse(own, channels))[None])
    seen = responses.T @ responses / len(lights)
    precision = np.linalg.inv(seen + _noise(np.diag(seen)))
    return ClassEstimate("paper", 1.0, True, _inverse(basis, channels), precision, _second_moment(errors))


def _inverse(basis: FloatArray, channels: FloatArray) -> FloatArray:
    mixing = basis @ channels
    if np.linalg.cond(mixing) > 1e6:
        raise SpectralDataError(
            "The camera's channels cannot tell the principal components of these lights apart. Choose other lamp families."
        )
    return np.asarray(np.linalg.solve(mixing, basis))


def _second_moment(errors: Sequence[FloatArray]) -> FloatArray:
    stacked = np.concatenate(errors)
    return np.asarray(stacked.T @ stacked / len(stacked))

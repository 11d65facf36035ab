"""What is known of one spectrum after the photographs: its uncertainty at every wavelength, and which lamps it may come from.

Within a kind of light the errors are those its estimate made on lights it had not seen (`estimates.ClassEstimate.error`);
between the kinds they are the differences of their estimates, weighted by how probable the kinds are.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..model import FloatArray
from .colorimetry import delta_e_2000, spectra_to_xyz
from .grid import STEP_NM
from .library import surface_reflectances
from .metals import metal_reflectance
from .recovery import SpectralRecovery

_DRAWS = 64
"""Spectra drawn to see what colours the surfaces may have."""


@dataclass(frozen=True)
class Posterior:
    """What is known of a spectrum.

    Parameters
    ----------
    mean
        (L,) the expected spectrum, without the negative parts that `recover` removes.
    covariance
        (L, L).
    kinds
        Probability of each kind of light, by name; they sum to one.
    residual
        Share of the responses' norm that the recovered spectrum does not explain: noise, or channels that contradict each other.
    """

    mean: FloatArray
    covariance: FloatArray
    kinds: Mapping[str, float]
    residual: float

    @property
    def standard_error(self) -> FloatArray:
        """(L,) of the spectrum at every wavelength."""
        return np.asarray(np.sqrt(np.maximum(np.diag(self.covariance), 0)))

    @property
    def relative_error(self) -> float:
        """Expected RMS error over the RMS of the spectrum."""
        return float(
            np.sqrt(max(np.trace(self.covariance), 0)) / max(float(np.linalg.norm(self.mean)), 1e-30)
        )

    def at_least(self, relative_error: float) -> Posterior:
        """The same with all errors raised alike where they are smaller than a relative error."""
        factor = max(relative_error / max(self.relative_error, 1e-30), 1.0)
        return replace(self, covariance=self.covariance * factor**2)


def posterior(
    recovery: SpectralRecovery,
    responses: FloatArray,
    variance: FloatArray | None = None,
    direct: float = 1.0,
) -> Posterior:
    """What one light's responses say of its spectrum.

    Parameters
    ----------
    recovery
        The recovery.
    responses, variance
        (C,) to the light itself, and their variance; none by default.
    direct
        Probability that the light is seen directly.

    Examples
    --------
    >>> from .camera import camera_sensitivities
    >>> from .colorimetry import illuminant
    >>> from .recovery import spectral_recovery
    >>> camera = camera_sensitivities("Nikon 5100 (NPL)")
    >>> known = posterior(spectral_recovery(camera, ["incandescent", "daylight"]), illuminant("A") @ camera * 5)
    >>> max(known.kinds, key=known.kinds.get)
    'incandescent'
    """
    responses = np.asarray(responses, float)
    likely = recovery.probabilities(responses.astype(np.float32), direct).astype(float)
    unlike = recovery.unlikeness(responses.astype(np.float32)).astype(float)
    estimates = np.stack([responses @ estimate.operator for estimate in recovery.estimates])
    mean = likely @ estimates
    covariance = np.zeros((len(mean), len(mean)))
    for estimate, own, probability, factor, strange in zip(
        recovery.estimates, estimates, likely, unlike, recovery.strangeness(unlike), strict=True
    ):
        within = factor * estimate.error + strange * np.eye(len(mean)) / len(mean)
        covariance += probability * ((own @ own) * within + np.outer(own - mean, own - mean))
    if variance is not None:
        mixed = np.einsum("n,ncl->cl", likely, np.stack([one.operator for one in recovery.estimates]))
        covariance += (mixed.T * np.asarray(variance, float)) @ mixed
    found = recovery.recover(responses, variance, direct)
    spectrum = found.weights @ recovery.bases[found.basis_index]
    explained = spectrum @ recovery.sensitivities * STEP_NM
    residual = np.linalg.norm(responses - explained) / max(float(np.linalg.norm(responses)), 1e-30)
    kinds = {
        estimate.name: float(chance) for estimate, chance in zip(recovery.estimates, likely, strict=True)
    }
    return Posterior(np.asarray(spectrum), covariance, kinds, float(residual))


def metamer_risk(spectrum: FloatArray, covariance: FloatArray) -> float:
    """Mean dE2000 that surfaces may have under the true light against the recovered one, whose responses are the same.

    The surfaces are the 24 patches of a ColorChecker, gold, silver and copper; the true light is drawn from the posterior, and
    both lights have one luminance. A light can be right for the camera and wrong for what it falls on: this says how wrong.

    Parameters
    ----------
    spectrum, covariance
        (L,) and (L, L) of the light.
    """
    metals = [metal_reflectance(metal, np.array(1.0)) for metal in ("Au", "Ag", "Cu")]
    surfaces = np.concatenate([surface_reflectances(), metals])
    values, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(values, 0))
    drawn = spectrum + np.random.default_rng(3).standard_normal((_DRAWS, len(spectrum))) @ root.T
    lights = np.maximum(np.concatenate([np.asarray(spectrum)[None], drawn]), 0)
    white = spectra_to_xyz(lights)
    level = white[:, 1:2]
    lit = level[:, 0] > 0
    if not lit[0] or not lit[1:].any():
        return 0.0
    lights, white = lights[lit] / level[lit], white[lit] / level[lit]
    colours = spectra_to_xyz(lights[:, None] * surfaces)
    return float(delta_e_2000(colours[1:], np.broadcast_to(colours[0], colours[1:].shape), white[0]).mean())

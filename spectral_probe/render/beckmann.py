"""The Beckmann distribution of microfacets that stands for the paper's lobe in Cycles."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..errors import RenderError
from ..model import FloatArray
from .torrance_sparrow import facet_distribution

STEEPEST_ALPHA = math.sqrt(0.5)
"""Up to this alpha a Beckmann distribution is highest at the surface's normal; beyond, facets beside it are more."""

WIDEST_GAMMA_RAD = math.pi / 4
"""Up to this gamma a Beckmann distribution has the paper's half width (to 45.9 degrees, where alpha is `STEEPEST_ALPHA`)."""

_ANGLES = np.linspace(0.0, math.pi / 2, 2001)[:-1]


@dataclass(frozen=True)
class BeckmannFit:
    """A Beckmann lobe in place of the paper's D = exp(-ln 2 phi^2 / gamma^2).

    Parameters
    ----------
    alpha
        Its width; Cycles' roughness is the square root.
    half_width_rad
        Angle at which the Beckmann lobe has half its height.
    residual
        RMS difference of the two lobes, both of height 1, over the RMS of the paper's; facets are weighted by the area
        they show along the normal.
    """

    alpha: float
    half_width_rad: float
    residual: float

    @property
    def roughness(self) -> float:
        """Roughness of Cycles' nodes."""
        return math.sqrt(self.alpha)


def beckmann_alpha(gamma_rad: float) -> BeckmannFit:
    """The Beckmann distribution for the paper's angle gamma.

    Parameters
    ----------
    gamma_rad
        Half width of the paper's lobe: D(gamma) = 1/2.

    Returns
    -------
    BeckmannFit
        Of the same half width, where there is one (gamma below 45.9 degrees): D(gamma)/D(0) = exp(-tan^2 gamma /
        alpha^2) / cos^4 gamma = 1/2 gives alpha = tan gamma / sqrt(ln 2 - 4 ln cos gamma). For small gamma this is
        tan gamma / sqrt(ln 2), 4 % more at 10 degrees. Beyond, the least squares fit of lobes that are highest at the normal.

    Raises
    ------
    RenderError
        If gamma is not above 0 and below 90 degrees.

    Examples
    --------
    >>> fit = beckmann_alpha(np.radians(8.0))
    >>> round(fit.alpha, 4), float(np.degrees(fit.half_width_rad).round(3)), round(fit.residual, 3)
    (0.1642, 8.0, 0.016)
    """
    if not 0 < gamma_rad < math.pi / 2:
        raise RenderError("The angle gamma must be above 0 and below 90 degrees.")
    alpha = _same_half_width(gamma_rad)
    if alpha > STEEPEST_ALPHA:
        candidates = np.linspace(0.1, STEEPEST_ALPHA, 400)
        alpha = float(candidates[np.argmin([_residual(float(a), gamma_rad) for a in candidates])])
    lobe = beckmann_distribution(np.cos(_ANGLES), alpha)
    half_width = float(_ANGLES[np.argmax(lobe < 0.5)])
    if alpha == _same_half_width(gamma_rad):
        half_width = gamma_rad
    return BeckmannFit(alpha, half_width, _residual(alpha, gamma_rad))


def beckmann_distribution(cos_facet: FloatArray, alpha: float) -> FloatArray:
    """Beckmann's share of facets by their cosine with the normal, 1 at the normal: exp(-tan^2 / alpha^2) / cos^4.

    Examples
    --------
    >>> beckmann_distribution(np.cos(np.array([0.0, 0.1])), 0.12).round(3).tolist()
    [1.0, 0.507]
    """
    squared = np.maximum(np.asarray(cos_facet, float) ** 2, 1e-12)
    return np.asarray(np.exp((1.0 - 1.0 / squared) / alpha**2) / squared**2)


def _same_half_width(gamma_rad: float) -> float:
    return math.tan(gamma_rad) / math.sqrt(math.log(2.0) - 4.0 * math.log(math.cos(gamma_rad)))


def _residual(alpha: float, gamma_rad: float) -> float:
    cosines = np.cos(_ANGLES)
    weight = np.sin(_ANGLES) * cosines
    paper = facet_distribution(cosines, gamma_rad)
    difference = beckmann_distribution(cosines, alpha) - paper
    return float(np.sqrt((weight * difference**2).sum() / (weight * paper**2).sum()))

"""Lamps and windows told from the surfaces they light, by how bright they are.

A matt surface of reflectance 1 under the irradiance H has the radiance H / pi: whatever is much brighter than that under the
strongest irradiance at the ball is no matt surface lit like the ball. Surfaces near a lamp are lit more strongly, and dim lamps
exist, so this is a probability, which the colour can still overrule.
"""

from __future__ import annotations

import numpy as np

from ..geometry.frames import panorama_directions, panorama_solid_angles
from ..geometry.sphere import resized
from ..model import FloatArray

_WIDTH = 64
"""Width of the panorama that irradiance is summed on."""

_EXPONENT = 3.0
"""How fast the odds of a directly seen light rise with its luminance."""

_RANGE = (0.02, 0.98)
"""Probabilities that luminance alone can give."""


def surface_luminance(luminance: FloatArray) -> float:
    """Luminance of a white matt surface at the ball, turned where the panorama lights it most.

    Parameters
    ----------
    luminance
        (H, W) of the panorama, in any unit.

    Returns
    -------
    float
        In the same unit.

    Examples
    --------
    Under an even sky above and darkness below a white surface looks as bright as the sky:

    >>> sky = np.repeat([[1.0], [0.0]], 64, axis=1).repeat(16, axis=0)
    >>> round(surface_luminance(sky), 2)
    1.0
    """
    height, width = _WIDTH // 2, _WIDTH
    small = np.maximum(resized(np.asarray(luminance, np.float32), width), 0)
    directions = panorama_directions(height, width).reshape(-1, 3)
    power = (small * panorama_solid_angles(height, width)).reshape(-1)
    irradiance = np.maximum(directions @ directions.T, 0) @ power
    return float(irradiance.max() / np.pi)


def direct_probability(luminance: FloatArray, surface: float) -> FloatArray:
    """Probability that light of a luminance is seen directly, from that of a white surface (`surface_luminance`).

    Examples
    --------
    >>> [round(float(chance), 2) for chance in direct_probability(np.array([1.0, 2.0, 100.0]), 2.0)]
    [0.11, 0.5, 0.98]
    """
    ratio = np.maximum(np.asarray(luminance, np.float32), 0) / np.float32(max(surface, 1e-30))
    odds = ratio**_EXPONENT
    return np.asarray(np.clip(odds / (1 + odds), *_RANGE), np.float32)

"""The recovery of light whose spectrum was measured: only its level is unknown."""

from __future__ import annotations

import numpy as np

from ..errors import SpectralDataError
from ..model import FloatArray
from .estimates import ClassEstimate
from .grid import STEP_NM
from .incidence import NOISE
from .recovery import SpectralRecovery


def measured_light_recovery(sensitivities: FloatArray, spectrum: FloatArray) -> SpectralRecovery:
    """The recovery of the level of one known spectrum.

    Parameters
    ----------
    sensitivities
        (61, C) of all channels.
    spectrum
        (61,) the light's, not negative.

    Returns
    -------
    SpectralRecovery
        Of one estimate and one basis function, the spectrum itself. The level is that of least squares, each channel's errors
        being taken as proportional to the brightest channel without a filter or through the same one. Responses that the
        spectrum cannot explain at any level raise the expected error.

    Raises
    ------
    SpectralDataError
        If no channel sees the light.

    Examples
    --------
    >>> from .camera import camera_sensitivities
    >>> from .colorimetry import illuminant
    >>> camera = camera_sensitivities("Nikon 5100 (NPL)")
    >>> recovery = measured_light_recovery(camera, illuminant("FL11"))
    >>> found = recovery.recover(3 * illuminant("FL11") @ camera * 5)
    >>> bool(np.allclose(found.weights @ recovery.bases[0], 3 * illuminant("FL11"), rtol=1e-4))
    True
    """
    unit = np.asarray(spectrum, float) / np.linalg.norm(spectrum)
    seen = unit @ (np.asarray(sensitivities, float) * STEP_NM)
    if not (seen > 0).any():
        raise SpectralDataError(
            "No channel of the camera sees the measured spectrum of a region. Check its file."
        )
    brightest = np.repeat(seen.reshape(-1, 3).max(-1), 3)
    precision = 1.0 / (NOISE * np.maximum(brightest, 1e-6 * brightest.max())) ** 2
    operator = (precision * seen)[:, None] * unit / (precision @ seen**2)
    moment = np.outer(unit, unit)
    estimate = ClassEstimate(
        "measured",
        1.0,
        True,
        operator,
        np.linalg.inv(np.outer(seen, seen) + np.diag(1.0 / precision)),
        NOISE**2 * moment,
    )
    safe = np.ones((1, 1))
    return SpectralRecovery(np.asarray(sensitivities), (estimate,), unit[None, None], safe, moment, "family")

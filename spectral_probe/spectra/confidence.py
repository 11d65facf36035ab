"""What the recovery of a spectrum gives, and confidence in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..model import FloatArray

_HALF_CONFIDENCE = 0.5
"""Relative error at which confidence is one half."""


@dataclass(frozen=True)
class Recovered:
    """What an image of responses became.

    `weights` (..., K) float32 are those of the basis `basis_index` (...); `relative_error` (...) is the expected RMS error of the
    spectrum over its RMS.
    """

    weights: FloatArray
    basis_index: npt.NDArray[np.uint8]
    relative_error: FloatArray

    @property
    def confidence(self) -> FloatArray:
        """Confidence in 0..1: 1 / (1 + (e / 0.5)^2) for an expected relative error e; (...) float32."""
        return np.asarray(1.0 / (1.0 + (self.relative_error / _HALF_CONFIDENCE) ** 2), np.float32)


def error_of_confidence(confidence: float) -> float:
    """The expected relative error that a confidence stands for: the inverse of `Recovered.confidence`.

    Examples
    --------
    >>> error_of_confidence(0.5)
    0.5
    """
    return float(_HALF_CONFIDENCE * np.sqrt(1.0 / min(max(confidence, 1e-6), 1.0) - 1.0))

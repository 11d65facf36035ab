"""Spectra from camera responses (eq. 7-10): a mixture of linear estimates, one for each kind of light that may be there.

What a camera records of light E is y = E R. The best linear estimate of light of second moment M is Wiener's,
y (R' M R + N)^-1 R' M with the noise N. Each class of `prior.light_classes` has such an estimate, and the responses
themselves tell how probable each class is: with the level of the light unknown, the density of y under a class is that of an
angular central Gaussian, |K|^-1/2 (y' K^-1 y)^(-C/2) with K = R' M R + N (Tyler, "Statistical analysis for the angular central
Gaussian distribution on the sphere", Biometrika 74, 579, 1987, doi:10.1093/biomet/74.3.579). The estimate is the mean over the
classes that makes the expected *relative* error least. For given probabilities it is linear in y, so a few weights a pixel
hold it.

The paper's own method (eq. 7-10) is the one-class case whose estimate is the inverse within three principal components.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from ..errors import SpectralDataError
from ..model import FloatArray
from ..parallel import product
from .basis import not_held, principal_components, spanning
from .colorimetry import colour_matching_functions
from .confidence import Recovered
from .estimates import ClassEstimate, inverse_estimate, wiener_estimate
from .grid import STEP_NM
from .incidence import NOISE, IncidenceCorrection, incidence_correction
from .library import AUTOMATIC
from .positive import lifted, negative, positive_weights
from .prior import LightClass, light_classes

METHODS = ("family", "automatic", "paper")
"""`family`: non-negative, for the lamp families said to be present, seen directly or reflected by surfaces.
`automatic`: the same for all lamp families. `paper`: direct inversion in the first three principal components of the lamp
families (eq. 7-10)."""

MOST_WEIGHTS = 12
"""Weights a pixel has at most."""

_TOLERANCE = 3e-3
"""Relative error of a spectrum that fewer weights may cost."""

_EXAMPLES = 1200
"""Spectra at most that the basis is chosen by."""

_SINGULAR = 1e-4
"""Smallest singular value of the channels, relative to the largest, that can be inverted."""

_STRANGE = 4.0
"""How much farther than usual, in variance, light must be from a kind to be hardly of it: one member in a hundred is."""

_PAPER_NOISE = 1e-6
"""The paper inverts as if there were no noise; this only keeps the inverse defined."""

_TINY = np.float32(1e-30)

_AT_A_TIME = 8192
"""Pixels whose spectra fit a processor's cache."""


@dataclass(frozen=True)
class SpectralRecovery:
    """How a camera's responses to light become its spectrum.

    Parameters
    ----------
    sensitivities
        R (L, C) of all channels: three, and three more for every filter that photographs were taken through.
    estimates
        One for each kind of light that may be there.
    bases
        (B, K, L) basis functions, orthonormal (or zero, where a basis needs fewer). With several bases there is one for each
        estimate, for the pixels where that one is the most probable.
    safe_weights
        (B, K) weights of a spectrum that is positive throughout, or None to leave negative spectra as they are.
    moment
        (L, L) second moment of the light expected; of the paper's method that of its basis.
    method
        One of `METHODS`.
    """

    sensitivities: FloatArray
    estimates: tuple[ClassEstimate, ...]
    bases: FloatArray
    safe_weights: FloatArray | None
    moment: FloatArray
    method: str

    def recover(
        self,
        responses: FloatArray,
        variance: FloatArray | None = None,
        direct: FloatArray | float = 1.0,
    ) -> Recovered:
        """Weights of the basis for camera responses to light (the ball divided out, `incidence_correction`).

        Parameters
        ----------
        responses
            (..., C).
        variance
            (..., C) of the responses; none by default.
        direct
            (...) probability that the light is seen directly and not reflected by a surface.

        Returns
        -------
        Recovered
            Spectra are per nm in units of the responses; without negative parts, except by the paper's method.
        """
        responses = np.asarray(responses, np.float32)
        shape = responses.shape[:-1]
        flat = responses.reshape(-1, responses.shape[-1])
        chance = np.broadcast_to(np.asarray(direct, np.float32), shape).reshape(-1)
        noise = np.zeros_like(flat) if variance is None else np.asarray(variance).reshape(flat.shape)
        weights = np.empty((len(flat), self.bases.shape[1]), np.float32)
        index = np.zeros(len(flat), np.uint8)
        error = np.empty(len(flat), np.float32)
        for start in range(0, len(flat), _AT_A_TIME):
            few = slice(start, start + _AT_A_TIME)
            columns, own_noise = (np.array(part[few].T, np.float32, order="C") for part in (flat, noise))
            squared = self._squared(columns, self._precision_roots)
            likely = self._likely(columns, squared, chance[few])
            if len(self.bases) > 1:
                index[few] = likely.argmax(0)
            found = self._weights(columns, likely, index[few])
            error[few] = self._relative_error(columns, squared, likely, found, own_noise)
            if self.safe_weights is not None:
                self._make_positive(found, index[few], columns, self.safe_weights)
            weights[few] = found.T
        return Recovered(weights.reshape(*shape, -1), index.reshape(shape), error.reshape(shape))

    def probabilities(self, responses: FloatArray, direct: FloatArray | float = 1.0) -> FloatArray:
        """How probable each estimate's kind of light is, (..., N) summing to one, from responses (..., C) alone."""
        columns = _columns(responses)
        chance = np.broadcast_to(np.asarray(direct, np.float32), responses.shape[:-1]).reshape(-1)
        likely = self._likely(columns, self._squared(columns, self._precision_roots), chance)
        return np.asarray(likely.T.reshape(*responses.shape[:-1], -1))

    def unlikeness(self, responses: FloatArray) -> FloatArray:
        """How much farther the light may be from each estimate than lights of its kind are, (..., N), as a factor of variance."""
        columns = _columns(responses)
        squared, energy = (
            self._squared(columns, roots) for roots in (self._precision_roots, self._operator_roots)
        )
        return np.asarray(self._unlikeness(squared, energy).T.reshape(*responses.shape[:-1], -1))

    @staticmethod
    def strangeness(unlikeness: FloatArray) -> FloatArray:
        """Relative variance, 0..1, of what is hardly of a kind: it may be anything."""
        return np.asarray(np.maximum(1 - _STRANGE / unlikeness, 0))

    def incidence_correction(
        self, reflectances: FloatArray, channels: slice = slice(0, 3)
    ) -> IncidenceCorrection:
        """What divides a ball of reflectances (N, L) at `incidence.incidence_cosines` out of some channels' responses."""
        noise = _PAPER_NOISE if self.method == "paper" else NOISE
        return incidence_correction(self.sensitivities[:, channels], reflectances, self.moment, noise)

    @cached_property
    def to_luminance(self) -> FloatArray:
        """(3,) what the first three responses times this sum to: about the luminance of the light."""
        channels = self.sensitivities[:, :3] * STEP_NM
        wanted = colour_matching_functions()[:, 1] * STEP_NM
        return np.asarray(np.linalg.lstsq(channels, wanted)[0], np.float32)

    @property
    def _channels(self) -> int:
        return int(self.sensitivities.shape[1])

    # Within: arrays of rows a pixel long, (C, P) responses and (N, P) of the estimates, which a processor works through fastest.

    def _squared(self, columns: FloatArray, roots: FloatArray) -> FloatArray:
        """Y' A y for every A = root root', roots side by side (C, N C): (N, P)."""
        products = product(roots.T, columns).reshape(len(self.estimates), -1, columns.shape[-1])
        np.multiply(products, products, out=products)
        return np.asarray(products.sum(1))

    def _likely(self, columns: FloatArray, squared: FloatArray, chance: FloatArray) -> FloatArray:
        """How probable each estimate's kind is, (N, P), from `_squared` by the precisions and `direct` of `recover` (P,)."""
        norm = np.maximum((columns * columns).sum(0), _TINY)
        logs = np.log(np.maximum(squared / norm, _TINY))
        logs *= -np.float32(self._channels / 2 + 1)
        logs += self._log_shares[:, None]
        with np.errstate(divide="ignore"):
            of_chance = {True: np.log(chance), False: np.log(1 - chance), None: np.float32(0)}
        for number, estimate in enumerate(self.estimates):
            logs[number] += of_chance[estimate.direct]
        logs -= logs.max(0)
        np.exp(logs, out=logs)
        logs /= logs.sum(0)
        return logs

    def _unlikeness(self, squared: FloatArray, energy: FloatArray) -> FloatArray:
        """`unlikeness` (N, P) from `_squared` by the precisions, and by the operators."""
        expected = np.maximum(np.float32(self._channels) * energy, _TINY)
        return np.asarray(np.maximum(squared / expected, np.float32(1)))

    def _weights(self, columns: FloatArray, likely: FloatArray, index: npt.NDArray[np.uint8]) -> FloatArray:
        """Weights (K, P) of the mean of the estimates."""
        parts = (likely[:, None] * columns).reshape(-1, columns.shape[-1])
        if len(self.bases) == 1:
            return product(self._to_weights[0].T, parts)
        weights = np.empty((self.bases.shape[1], columns.shape[-1]), np.float32)
        for basis in np.unique(index):
            chosen = np.flatnonzero(index == basis)
            weights[:, chosen] = product(self._to_weights[basis].T, parts[:, chosen])
        return weights

    @cached_property
    def _precision_roots(self) -> FloatArray:
        return _side_by_side([np.linalg.cholesky(estimate.precision) for estimate in self.estimates])

    @cached_property
    def _operator_roots(self) -> FloatArray:
        """Roots R with R R' = L L' for the operators L: |y L| = |y R|."""
        return _side_by_side([np.linalg.qr(estimate.operator.T)[1].T for estimate in self.estimates])

    @cached_property
    def _log_shares(self) -> FloatArray:
        return np.array(
            [
                0.5 * np.linalg.slogdet(estimate.precision)[1] + np.log(estimate.share)
                for estimate in self.estimates
            ],
            np.float32,
        )

    @cached_property
    def _to_weights(self) -> FloatArray:
        """From the responses times the probabilities, estimate by estimate, to weights: (B, N C, K)."""
        operators = np.concatenate([estimate.operator for estimate in self.estimates])
        return np.asarray(operators @ np.swapaxes(self.bases, 1, 2), np.float32)

    def _relative_error(
        self,
        columns: FloatArray,
        squared: FloatArray,
        likely: FloatArray,
        weights: FloatArray,
        variance: FloatArray,
    ) -> FloatArray:
        """Within the kinds of light, between them, and from the photographs' noise: (P,)."""
        energy = self._squared(columns, self._operator_roots)
        within = np.array([np.trace(estimate.error) for estimate in self.estimates], np.float32)
        unlike = self._unlikeness(squared, energy)
        spread = (likely * energy * (1 + within[:, None] * unlike + self.strangeness(unlike))).sum(0)
        mean = (weights * weights).sum(0)  # the basis is orthonormal
        gains = np.array([(estimate.operator**2).sum(-1) for estimate in self.estimates], np.float32)
        noise = (variance * product(gains.T, likely)).sum(0)
        return np.asarray(np.sqrt(np.maximum(spread - mean + noise, 0) / np.maximum(mean, _TINY)))

    def _make_positive(
        self, weights: FloatArray, index: npt.NDArray[np.uint8], columns: FloatArray, safe: FloatArray
    ) -> None:
        """Change those of the weights (K, P) whose spectra have negative parts."""
        for basis in np.unique(index):
            own = np.flatnonzero(index == basis)
            kept = self._functions[basis], safe[basis].astype(np.float32)
            low = own[negative(weights[:, own], *kept)]
            if low.size:
                seen = (kept[0] @ self.sensitivities * STEP_NM).astype(np.float32)
                weights[:, low] = lifted(weights[:, low], columns[:, low], kept[0], seen, kept[1])

    @cached_property
    def _functions(self) -> FloatArray:
        return self.bases.astype(np.float32)


def _columns(responses: FloatArray) -> FloatArray:
    """Responses (..., C) as (C, P)."""
    return np.array(responses.reshape(-1, responses.shape[-1]).T, np.float32, order="C")


def _side_by_side(matrices: Sequence[FloatArray]) -> FloatArray:
    return np.concatenate(matrices, axis=1).astype(np.float32)


def spectral_recovery(
    sensitivities: FloatArray,
    families: Sequence[str],
    method: str = "family",
    own_lights: FloatArray | None = None,
) -> SpectralRecovery:
    """Prepare the recovery of spectra for a camera and the lamp families that may be present.

    Parameters
    ----------
    sensitivities
        (61, C) camera sensitivities: three channels, and three more for every filter.
    families
        Lamp families of `library.FAMILIES`, or "automatic".
    method
        One of `METHODS`.
    own_lights
        (N, 61) measured lights of the user's that may be there too.

    Raises
    ------
    SpectralDataError
        If the method or a family is unknown, or the channels do not differ.

    Examples
    --------
    A light of the family comes back from its camera responses:

    >>> from .camera import camera_sensitivities
    >>> from .colorimetry import illuminant
    >>> camera = camera_sensitivities("Nikon 5100 (NPL)")
    >>> recovery = spectral_recovery(camera, ["incandescent", "daylight"])
    >>> light = illuminant("A")
    >>> found = recovery.recover(light @ camera * 5)
    >>> estimate = found.weights @ recovery.bases[found.basis_index]
    >>> bool(np.linalg.norm(estimate - light) / np.linalg.norm(light) < 0.03)
    True
    """
    if method not in METHODS:
        raise SpectralDataError(
            f'There is no recovery method "{method}". Choose one of {", ".join(METHODS)}.'
        )
    classes = light_classes([AUTOMATIC] if method == "automatic" else families, own_lights)
    return recovery_for(classes, sensitivities, method)


def recovery_for(
    classes: Sequence[LightClass], sensitivities: FloatArray, method: str = "family"
) -> SpectralRecovery:
    """The recovery of light of some classes."""
    channels = np.asarray(sensitivities, float) * STEP_NM
    _check_channels(channels)
    if method == "paper":
        lights = classes[0].spectra  # each class seen directly holds them all
        basis = principal_components(lights, channels.shape[1])
        estimate = inverse_estimate(lights, channels, basis)
        return SpectralRecovery(
            np.asarray(sensitivities), (estimate,), basis[None], None, basis.T @ basis / len(basis), method
        )
    estimates = tuple(wiener_estimate(light_class, channels) for light_class in classes)
    examples = np.concatenate([light_class.spectra[light_class.members] for light_class in classes])
    examples = examples[:: -(-len(examples) // _EXAMPLES)]
    bases = _bases(estimates, np.asarray(sensitivities), examples @ channels)
    safe = np.stack([positive_weights(basis, examples) for basis in bases])
    moment = np.mean([light_class.moment for light_class in classes], axis=0)
    return SpectralRecovery(np.asarray(sensitivities), estimates, bases, safe, moment, method)


def _check_channels(channels: FloatArray) -> None:
    values = np.linalg.svd(channels / np.maximum(channels.max(0), 1e-30), compute_uv=False)
    if not np.isfinite(channels).all() or values[-1] < _SINGULAR * values[0]:
        raise SpectralDataError(
            "Two of the channels see the same light, so no spectrum can be told from them. "
            "Check the camera's sensitivities, and that the filter is not clear or black."
        )


def _bases(
    estimates: Sequence[ClassEstimate], sensitivities: FloatArray, responses: FloatArray
) -> FloatArray:
    """One basis for all estimates if that takes no more than `MOST_WEIGHTS` functions, else one for each."""
    by_class = np.concatenate([responses @ estimate.operator for estimate in estimates])
    single = spanning(np.concatenate([by_class, np.maximum(by_class, 0)]), MOST_WEIGHTS, _TOLERANCE)
    if not_held(by_class, single) < _TOLERANCE:
        return single[None]
    nothing = np.zeros((1, 1, sensitivities.shape[0]))
    mixed = SpectralRecovery(sensitivities, tuple(estimates), nothing, None, nothing[0], "family")
    chances = np.linspace(0.0, 1.0, 3)
    likely = np.concatenate([mixed.probabilities(responses, np.full(len(responses), p)) for p in chances])
    repeated = np.tile(responses, (len(chances), 1))
    means = sum(
        probability[:, None] * (repeated @ estimate.operator)
        for probability, estimate in zip(likely.T, estimates, strict=True)
    )
    held = np.maximum(means, 0)
    bases = [
        spanning(held[likely.argmax(-1) == number], MOST_WEIGHTS, _TOLERANCE, first=estimate.operator)
        for number, estimate in enumerate(estimates)
    ]
    functions = max(len(basis) for basis in bases)
    return np.stack([np.pad(basis, ((0, functions - len(basis)), (0, 0))) for basis in bases])

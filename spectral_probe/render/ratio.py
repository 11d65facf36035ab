"""Transport of a pass with few samples, as a ratio to a reference pass with many.

With the same seed and an unchanged world, the noise of two wavelengths is mostly the same noise: the same paths, each with
another product of reflectances. So the few-sample image over the reference's own first samples, as many, has far less noise
than either, and times the full reference it is nearly a full pass:

    T = reference_full * q * F[low / q] / F[reference_low]

F is an edge-aware mean (the domain transform of Gastal & Oliveira, Domain Transform for Edge-Aware Image and Video
Processing, ACM TOG 30(4), 2011, doi:10.1145/2010324.1964964) that stops at edges of the guide: albedo, normal, object, and
of the reference image. q, the ratio of the first surface's albedos at the two wavelengths, takes textures out before the
mean and puts them back; where a pass has no albedo of its own, q is 1. Three corrections follow:

- The ratio of two means is biased by the noise of the denominator; to second order by what Beale's estimator takes off
  (Some uses of computers in operational research, Industrielle Organisation 31, 1962; Cochran, Sampling Techniques, 1977,
  sect. 6.15).
- What a smooth ratio cannot follow (the sharp reflection of a coloured pattern in a ball, light through glass) is left in
  the residual low - q R reference_low. Its local means are added as far as they stand out of their noise, shrunk by
  1 - c v / m^2 as James & Stein (1961) do: where the ratio holds nothing is added, where it fails the few samples
  themselves are the estimate.
- The energy of each surface at large is set to that of a ratio of sums over it, whose bias vanishes with their size.
"""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np

from ..model import FloatArray

type Mean = Callable[[FloatArray], FloatArray]

_SPATIAL_PX = 8.0
"""Standard deviation of the edge-aware mean; the ratio is smooth once albedo is taken out."""

_EDGE = 1.5
"""Distance in guide space that counts as a whole spatial standard deviation."""

_STRUCTURE = 1.5
"""Weight of the reference image's own edges (logarithm of its median-filtered luminance)."""

_OUTLIER = 20.0
"""A sample this many times its surroundings, in the full reference and in the pass, is a firefly of the few samples: it
weighs less, in numerator and denominator alike."""

_NEIGHBOURS = (15, 15)
_SCALES_PX = (7, 3)
_SHRINK, _SHRINK_UNGUIDED = 9.0, 4.0
"""Squared signal to noise below which a local mean of the residual is taken for noise, with and without the pass's own
albedo: without it more is left to the residual, at the price of some fireflies, one of which reaches 5.4 in such a mean."""

_ABOVE_NEIGHBOURS = 1.2
"""How far an estimate may exceed the brightest of the pass's own samples beside it, and still its reference."""

_FLOOR = 1e-3
"""Radiance, relative to the reference's mean, below which a ratio means nothing: it tends to 1 there."""

_LARGE_PX = 30.0
"""Standard deviation of the mean over which a surface's energy is set."""

_EVEN = 0.5
"""Largest range of the normal's components and of the object index about a pixel that lies within a surface."""

_REDUCED = 4
"""A mean over so many pixels is taken of an image reduced by this factor."""

_ALBEDO_FLOOR = 0.01
_TILT = np.array([[1.0, 0.3], [0.2, 1.0], [0.7, -0.5]], np.float32)
"""Two mixtures of the normal's three components: the domain transform takes at most four channels."""


def transport(
    low: FloatArray,
    reference_low: FloatArray,
    reference_full: FloatArray,
    guide: FloatArray | None = None,
    low_guide: FloatArray | None = None,
) -> FloatArray:
    """Transport of a pass as of all samples, from a few of them and a reference pass.

    Parameters
    ----------
    low
        (H, W, 3) the pass, few samples.
    reference_low
        (H, W, 3) the reference pass: its first samples, as many, of the same seed.
    reference_full
        (H, W, 3) the reference pass, all samples.
    guide
        (H, W, 7) albedo, normal, object index of the reference; other features by other widths: see `RatioFilter`.
    low_guide
        (H, W, 7) the same of the pass itself; with it, textures are exact.

    Returns
    -------
    ndarray
        (H, W, 3) float32, not negative where the passes are not, finite, 0 where all of them are 0.

    Examples
    --------
    A pass that is half its reference everywhere is found exactly, whatever the noise they share:

    >>> noise = np.random.default_rng(0).exponential(size=(2, 8, 8, 3)).astype(np.float32)
    >>> estimate = transport(0.5 * noise[0], noise[0], noise.mean(0))
    >>> bool(np.allclose(estimate, 0.5 * noise.mean(0), rtol=1e-2, atol=1e-3))
    True
    """
    return RatioFilter(reference_low, reference_full, guide).transport(low, low_guide)


class RatioFilter:
    """What all passes that are ratios of one reference share; see `transport` for the parameters."""

    def __init__(
        self, reference_low: FloatArray, reference_full: FloatArray, guide: FloatArray | None = None
    ) -> None:
        self._low = np.ascontiguousarray(reference_low, np.float32)
        self._full = np.ascontiguousarray(reference_full, np.float32)
        self._guide = guide
        luminance = np.ascontiguousarray(self._full.mean(-1))
        level = float(np.abs(luminance).mean())
        self._floor = np.float32(_FLOOR * level + 1e-12)
        self._surfaces = _surfaces(guide, luminance.shape)
        usual = np.maximum(cv2.medianBlur(luminance, 5), 0.0) + 0.05 * level + 1e-12
        self._structure = _STRUCTURE * np.log(usual)
        if guide is not None:
            self._structure += 1.5 * np.log(np.maximum(guide[..., :3].mean(-1), 0.0) + 0.05)
        height, width = luminance.shape
        small = (max(width // _REDUCED, 1), max(height // _REDUCED, 1))
        coarse = cv2.resize(self._surfaces, small, interpolation=cv2.INTER_NEAREST)
        large = _edge_aware_mean(coarse, _LARGE_PX / _REDUCED)
        self._large_mean: Mean = lambda image: large(cv2.resize(image, small, interpolation=cv2.INTER_AREA))

    def transport(self, low: FloatArray, low_guide: FloatArray | None = None) -> FloatArray:
        """Transport (H, W, 3) of a pass from its few samples `low`; see `transport`."""
        low = np.asarray(low, np.float32)
        albedo_ratio = _albedo_ratio(self._guide, low_guide, low.shape[:2])
        mean = _edge_aware_mean(self._edges(albedo_ratio), _SPATIAL_PX)
        even = low / albedo_ratio
        usual = np.maximum(np.maximum(mean(self._full), cv2.blur(even, _NEIGHBOURS)), self._floor)
        weight = np.minimum(1.0, _OUTLIER * usual / np.maximum(np.maximum(self._low, even), self._floor))
        ratio = albedo_ratio * _ratio_of_means(even * weight, self._low * weight, mean, self._floor)
        estimate = _within_neighbours(self._full * ratio, low, self._full)
        shrink = _SHRINK_UNGUIDED if low_guide is None else _SHRINK
        estimate = np.maximum(estimate + _significant_residual(low - ratio * self._low, shrink), 0.0)
        pure = weight * _within_surfaces(self._guide)
        return self._with_energy_of(low * pure, self._low * pure, estimate, pure)

    def _with_energy_of(
        self, low: FloatArray, reference_low: FloatArray, estimate: FloatArray, pure: FloatArray
    ) -> FloatArray:
        """The estimate with the energy at large of the full reference times the ratio of the few samples' energies.

        Pixels on edges of surfaces are left out: how much of each surface the few samples saw there would decide.
        """
        energy, full = self._large_mean(estimate * pure), self._large_mean(self._full * pure)
        # Where the reference has no light to speak of, the residual made the estimate, and the factor tends to 1.
        dark = 10.0 * self._floor * (energy + self._floor)
        factor = (self._large_mean(low) * full + dark) / (self._large_mean(reference_low) * energy + dark)
        height, width = estimate.shape[:2]
        return np.asarray(estimate * cv2.resize(np.clip(factor, 0.5, 2.0), (width, height)))

    def _edges(self, albedo_ratio: FloatArray) -> FloatArray:
        """(H, W, 4) what the mean must not cross: albedo, structure and object; normal; the albedos' ratio."""
        edges = self._surfaces.copy()
        edges[..., 0] += self._structure
        edges[..., 3] = np.log(albedo_ratio[..., 0] + 0.05)
        return edges


def _edge_aware_mean(edges: FloatArray, spatial_px: float) -> Mean:
    transform = cv2.ximgproc.createDTFilter(edges, spatial_px, _EDGE, cv2.ximgproc.DTF_NC, 3)

    def mean(image: FloatArray) -> FloatArray:
        return np.asarray(transform.filter(np.ascontiguousarray(image, np.float32)))

    return mean


def _ratio_of_means(
    numerator: FloatArray, denominator: FloatArray, mean: Mean, floor: np.float32
) -> FloatArray:
    """Mean over mean, with Beale's correction for the noise of the denominator."""
    over, under = mean(numerator), mean(denominator)
    # How much a mean shrinks variance, 1 / (number of pixels it takes), measured on white noise.
    noise = np.random.default_rng(0).standard_normal(over.shape[:2]).astype(np.float32)
    share = cv2.blur(mean(noise) ** 2, (9, 9))[..., None]
    variance = np.maximum(mean(denominator**2) - under**2, 0.0) * share
    covariance = (mean(numerator * denominator) - over * under) * share
    correction = (1.0 + covariance / (over * under + floor**2)) / (1.0 + variance / (under**2 + floor**2))
    return np.asarray((over + floor) / (under + floor) * np.clip(correction, 0.5, 2.0))


def _surfaces(guide: FloatArray | None, size: tuple[int, ...]) -> FloatArray:
    """(H, W, 4) features of surfaces: object index, normal; the fourth is left free."""
    surfaces = np.zeros((*size, 4), np.float32)
    if guide is not None:
        surfaces[..., 0] = 3.0 * guide[..., 6]
        surfaces[..., 1:3] = guide[..., 3:6] @ _TILT
    return surfaces


def _within_surfaces(guide: FloatArray | None) -> FloatArray | float:
    """(H, W, 1) 1 within a surface, 0 on its edges; 1 without a guide."""
    if guide is None:
        return 1.0
    features = np.ascontiguousarray(guide[..., 3:7], np.float32)
    neighbours = np.ones((3, 3), np.uint8)
    spread = cv2.dilate(features, neighbours) - cv2.erode(features, neighbours)
    return np.asarray((spread.max(-1, keepdims=True) < _EVEN), np.float32)


def _albedo_ratio(
    guide: FloatArray | None, low_guide: FloatArray | None, size: tuple[int, ...]
) -> FloatArray:
    """(H, W, 1) albedo of the first surface in the pass over that in the reference, 1 where it is not known."""
    if guide is None or low_guide is None:
        return np.ones((*size, 1), np.float32)
    own, reference = (
        np.maximum(features[..., :3].mean(-1, keepdims=True), 0.0) for features in (low_guide, guide)
    )
    return np.asarray((own + _ALBEDO_FLOOR) / (reference + _ALBEDO_FLOOR), np.float32)


def _within_neighbours(estimate: FloatArray, low: FloatArray, full: FloatArray) -> FloatArray:
    """A highlight or firefly of the reference does not take a ratio above 1 from the dark surface round it."""
    around = np.asarray(cv2.dilate(low, np.ones((3, 3), np.uint8)))
    return np.minimum(estimate, np.maximum(_ABOVE_NEIGHBOURS * around, full))


def _significant_residual(residual: FloatArray, shrink: float) -> FloatArray:
    """Local means of a residual (H, W, 3), coarse to fine, as far as they stand out of their noise."""
    total = np.zeros_like(residual)
    for size in _SCALES_PX:
        local = cv2.blur(residual, (size, size))
        variance = cv2.blur((residual - local) ** 2, (2 * size + 1,) * 2) / size**2
        shrunk = local * np.maximum(0.0, 1.0 - shrink * variance / np.maximum(local**2, 1e-30))
        total += shrunk
        residual = residual - shrunk
    return total

"""A bracket of photographs merged into radiance, weighted by how much each pixel's noise lets it say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from ..errors import PhotographError
from ..model import BoolArray, Exposure, FloatArray, Photograph, RadianceImage
from ..parallel import in_parallel, processors
from .noise import (
    BLACK_ENTRY,
    SensorNoise,
    Table,
    code_index,
    code_table,
    display_light,
    display_variance,
    noise_polynomial,
)
from .response import ResponseCurve

PIXELS_AT_ONCE = 12_000
"""Rows are merged in strips of about so many pixels, which stay in the processor's cache through all of the steps."""

BUFFERS = 4


def merge(
    photographs: Sequence[Photograph],
    exposures: Sequence[Exposure],
    response: ResponseCurve | None = None,
    sensor: SensorNoise | None = None,
    moved: Sequence[BoolArray | None] | None = None,
) -> RadianceImage:
    """Merge aligned photographs into relative radiance.

    With x = radiance times relative exposure t, every unclipped photograph is an estimate x / t of variance
    s^2(x) / t^2; the inverse variances are the weights. The variance is computed from a first estimate of the radiance,
    all photographs together with weights t, and not from the photograph's own noisy value, which would favour values that
    are too low. Display-referred photographs, whose errors are relative, are averaged by their logarithms.

    Parameters
    ----------
    photographs
        Photographs of one size, aligned.
    exposures
        One per photograph.
    response
        The camera's response, where it was estimated for display-referred photographs; otherwise sRGB stands for it.
    sensor
        The sensor's constants; typical ones if None.
    moved
        For each photograph (H, W) where it shows something else than the others (None: nowhere). Such pixels count only where
        no other photograph has one.

    Returns
    -------
    RadianceImage
        Radiance (H, W, 3) per unit of relative exposure, and its variance. Where every photograph is
        clipped, `valid` is False, the radiance the highest lower bound, and the variance infinite.

    Notes
    -----
    The noise model is shot noise plus read noise [1]_; weights t are that paper's estimate under shot noise alone. For
    display-referred photographs, steps of 8 bits and the error of the tone curve take their place.

    References
    ----------
    .. [1] Hanji, P., Zhong, F., & Mantiuk, R. K. (2020). Noise-Aware Merging of High Dynamic Range Image
       Stacks without Camera Calibration. ECCV Workshops. doi:10.1007/978-3-030-67070-2_23
    """
    _check(photographs, exposures)
    height, width = photographs[0].clipped.shape
    merger: _Merger
    if photographs[0].display_referred:
        merger = _display_merger(photographs, exposures, response, sensor or SensorNoise())
    else:
        merger = _linear_merger(photographs, exposures, sensor or SensorNoise())
    areas = list(moved) if moved is not None else [None] * len(photographs)
    radiance = np.empty((height, width, 3), np.float32)
    variance = np.empty((height, width, 3), np.float32)
    valid = np.empty((height, width), bool)
    step = max(1, PIXELS_AT_ONCE // max(width, 1))
    workers = max(1, min(processors(), height // step))

    def work(worker: int) -> None:
        buffers = np.empty((BUFFERS, step, width, 3), np.float32)
        for start in range(worker * step, height, workers * step):
            rows = slice(start, min(start + step, height))
            kept = _kept(photographs, areas, rows)
            seen = np.any(kept, axis=0)
            merger.merge_rows(
                rows, kept, radiance[rows], variance[rows], buffers[:, : rows.stop - rows.start]
            )
            if not seen.all():
                radiance[rows][~seen] = merger.lower_bound(rows, ~seen)
                variance[rows][~seen] = np.inf
            valid[rows] = seen

    in_parallel(work, range(workers))
    return RadianceImage(radiance, variance, valid)


def _check(photographs: Sequence[Photograph], exposures: Sequence[Exposure]) -> None:
    if not photographs:
        raise PhotographError("The view has no photographs. List them as photos in the capture file.")
    if len(photographs) != len(exposures):
        raise PhotographError(
            f"{len(exposures)} exposures for {len(photographs)} photographs. Give one for each photograph."
        )
    first = photographs[0]
    for photograph in photographs:
        if photograph.pixels.shape != first.pixels.shape:
            raise PhotographError(
                f"{photograph.path.name} and {first.path.name} have different sizes. Use photographs of one bracket."
            )


def _kept(
    photographs: Sequence[Photograph], areas: Sequence[BoolArray | None], rows: slice
) -> list[BoolArray]:
    """Where each photograph counts (h, W): unclipped, and not moved unless no other is left."""
    free = [~photograph.clipped[rows] for photograph in photographs]
    if all(area is None for area in areas):
        return free
    still = [one if area is None else one & ~area[rows] for one, area in zip(free, areas, strict=True)]
    alone = ~np.any(still, axis=0)
    return [one | (alone & other) for one, other in zip(still, free, strict=True)]


class _Merger(Protocol):
    """Merges strips of a bracket of one kind."""

    def merge_rows(
        self, rows: slice, kept: Sequence[BoolArray], radiance: Table, variance: Table, buffers: Table
    ) -> None:
        """Fill `radiance` and `variance` (h, W, 3) of some rows; `kept` (h, W) where each photograph counts."""

    def lower_bound(self, rows: slice, where: BoolArray) -> FloatArray:
        """The highest radiance (N, 3) that any photograph tells at the pixels `where` (h, W)."""


@dataclass(frozen=True)
class _LinearMerger:
    """Linear photographs: `pixels`, relative exposures and, for each, the noise polynomial of its values."""

    pixels: Sequence[FloatArray]
    relatives: Sequence[float]
    noise: Sequence[tuple[float, float, float]]

    def merge_rows(
        self, rows: slice, kept: Sequence[BoolArray], radiance: Table, variance: Table, buffers: Table
    ) -> None:
        """Weights from the first estimate: see `merge`."""
        estimate, weight, product, share = buffers
        everywhere = [bool(one.all()) for one in kept]
        self._first_estimate(rows, kept, everywhere, estimate, product)
        radiance[...] = 0.0
        weights = variance
        weights[...] = 0.0
        for number, (pixels, relative, noise) in enumerate(
            zip(self.pixels, self.relatives, self.noise, strict=True)
        ):
            constant, linear, square = noise
            # 1 / weight, for an estimate value / t of variance s^2 / t^2, written for x instead of x t.
            np.multiply(estimate, np.float32(square * relative), out=weight)
            weight += np.float32(linear)
            weight *= estimate
            weight += np.float32(constant / relative)
            if everywhere[number]:
                np.divide(np.float32(1.0), weight, out=weight)
            else:
                np.divide(_threefold(kept[number], share), weight, out=weight)
            radiance += np.multiply(weight, pixels[rows], out=product)
            weight *= np.float32(relative)
            weights += weight
        _finish(radiance, weights)

    def _first_estimate(
        self,
        rows: slice,
        kept: Sequence[BoolArray],
        everywhere: Sequence[bool],
        estimate: Table,
        product: Table,
    ) -> None:
        """Sum of the values over the sum of the exposures that made them, at least 0."""
        estimate[...] = 0.0
        exposure = np.zeros(kept[0].shape, np.float32)
        for pixels, relative, one, whole in zip(self.pixels, self.relatives, kept, everywhere, strict=True):
            if whole:
                estimate += pixels[rows]
                exposure += np.float32(relative)
            else:
                estimate += np.multiply(pixels[rows], _threefold(one, product), out=product)
                exposure += one * np.float32(relative)
        np.divide(np.float32(1.0), np.maximum(exposure, np.float32(1e-30)), out=exposure)
        estimate *= _threefold(exposure, product)
        np.maximum(estimate, np.float32(0.0), out=estimate)

    def lower_bound(self, rows: slice, where: BoolArray) -> FloatArray:
        """Values over exposures."""
        bounds = [
            pixels[rows][where] / relative
            for pixels, relative in zip(self.pixels, self.relatives, strict=True)
        ]
        return np.asarray(np.max(bounds, axis=0))


@dataclass(frozen=True)
class _DisplayMerger:
    """Display-referred photographs: for each, tables of weight times the radiance's logarithm, and of the weight, by the code.

    Their errors are relative, the tone curve's above all: the mean is that of logarithms, since among values that
    contradict each other a mean weighted by absolute variances would side with the lowest.
    """

    pixels: Sequence[FloatArray]
    weighted: Sequence[Table]
    weights: Sequence[Table]
    radiance: Sequence[Table]

    def merge_rows(
        self, rows: slice, kept: Sequence[BoolArray], radiance: Table, variance: Table, buffers: Table
    ) -> None:
        """Two tables for every photograph."""
        import cv2

        product = buffers[0]
        radiance[...] = 0.0
        variance[...] = 0.0
        for pixels, weighted, weights, one in zip(
            self.pixels, self.weighted, self.weights, kept, strict=True
        ):
            index = code_index(pixels[rows], product)
            if not one.all():
                index *= np.asarray(cv2.merge([one.view(np.uint8).astype(np.uint16)] * 3))
            radiance += cv2.LUT(index, weighted, dst=product)
            variance += cv2.LUT(index, weights, dst=product)
        _finish(radiance, variance)
        np.exp(radiance, out=radiance)
        variance *= radiance
        variance *= radiance

    def lower_bound(self, rows: slice, where: BoolArray) -> FloatArray:
        """By the response, which is extrapolated there."""
        import cv2

        bounds = []
        for pixels, table in zip(self.pixels, self.radiance, strict=True):
            values = np.asarray(pixels[rows][where], np.float32)[None]
            bounds.append(cv2.LUT(code_index(values, np.empty_like(values)), table)[0])
        return np.asarray(np.max(bounds, axis=0))


def _linear_merger(
    photographs: Sequence[Photograph], exposures: Sequence[Exposure], sensor: SensorNoise
) -> _LinearMerger:
    return _LinearMerger(
        [photograph.pixels for photograph in photographs],
        [exposure.relative for exposure in exposures],
        [noise_polynomial(*each, sensor) for each in zip(photographs, exposures, strict=True)],
    )


def _display_merger(
    photographs: Sequence[Photograph],
    exposures: Sequence[Exposure],
    response: ResponseCurve | None,
    sensor: SensorNoise,
) -> _DisplayMerger:
    light = display_light(response)
    light = np.maximum(light, light[BLACK_ENTRY])  # of black itself there is no logarithm
    weighted, weights, radiance = [], [], []
    for exposure in exposures:
        weight = light**2 / display_variance(response, light, exposure, sensor)
        radiance.append(code_table(light / exposure.relative))
        weighted.append(code_table(weight * np.log(light / exposure.relative)))
        weights.append(code_table(weight))
    return _DisplayMerger([photograph.pixels for photograph in photographs], weighted, weights, radiance)


def _threefold(plane: npt.NDArray[np.generic], out: Table) -> Table:
    """A plane (h, W) for each of the three channels."""
    import cv2

    return np.asarray(cv2.merge([np.asarray(plane, np.float32)] * 3, out))


def _finish(weighted: Table, weights: Table) -> None:
    """Sums into means and their variances, in place; without any weight, 0 and infinity."""
    with np.errstate(divide="ignore", invalid="ignore"):
        np.divide(np.float32(1.0), weights, out=weights)
        weighted *= weights

"""Photographs taken again through filters: three further channels each, for the same light.

A bracket through a filter of transmittance tau belongs to the view without a filter that has the same three angles (the tripod
stayed). Its channels see the light through tau R_k: with one filter there are six channels, with two nine.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .errors import CaptureError
from .model import FloatArray, ViewSettings
from .spectra.glass import glass_transmittance
from .spectra.grid import WAVELENGTHS_NM
from .spectra.recovery import MOST_WEIGHTS

_MOST_FILTERS = MOST_WEIGHTS // 3 - 1

_LEAST_LIGHT = 1e-3
"""A filter that passes less of an even light than this leaves nothing to measure."""

_LEAST_CHANGE = 0.01
"""A filter whose transmittance varies by less than this, relative to its largest, tells nothing new: it is grey."""


@dataclass(frozen=True)
class FilterSets:
    """Which views were taken through which filter.

    `transmittances` (G, 61), the first all ones: no filter. `group` (V,) is the filter of each view, and `partner` (V,) the
    view without a filter that it belongs to, which is itself for those without.
    """

    transmittances: FloatArray
    group: tuple[int, ...]
    partner: tuple[int, ...]

    @property
    def leaders(self) -> tuple[int, ...]:
        """The views without a filter."""
        return tuple(view for view, group in enumerate(self.group) if group == 0)

    def sensitivities(self, camera: FloatArray) -> FloatArray:
        """Of all channels, (61, 3 G), for the camera's (61, 3): three without a filter, then three for each filter."""
        return np.concatenate([camera * filtered[:, None] for filtered in self.transmittances], axis=-1)


def filter_sets(views: Sequence[ViewSettings]) -> FilterSets:
    """The filters of a capture's views, and what belongs together.

    Raises
    ------
    SpectralProbeError
        If there are too many filters, a view through one has no partner, or one cannot be used.
    """
    filters: list[str | Path | None] = [None]
    for view in views:
        if view.filter not in filters:
            filters.append(view.filter)
    if len(filters) > _MOST_FILTERS + 1:
        raise CaptureError(
            f"The views were taken through {len(filters) - 1} filters, but a pixel has weights for {MOST_WEIGHTS} channels. "
            f"Use {_MOST_FILTERS} filters at most."
        )
    curves = [np.ones(len(WAVELENGTHS_NM)), *(_transmittance(name) for name in filters[1:])]
    return FilterSets(
        np.stack(curves),
        tuple(filters.index(view.filter) for view in views),
        tuple(_partner(views, number) for number in range(len(views))),
    )


def _partner(views: Sequence[ViewSettings], number: int) -> int:
    """The view without a filter that a view belongs to."""
    view = views[number]
    if view.filter is None:
        return number
    angles = _angles(view)
    same = [other for other, one in enumerate(views) if one.filter is None and _angles(one) == angles]
    if not same:
        raise CaptureError(
            f"View {number + 1} was taken through a filter, but no view without a filter has its azimuth {angles[0]:g}, "
            f"elevation {angles[1]:g} and roll {angles[2]:g}. Add the photographs without the filter, or correct the angles."
        )
    return min(same, key=lambda other: abs(other - number))


def _angles(view: ViewSettings) -> tuple[float, float, float]:
    """To a thousandth of a degree, since Blender keeps radians."""
    return (round(view.azimuth_deg % 360.0, 3), round(view.elevation_deg, 3), round(view.roll_deg, 3))


def _transmittance(filter_name: str | Path | None) -> FloatArray:
    curve = glass_transmittance(str(filter_name))
    name = Path(str(filter_name)).name
    if curve.mean() < _LEAST_LIGHT:
        raise CaptureError(f"The filter {name} lets no light through. Check its file.")
    if np.ptp(curve) < _LEAST_CHANGE * curve.max():
        raise CaptureError(
            f"The filter {name} is grey: it lets all wavelengths through alike and adds nothing. Use a coloured one."
        )
    return curve

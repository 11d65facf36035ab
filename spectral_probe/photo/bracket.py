"""An aligned bracket made into one radiance image: exposures checked, response estimated, moved things left out, merged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import PhotographError
from ..model import BoolArray, Exposure, Photograph, RadianceImage
from .exposure_check import LEAST_CELLS, ExposureCheck, check_exposures, described
from .merge import merge
from .moved import moved_areas
from .response import ResponseCurve, fit_response
from .samples import Cells, cells_of, chosen
from .sensor import sensor_noise

LEAST_SPREAD_EV = 0.5
"""Exposures nearer than this to each other tell nothing of a tone curve."""

WORST_RESIDUAL_EV = 0.5
"""Beyond this disagreement about the light a response is no description of the camera."""


@dataclass(frozen=True)
class MergedBracket:
    """A bracket merged into `image`, and how.

    `exposures` (E,) are those used; `offsets_ev` (E,) what the pixels say minus what was stated, NaN where they say nothing;
    `response` of the camera, None for linear photographs and where it could not be estimated; `moved` (H, W) True where some
    photograph was not used because it disagrees with the others; `warnings` one sentence each.
    """

    image: RadianceImage
    exposures: tuple[Exposure, ...]
    offsets_ev: tuple[float, ...]
    response: ResponseCurve | None
    moved: BoolArray
    warnings: tuple[str, ...]


def merge_bracket(
    photographs: Sequence[Photograph],
    stated: Sequence[Exposure],
    on_ball: BoolArray,
    *,
    solve_exposures: bool = True,
) -> MergedBracket:
    """Merge an aligned bracket, trusting its stated exposures only as far as the pixels bear them out.

    Parameters
    ----------
    photographs
        Aligned, of one size (H, W): cut to the ball and as much round it as whoever interpolates at its rim needs.
    stated
        Their exposures as the capture file or EXIF has them.
    on_ball
        (H, W) where the ball's picture is: only there is a hand-held bracket aligned. Exposures and response are measured
        there.
    solve_exposures
        Whether exposures that contradict the pixels are replaced; they are named in any case.
    """
    if len(photographs) != len(stated):
        raise PhotographError(
            f"{len(stated)} exposures for {len(photographs)} photographs. Give one for each photograph."
        )
    copies, warnings = _exact_duplicates(photographs, stated)
    cells = cells_of(photographs, on_ball)
    if cells.encoded:
        cells = chosen(cells)
    check = check_exposures(photographs, stated, cells, solve=solve_exposures)
    warnings += check.warnings
    single = [index for index in range(len(photographs)) if index not in copies]
    response = None
    if cells.encoded:
        response, said = _response(cells, check, single)
        warnings += said
    kept = [photographs[index] for index in single]
    used = [check.exposures[index] for index in single]
    sensor = sensor_noise(kept, used, on_ball)
    areas = moved_areas(kept, used, on_ball, response, sensor)
    moved = np.zeros(on_ball.shape, bool)
    for area in areas:
        if area is not None:
            moved |= area
    return MergedBracket(
        merge(kept, used, response, sensor, areas),
        check.exposures,
        check.offsets_ev,
        response,
        moved,
        tuple(warnings),
    )


def _exact_duplicates(
    photographs: Sequence[Photograph], stated: Sequence[Exposure]
) -> tuple[set[int], list[str]]:
    """Photographs that hold the very pixels of an earlier one, and a sentence for each."""
    copies: set[int] = set()
    said = []
    for index, photograph in enumerate(photographs):
        for earlier in range(index):
            if earlier in copies or not _same_pixels(photographs[earlier], photograph):
                continue
            copies.add(index)
            first, second = photographs[earlier].path.name, photograph.path.name
            times = described(stated[earlier]), described(stated[index])
            claim = f", though {times[0]} and {times[1]} are stated" if times[0] != times[1] else ""
            said.append(f"{second} is the same picture as {first}{claim}; {second} is left out.")
            break
    return copies, said


def _same_pixels(first: Photograph, second: Photograph) -> bool:
    if first.pixels is second.pixels:
        return True
    thin = (slice(None, None, 16), slice(None, None, 16))
    return np.array_equal(first.pixels[thin], second.pixels[thin]) and np.array_equal(
        first.pixels, second.pixels
    )


def _response(
    cells: Cells, check: ExposureCheck, single: Sequence[int]
) -> tuple[ResponseCurve | None, list[str]]:
    """The response under the exposures used, or None and why."""
    logs = np.log([check.exposures[index].relative for index in single])
    own = Cells(cells.values[single], cells.usable[single], cells.roughness, cells.encoded)
    shared = own.usable & (own.usable.sum(0) >= 2)
    assumed = "sRGB's tone curve is assumed."
    if len(single) < 2 or np.ptp(logs) < LEAST_SPREAD_EV * np.log(2.0):
        return None, [f"There are no two exposures to measure the camera's tone curve with: {assumed}"]
    if np.count_nonzero(shared.any(-1).sum(0) >= 2) < LEAST_CELLS:
        return None, [
            f"The exposures share too few well exposed pixels to measure the camera's tone curve: {assumed}"
        ]
    curve = fit_response(own, logs, free=False).curve()
    if max(curve.residual_ev) > WORST_RESIDUAL_EV:
        worst = f"residual {max(curve.residual_ev):.2f} EV"
        return None, [f"No tone curve explains the bracket ({worst}): {assumed} Check the exposures."]
    return curve, []

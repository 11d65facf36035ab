"""From the views' radiance images to one panorama of camera responses: unwrap, divide the ball out (eq. 11), blend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .geometry.frames import panorama_solid_angles
from .geometry.panorama import Unwrapping
from .geometry.registration import PlacedView, ViewRegistration
from .geometry.sphere import fill_unknown, resized
from .geometry.stitch import Blend, view_score
from .model import BoolArray, FloatArray, Job, Progress
from .parallel import in_parallel, row_blocks
from .spectra.chromaticity_noise import without_chromaticity_noise
from .spectra.incidence import IncidenceCorrection


@dataclass(frozen=True)
class ResponsePanorama:
    """What the camera would have seen of the light from every direction, had it looked at the light itself.

    Parameters
    ----------
    responses, variance
        (H, W, C): three channels, and three more for every filter. What no view saw is filled in from around it.
    seen_through
        (C / 3, H, W) bool, where the photographs without filter, and those through each filter, saw the light.
    valid
        (H, W) bool, where a view without filter saw the direction unclipped.
    direction_error_rad
        (H, W) standard error of the direction; pi where nothing was seen.
    clipped_sr
        Solid angle that each view saw clipped in every photograph.
    clipped_everywhere_sr
        That which no view without filter saw otherwise. There the panorama holds the highest lower bound, and is not `valid`.
    """

    responses: FloatArray
    variance: FloatArray
    seen_through: BoolArray
    valid: BoolArray
    direction_error_rad: FloatArray
    clipped_sr: tuple[float, ...]
    clipped_everywhere_sr: float


def compose(
    views: Sequence[PlacedView],
    registration: ViewRegistration,
    doubt: FloatArray,
    corrections: Sequence[IncidenceCorrection],
    width: int,
    composition: str = "blend",
    filters: Sequence[int] | None = None,
) -> Job[ResponsePanorama]:
    """Unwrap view after view, divide the ball's reflectance out of its responses, and blend them into one panorama.

    One view is in memory at a time, and its panorama only some rows at a time: what is needed does not grow with the views.

    Parameters
    ----------
    views
        The views, and `registration` of them.
    doubt
        (V, h, w) how little each is to be believed (`stitch.doubts`).
    corrections
        How the ball is divided out: without filter first, then through each filter.
    width
        Of the panorama in pixels.
    composition
        "blend" or "cut" (`stitch.view_score`).
    filters
        Which of `corrections` each view is of; all are without filter by default.
    """
    height = width // 2
    solid_angles = panorama_solid_angles(height, width)
    used = [0] * len(views) if filters is None else list(filters)
    blends = [Blend(height, width, 3, 3, 1) for _ in corrections]
    seen, valid = np.zeros((2, len(corrections), height, width), bool)
    clipped_sr = []
    for number, (placed, registered) in enumerate(zip(views, registration.views, strict=True)):
        yield Progress(number / len(views), f"View {number + 1} of {len(views)}: unwrapping the ball")
        unwrapping = Unwrapping.of(placed.image, placed.camera, placed.ball, registered.rotation, width)
        error_rad = unwrapping.sampling.resized_error(height, width)
        gain = np.asarray(registered.gain, np.float32)

        def add(
            rows: slice,
            unwrapping: Unwrapping = unwrapping,
            doubt: FloatArray = doubt[number],
            gain: FloatArray = gain,
            error_rad: FloatArray = error_rad,
            pixel_rad: float = placed.pixel_rad,
            through: int = used[number],
        ) -> float:
            view, correction = unwrapping.rows(rows), corrections[through]
            own = correction.light_responses(view.responses * gain, view.cos_incidence)
            variance = correction.light_variance(view.variance * gain**2, view.cos_incidence)
            score = view_score(view, resized(doubt, width, rows), pixel_rad, composition)
            blends[through].add(rows, np.dstack([own, variance, error_rad[rows]]), score)
            seen[through, rows] |= view.seen
            valid[through, rows] |= view.valid
            return float((solid_angles[rows] * (view.seen & ~view.valid)).sum())

        clipped_sr.append(sum(in_parallel(add, row_blocks(width))))
        del unwrapping, error_rad, add  # the last one's, too
    yield Progress(1.0, "Filling what no view saw")
    known = blends[0].known
    responses, variances, errors_rad = [], [], []
    while blends:  # one at a time, and its scores are let go first
        own_known, (response, variance, error_rad) = blends[0].known, blends.pop(0).means()
        response = fill_unknown(response, own_known, in_place=True)
        responses.append(without_chromaticity_noise(response, variance, in_place=True))
        variances.append(variance)
        errors_rad.append(error_rad[..., 0])
    errors_rad[0][~known] = np.pi
    return ResponsePanorama(
        responses=responses[0] if len(responses) == 1 else np.dstack(responses),
        variance=variances[0] if len(variances) == 1 else np.dstack(variances),
        seen_through=valid,
        valid=valid[0],
        direction_error_rad=errors_rad[0],
        clipped_sr=tuple(clipped_sr),
        clipped_everywhere_sr=float((solid_angles * (seen[0] & ~valid[0])).sum()),
    )

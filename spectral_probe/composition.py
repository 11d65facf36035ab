"""From the views' radiance images to one spectral panorama: unwrap, recover (eq. 10), blend."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from .geometry.frames import panorama_solid_angles
from .geometry.panorama import Unwrapping
from .geometry.registration import PlacedView, ViewRegistration
from .geometry.sphere import fill_unknown, resized
from .geometry.stitch import Blend, view_score
from .model import FloatArray, Job, Progress, SpectralPanorama
from .parallel import in_parallel, row_blocks
from .spectra.grid import WAVELENGTHS_NM
from .spectra.recovery import SpectralRecovery


@dataclass(frozen=True)
class Composition:
    """A panorama, and what of it is only known to be brighter than the photographs could record.

    `clipped_sr` (V,) is the solid angle that each view saw clipped in every photograph; `clipped_everywhere_sr` that which no
    view saw otherwise. There the panorama holds the highest lower bound, and is not `valid`.
    """

    panorama: SpectralPanorama
    clipped_sr: tuple[float, ...]
    clipped_everywhere_sr: float


def compose(
    views: Sequence[PlacedView],
    registration: ViewRegistration,
    doubt: FloatArray,
    recovery: SpectralRecovery,
    provenance: Mapping[str, str],
    width: int,
    composition: str = "blend",
) -> Job[Composition]:
    """Unwrap view after view, recover its weights (eq. 10), and blend them into one panorama.

    One view is in memory at a time, and its panorama only some rows at a time: what is needed does not grow with the views.

    Parameters
    ----------
    views
        The views, and `registration` of them.
    doubt
        (V, h, w) how little each is to be believed (`stitch.doubts`).
    recovery
        Responses to weights.
    provenance
        For the file's header.
    width
        Of the panorama in pixels.
    composition
        "blend" or "cut" (`stitch.view_score`).
    """
    height, weights = width // 2, recovery.basis.shape[0]
    solid_angles = panorama_solid_angles(height, width)
    blend = Blend(height, width, weights + 2)
    seen, valid = np.zeros((2, height, width), bool)
    clipped_sr = []
    for number, (placed, registered) in enumerate(zip(views, registration.views, strict=True)):
        yield Progress(number / len(views), f"View {number + 1} of {len(views)}: unwrapping the ball")
        unwrapping = Unwrapping.of(placed.image, placed.camera, placed.ball, registered.rotation, width)
        error_rad = unwrapping.sampling.resized(height, width).direction_error_rad
        own_doubt = resized(doubt[number], width)
        gain = np.asarray(registered.gain, np.float32)

        def add(
            rows: slice,
            unwrapping: Unwrapping = unwrapping,
            doubt: FloatArray = own_doubt,
            gain: FloatArray = gain,
            error_rad: FloatArray = error_rad,
            pixel_rad: float = placed.pixel_rad,
        ) -> float:
            view = unwrapping.rows(rows)
            own = recovery.weights(view.responses * gain, view.cos_incidence)
            confidence = recovery.confidence(own, view.variance * gain**2, view.cos_incidence)
            score = view_score(view, doubt[rows], pixel_rad, composition)
            blend.add(rows, np.dstack([own, confidence, error_rad[rows]]), score)
            seen[rows] |= view.seen
            valid[rows] |= view.valid
            return float((solid_angles[rows] * (view.seen & ~view.valid)).sum())

        clipped_sr.append(sum(in_parallel(add, row_blocks(width))))
    yield Progress(1.0, "Filling what no view saw")
    known, mean = blend.known, blend.mean()
    positive = np.concatenate(
        in_parallel(lambda rows: recovery.non_negative(mean[rows, :, :weights]), row_blocks(width))
    )
    panorama = SpectralPanorama(
        weights=fill_unknown(positive, known),
        bases=recovery.basis[None].copy(),
        basis_index=np.zeros((height, width), np.uint8),
        wavelengths_nm=WAVELENGTHS_NM,
        valid=valid,
        confidence=np.where(valid, mean[..., weights], 0.0).astype(np.float32),
        provenance=provenance,
        direction_error_rad=np.where(known, mean[..., weights + 1], np.pi).astype(np.float32),
    )
    everywhere_sr = float((solid_angles * (seen & ~valid)).sum())
    return Composition(panorama, tuple(clipped_sr), everywhere_sr)

"""From camera responses to the spectra of the light of every direction (eq. 7-10): which recovery where, and how sure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from .composition import ResponsePanorama
from .errors import SpectralDataError
from .geometry.frames import panorama_solid_angles
from .geometry.sphere import resized
from .large import large_array, let_go
from .model import BoolArray, Job, Progress, SpectralPanorama
from .parallel import in_parallel, row_blocks
from .spectra.edits import MOST_BASES
from .spectra.emitters import direct_probability, surface_luminance
from .spectra.grid import WAVELENGTHS_NM
from .spectra.recorded import ENTRY, record
from .spectra.recovery import SpectralRecovery

_KINDS_WIDTH = 256
"""Width of the panorama on which the kinds of light are summed up."""


@dataclass(frozen=True)
class LightOf:
    """The recovery for some directions: `where` (H, W), None for all; `channels` are those of the panorama it takes."""

    recovery: SpectralRecovery
    channels: int = 3
    where: BoolArray | None = None


def recover_light(
    seen: ResponsePanorama, lights: Sequence[LightOf], provenance: Mapping[str, str]
) -> Job[SpectralPanorama]:
    """The spectral panorama of a panorama of camera responses.

    Parameters
    ----------
    seen
        The responses.
    lights
        One recovery for all directions, then those for parts; the last that holds for a direction is used.
    provenance
        For the file's header.

    Raises
    ------
    SpectralDataError
        If there are more bases than the file can number.
    """
    height, width = seen.valid.shape
    first = np.cumsum([0, *(len(light.recovery.bases) for light in lights)])
    if first[-1] > MOST_BASES:
        raise SpectralDataError("There are too many regions with lights of their own. Use fewer.")
    yield Progress(0.0, "Telling lamps from surfaces")
    luminance = seen.responses[..., :3] @ lights[0].recovery.to_luminance
    surface = surface_luminance(luminance)
    used = max(light.recovery.bases.shape[1] for light in lights)
    weights = large_array((height, width, used))
    basis_index = np.zeros((height, width), np.uint8)
    confidence = np.zeros((height, width), np.float32)
    for number, light in enumerate(lights):
        yield Progress((number + 0.5) / (len(lights) + 1), "Recovering the spectra")

        def recover(
            rows: slice, light: LightOf = light, first: int = int(first[number]), number: int = number
        ) -> None:
            where = np.ones_like(seen.valid[rows]) if light.where is None else light.where[rows]
            if where.any():
                found = light.recovery.recover(
                    seen.responses[rows][where][:, : light.channels],
                    seen.variance[rows][where][:, : light.channels],
                    direct_probability(luminance[rows][where], surface),
                )
                if number:
                    weights[rows][where] = 0
                weights[rows][where, : found.weights.shape[-1]] = found.weights
                let_go(weights)
                basis_index[rows][where] = found.basis_index + first
                confidence[rows][where] = np.where(seen.valid[rows][where], found.confidence, 0)

        in_parallel(recover, row_blocks(width))
    bases = np.zeros((first[-1], used, len(WAVELENGTHS_NM)))
    for number, light in enumerate(lights):
        bases[first[number] : first[number + 1], : light.recovery.bases.shape[1]] = light.recovery.bases
    return SpectralPanorama(
        weights=weights,
        bases=bases,
        basis_index=basis_index,
        wavelengths_nm=WAVELENGTHS_NM,
        valid=seen.valid,
        confidence=confidence,
        provenance=provenance,
        direction_error_rad=seen.direction_error_rad,
        further={
            ENTRY: record(
                [(int(start), light.recovery) for start, light in zip(first, lights, strict=False)], surface
            )
        },
    )


def kinds_of_light(seen: ResponsePanorama, recovery: SpectralRecovery) -> dict[str, float]:
    """Share of each kind of light, by name, in the light of all directions (its luminance), as the unfiltered photographs say."""
    small = resized(seen.responses[..., :3], _KINDS_WIDTH)
    luminance = small @ recovery.to_luminance
    light = np.maximum(luminance, 0) * panorama_solid_angles(*luminance.shape)
    likely = recovery.probabilities(small, direct_probability(luminance, surface_luminance(luminance)))
    shares = np.einsum("hw,hwn->n", light, likely) / max(float(light.sum()), 1e-30)
    return {
        estimate.name: round(float(share), 4)
        for estimate, share in zip(recovery.estimates, shares, strict=True)
    }

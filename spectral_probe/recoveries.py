"""Which recovery for which directions: as many filters as saw them, and regions whose light is known better than the rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .composition import ResponsePanorama
from .files.spectrum_csv import read_spectrum_csv
from .light import LightOf
from .light_settings import Region, RegionLight
from .model import BoolArray, Capture, FloatArray, SpectralPanorama
from .spectra.curves import LIGHT
from .spectra.grid import STEP_NM, WAVELENGTHS_NM
from .spectra.measured_light import measured_light_recovery
from .spectra.recovery import SpectralRecovery, spectral_recovery
from .spectra.regions import check_region, region_mask


@dataclass(frozen=True)
class Recoveries:
    """The recoveries of a capture: of the whole sphere, and of its regions.

    Each is a sequence by the number of filters used: the first takes the three channels without a filter, the next
    six, and so on.
    """

    everywhere: tuple[SpectralRecovery, ...]
    regions: tuple[tuple[Region, tuple[SpectralRecovery, ...]], ...] = ()

    @property
    def whole(self) -> SpectralRecovery:
        """The one of all channels."""
        return self.everywhere[-1]

    def lights(self, seen: ResponsePanorama) -> list[LightOf]:
        """What to recover where: each direction by all the filters through which it was seen, regions after the rest.

        Raises
        ------
        SpectralProbeError
            If a region selects nothing, or cannot be read.
        """
        lights = _by_filters(self.everywhere, seen, None)
        if self.regions:
            light = _seen_light(seen, self.everywhere[0])
            for region, recoveries in self.regions:
                lights += _by_filters(recoveries, seen, region_mask(region, light))
        return lights


def recoveries_of(capture: Capture, sensitivities: FloatArray) -> Recoveries:
    """Prepare the recoveries of a capture.

    Parameters
    ----------
    capture
        Its method, lamp families, own lights and regions.
    sensitivities
        (61, 3 G) of the camera without a filter, then through each (`filters.FilterSets.sensitivities`).

    Raises
    ------
    SpectralProbeError
        If a name or a file cannot be used.
    """
    own = np.stack([_light(path) for path in capture.spectra]) if capture.spectra else None

    def by_filters(families: Sequence[str], method: str) -> tuple[SpectralRecovery, ...]:
        return tuple(spectral_recovery(part, families, method, own) for part in _growing(sensitivities))

    def of_region(light: RegionLight) -> tuple[SpectralRecovery, ...]:
        if light.spectrum is not None:
            spectrum = _light(light.spectrum)
            return tuple(measured_light_recovery(part, spectrum) for part in _growing(sensitivities))
        method = "family" if capture.method == "automatic" else capture.method
        return by_filters(light.families or capture.families, method)

    for number, light in enumerate(capture.regions, start=1):
        light.check(f"[[region]] {number}")
        check_region(light.region)
    return Recoveries(
        by_filters(capture.families, capture.method),
        tuple((light.region, of_region(light)) for light in capture.regions),
    )


def _growing(sensitivities: FloatArray) -> list[FloatArray]:
    """The first three channels, the first six, and so on."""
    return [sensitivities[:, :count] for count in range(3, sensitivities.shape[1] + 1, 3)]


def _light(path: Path) -> FloatArray:
    """A measured light, of unit norm."""
    spectrum = read_spectrum_csv(path, quantity=LIGHT)[0]
    return np.asarray(spectrum / np.linalg.norm(spectrum))


def _by_filters(
    recoveries: Sequence[SpectralRecovery], seen: ResponsePanorama, where: BoolArray | None
) -> list[LightOf]:
    """Each recovery where its photographs, and not those of the next, saw the light; the first where no filter's did."""
    if len(recoveries) == 1:
        return [LightOf(recoveries[0], 3, where)]
    everywhere = np.ones_like(seen.valid) if where is None else where
    through = [seen.seen_through[: count + 1].all(axis=0) for count in range(1, len(recoveries))]
    levels = [everywhere, *(everywhere & one for one in through), np.zeros_like(seen.valid)]
    return [
        LightOf(recovery, 3 * count, own & ~further)
        for count, (recovery, own, further) in enumerate(
            zip(recoveries, levels[:-1], levels[1:], strict=True), start=1
        )
    ]


def _seen_light(seen: ResponsePanorama, recovery: SpectralRecovery) -> SpectralPanorama:
    """The panorama as bright as the three channels say, which is what regions grow over; its spectra mean nothing else."""
    height, width = seen.valid.shape
    spectra = np.linalg.pinv(recovery.sensitivities * STEP_NM)
    return SpectralPanorama(
        weights=seen.responses[..., :3],
        bases=spectra[None],
        basis_index=np.zeros((height, width), np.uint8),
        wavelengths_nm=WAVELENGTHS_NM,
        valid=seen.valid,
        confidence=seen.valid.astype(np.float32),
        direction_error_rad=seen.direction_error_rad,
    )

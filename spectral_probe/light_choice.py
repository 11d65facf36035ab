"""A light as people name it: a lamp of the library, a file with its spectrum, or what a probe saw."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .errors import SpectralDataError
from .files.json_object import UNREADABLE, read_object
from .files.panorama_file import read_panorama
from .files.region_json import read_region
from .model import BoolArray, FloatArray, SpectralPanorama
from .spectra.edits import lamp_spectrum
from .spectra.grid import WAVELENGTHS_NM, resample
from .spectra.regions import mean_spectrum, region_mask
from .spectrum_command import spectrum_at

REPORT_NAME = "report.json"
"""In a render's folder: among other things its `mean_light` (`mean_light`)."""


@dataclass(frozen=True)
class NamedLight:
    """A light's name, and its spectrum (61,) in a unit of its own."""

    name: str
    spectrum: FloatArray


def chosen_light(
    light: str, at: tuple[float, float] | None = None, region_path: Path | None = None
) -> NamedLight:
    """The light that a word, and for a probe a direction or a region, name.

    Parameters
    ----------
    light
        A lamp of the library ("D65", "FL11", "Planck 3200 K"), a file with a spectrum, or a probe (.exr): its mean over all
        directions that were seen.
    at
        Compass bearing and elevation in degrees: of a probe, the light from there.
    region_path
        A region file: of a probe, the mean light of the region.

    Raises
    ------
    SpectralDataError
        If there is no such light, or a direction is asked of what has none.
    FileFormatError
        If a file cannot be read, or nothing was seen there.

    Examples
    --------
    >>> chosen_light("Planck 2856 K").name
    'Planck 2856 K'
    """
    path = Path(light).expanduser()
    if at is not None and region_path is not None:
        raise SpectralDataError("Give either a direction or a region of the probe, not both.")
    if path.suffix.lower() == ".exr":
        return _of_probe(path, at, region_path)
    if at is not None or region_path is not None:
        raise SpectralDataError(
            f'"{light}" has no directions. Give a probe (probe.exr) as the light, or no direction and no region.'
        )
    return NamedLight(path.name if path.is_file() else light, lamp_spectrum(light))


def _of_probe(path: Path, at: tuple[float, float] | None, region_path: Path | None) -> NamedLight:
    panorama = read_panorama(path)
    if at is not None:
        found = spectrum_at(panorama, *at, radius_deg=0.5)
        name = f"light from {at[0]:g}°, {at[1]:g}°".replace("-", "\N{MINUS SIGN}")
        return NamedLight(name, resample(found.wavelengths_nm, found.spectrum))
    if region_path is not None:
        chosen = region_mask(read_region(region_path), panorama) & panorama.valid
        if not chosen.any():
            raise SpectralDataError(f"No view saw any of the region {region_path.name}. Choose another.")
        return NamedLight(f"light of the region {region_path.stem}", _on_grid(panorama, chosen))
    return NamedLight(f"mean light of {path.name}", mean_light(panorama))


def mean_light(panorama: SpectralPanorama) -> FloatArray:
    """Mean spectrum (61,) over all directions that a panorama has seen, by solid angle."""
    return _on_grid(panorama, panorama.valid)


def light_of_render(directory: Path) -> NamedLight | None:
    """The mean light that lit a render, as the report.json in its folder has it; None where there is none of it."""
    try:
        report = read_object(directory / REPORT_NAME)
        spectrum = np.asarray(report["mean_light"], float)
    except UNREADABLE:  # images may lie in any folder, beside any report.json
        return None
    seen = spectrum.shape == WAVELENGTHS_NM.shape and np.isfinite(spectrum).all() and spectrum.sum() > 0
    return NamedLight("the render's mean light", spectrum) if seen else None


def _on_grid(panorama: SpectralPanorama, chosen: BoolArray) -> FloatArray:
    return resample(panorama.wavelengths_nm, mean_spectrum(panorama, chosen), name="the probe")

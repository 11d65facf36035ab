"""The verb `spectrum`: the light from one direction or region of a probe, as numbers, CSV and plots."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from .errors import FileFormatError
from .files.atomic import check_folder, written_whole
from .files.panorama_file import read_panorama
from .files.region_json import read_region
from .files.spectrum_csv import read_spectrum_csv
from .geometry.frames import (
    bearing_to_direction,
    equirectangular_to_direction,
    panorama_solid_angles,
)
from .model import BoolArray, FloatArray, Job, Progress, SpectralPanorama, Texels
from .spectra.confidence import error_of_confidence
from .spectra.curves import LIGHT
from .spectra.edits import edited_confidence, recovered_index
from .spectra.grid import WAVELENGTHS_NM, resample
from .spectra.metrics import SpectrumComparison, compare_spectra, light_numbers, scaled_to_energy
from .spectra.posterior import Posterior, metamer_risk
from .spectra.recorded import light_posterior
from .spectra.regions import mean_spectrum, region_mask, texels_of

type Numbers = dict[str, Any]

_STANDARD_ERRORS_95 = 1.959964  # of a normal distribution, to both sides
_SUFFIXES = (".png", ".svg")


@dataclass(frozen=True)
class DirectionSpectrum:
    """The spectrum from one direction, or the mean over a region.

    Parameters
    ----------
    wavelengths_nm
        (L,).
    spectrum
        (L,) spectral radiance per nm.
    error
        (L,) its standard error.
    confidence
        Mean confidence, 0..1.
    direction_error_deg
        Standard error of the direction; None where the probe does not tell.
    solid_angle_sr
        Solid angle of the texels averaged over.
    basis
        (K, L) basis functions that most of these texels use.
    families
        Probability of every lamp family, where the recovery gives one.
    metamer_risk_de2000
        Colour difference that surfaces may show under the true light, where the recovery gives one.
    residual
        Share of the camera's responses that the spectrum does not explain, where the recovery gives one.
    """

    wavelengths_nm: FloatArray
    spectrum: FloatArray
    error: FloatArray
    confidence: float
    direction_error_deg: float | None = None
    solid_angle_sr: float | None = None
    basis: FloatArray | None = None
    families: Mapping[str, float] | None = None
    metamer_risk_de2000: float | None = None
    residual: float | None = None

    @property
    def band_95(self) -> FloatArray:
        """Lower and upper bound of the 95 % band, (2, L). No light is negative: nor is the lower bound, unless the estimate is.

        Examples
        --------
        >>> found = DirectionSpectrum(np.array([400.0, 700.0]), np.array([1.0, 3.0]), np.array([1.0, 1.0]), 0.5)
        >>> found.band_95.round(2).tolist()
        [[0.0, 1.04], [2.96, 4.96]]
        """
        reach = _STANDARD_ERRORS_95 * self.error
        lower = np.maximum(self.spectrum - reach, np.minimum(self.spectrum, 0.0))
        return np.stack([lower, self.spectrum + reach])


def spectrum_at(
    panorama: SpectralPanorama, azimuth_deg: float, elevation_deg: float, radius_deg: float
) -> DirectionSpectrum:
    """Mean spectrum of a panorama within a small angle of a bearing.

    Parameters
    ----------
    panorama
        The panorama.
    azimuth_deg, elevation_deg
        Compass bearing (0 = +Y, clockwise from above) and elevation.
    radius_deg
        Radius of the disc averaged over; the nearest pixel always belongs to it.

    Raises
    ------
    FileFormatError
        If no view saw that direction unclipped.
    """
    height, width = panorama.valid.shape
    rows, columns = disc_texels(height, width, azimuth_deg, elevation_deg, radius_deg)
    seen = panorama.valid[rows, columns]
    if not seen.any():
        raise FileFormatError(
            f"No view saw the direction {azimuth_deg:g},{elevation_deg:g} unclipped. Choose another, or photograph it "
            "from another side or with a shorter exposure."
        )
    return _texels_spectrum(panorama, (rows[seen], columns[seen]))


def disc_texels(
    height: int, width: int, azimuth_deg: float, elevation_deg: float, radius_deg: float
) -> Texels:
    """Texels whose centres lie within a small angle of a bearing; the nearest always belongs to them.

    Only rows that can reach so near are looked at.

    Examples
    --------
    >>> [places.tolist() for places in disc_texels(4, 8, 80.0, 20.0, 0.1)]  # +X is in the middle
    [[1], [3]]
    """
    elevations_deg = 90.0 - (np.arange(height) + 0.5) * 180.0 / height
    near = np.flatnonzero(np.abs(elevations_deg - elevation_deg) <= radius_deg + 180.0 / height)
    columns, rows = np.meshgrid(np.arange(width) + 0.5, near + 0.5)
    directions = equirectangular_to_direction(np.stack([columns, rows], axis=-1), height, width)
    closeness = directions @ bearing_to_direction(azimuth_deg, elevation_deg)
    found, columns_found = np.nonzero(closeness >= min(np.cos(np.radians(radius_deg)), closeness.max()))
    return near[found], columns_found


def region_spectrum(panorama: SpectralPanorama, chosen: BoolArray) -> DirectionSpectrum:
    """Mean spectrum over the texels of a mask (H, W) that a view saw, weighted by their solid angles.

    Raises
    ------
    FileFormatError
        If no view saw any of them unclipped.
    """
    texels = texels_of(chosen & panorama.valid)
    if not len(texels[0]):
        raise FileFormatError("No view saw any of the region unclipped. Choose another.")
    return _texels_spectrum(panorama, texels)


def _texels_spectrum(panorama: SpectralPanorama, chosen: Texels) -> DirectionSpectrum:
    """The mean spectrum of texels that were all seen: as quick as they are few, however large the panorama."""
    solid_angles = panorama_solid_angles(*panorama.valid.shape)[chosen[0], 0]
    shares = solid_angles / solid_angles.sum()
    spectrum = mean_spectrum(panorama, chosen)
    confidence = float(shares @ edited_confidence(panorama, chosen))
    known = light_posterior(panorama, chosen)
    error = _standard_error(panorama, chosen, spectrum, confidence, known)
    direction_error = None
    if panorama.direction_error_rad is not None:
        direction_error = float(np.degrees(shares @ panorama.direction_error_rad[chosen]))
    usual = np.bincount(panorama.basis_index[chosen], weights=shares).argmax()
    basis = panorama.bases[usual]
    return DirectionSpectrum(
        panorama.wavelengths_nm,
        spectrum,
        error,
        confidence,
        direction_error,
        float(solid_angles.sum()),
        basis[np.abs(basis).max(-1) > 0],
        None if known is None else known.kinds,
        None if known is None else metamer_risk(known.mean, known.covariance),
        None if known is None else known.residual,
    )


def _standard_error(
    panorama: SpectralPanorama,
    chosen: Texels,
    spectrum: FloatArray,
    confidence: float,
    known: Posterior | None,
) -> FloatArray:
    """Of the mean spectrum (L,); the same at every wavelength where the probe tells no more than a confidence."""
    nm = panorama.wavelengths_nm
    if known is None:
        error = error_of_confidence(confidence) * np.linalg.norm(spectrum) / np.sqrt(len(nm))
        return np.full(len(nm), error)
    if not panorama.edits:
        return np.asarray(np.interp(nm, WAVELENGTHS_NM, known.standard_error))
    own = replace(panorama, basis_index=recovered_index(panorama))  # a glass multiplies light and error alike
    before = mean_spectrum(own, chosen)
    edited = np.where(before > 0, spectrum / np.where(before > 0, before, 1.0), 1.0)
    return np.asarray(edited * np.interp(nm, WAVELENGTHS_NM, known.standard_error))


def spectrum(
    probe_path: Path,
    at: tuple[float, float] | None,
    measured_path: Path | None,
    directory: Path | None,
    radius_deg: float = 0.5,
    *,
    region_path: Path | None = None,
    basis: bool = False,
) -> Job[Numbers]:
    """The spectrum of a direction or a region as CSV, PNG and SVG, and its numbers, also against a measured spectrum.

    Parameters
    ----------
    probe_path
        probe.exr, or a spectral panorama of another program.
    at
        Compass bearing and elevation in degrees, or None where a region is given.
    measured_path
        A file with a measured spectrum, or None.
    directory
        Folder to write to; None: that of the probe.
    radius_deg
        Radius of the disc about `at`.
    region_path
        A region file (JSON) in place of `at`.
    basis
        Draw the basis functions of that direction too.

    Raises
    ------
    FileFormatError
        If a file cannot be used or nothing was seen there, or neither or both of `at` and `region_path` are given.
    """
    measured = None if measured_path is None else read_spectrum_csv(measured_path, quantity=LIGHT)[0]
    yield Progress(0.1, "Reading the probe")
    panorama = read_panorama(probe_path)
    directory = probe_path.parent if directory is None else directory
    check_folder(directory)
    if at is not None and region_path is None:
        found = spectrum_at(panorama, *at, radius_deg)
        name = f"{at[0]:g}_{at[1]:g}"
        title = f"Light from {at[0]:g}°, elevation {at[1]:g}°".replace("-", "\N{MINUS SIGN}")
        where: Numbers = {"azimuth_deg": at[0], "elevation_deg": at[1]}
    elif region_path is not None and at is None:
        found = region_spectrum(panorama, region_mask(read_region(region_path), panorama))
        name, title = region_path.stem, f"Light of the region {region_path.stem}"
        where = {"region": str(region_path), "solid_angle_sr": found.solid_angle_sr}
    else:
        raise FileFormatError("Give either a direction or a region.")
    stem = directory / f"spectrum_{name}"
    yield Progress(0.4, "Computing its numbers")
    numbers = where | numbers_of(found, measured)
    yield Progress(0.6, "Drawing the spectrum")
    numbers |= write_spectrum(stem, found, measured, title)
    if basis and found.basis is not None:
        numbers["basis_plot"] = write_basis(
            stem.with_name(f"{stem.name}_basis"), found.wavelengths_nm, found.basis
        )
    return numbers


def numbers_of(found: DirectionSpectrum, measured: FloatArray | None = None) -> Numbers:
    """The numbers of a spectrum, and how well it fits a measured one (61,) on `WAVELENGTHS_NM`; flat, ready for JSON."""
    estimated = resample(found.wavelengths_nm, found.spectrum)
    light = light_numbers(estimated)
    numbers: Numbers = {
        "confidence": found.confidence,
        "direction_error_deg": found.direction_error_deg,
        **_listed(asdict(light)),
        **_further(found),
    }
    if measured is not None:
        numbers |= _fit(compare_spectra(estimated, measured))
    return numbers


def _further(found: DirectionSpectrum) -> Numbers:
    """What the recovery gives beyond the spectrum, where it does."""
    given: Numbers = {
        "families": None if found.families is None else dict(found.families),
        "metamer_risk_de2000": found.metamer_risk_de2000,
        "residual": found.residual,
    }
    return {name: value for name, value in given.items() if value is not None}


def _fit(compared: SpectrumComparison) -> Numbers:
    colorchecker = compared.de2000_colorchecker or (None, None)
    metals = compared.de2000_metals or (None, None)
    return {
        "gfc": compared.gfc,
        "relative_rmse": compared.relative_rmse,
        "delta_cct_kelvin": compared.delta_cct_kelvin,
        "de2000_light": compared.de2000_light,
        "de2000_colorchecker_mean": colorchecker[0],
        "de2000_colorchecker_max": colorchecker[1],
        "de2000_metals_mean": metals[0],
        "de2000_metals_max": metals[1],
        "measured": _listed(asdict(compared.measured)),
    }


def _listed(numbers: Numbers) -> Numbers:
    return {name: list(value) if isinstance(value, tuple) else value for name, value in numbers.items()}


def write_spectrum(stem: Path, found: DirectionSpectrum, measured: FloatArray | None, title: str) -> Numbers:
    """Write STEM.csv, STEM.png and STEM.svg of a spectrum, beside a measured one (61,); returns where they are."""
    from .figures.numbers import comparison_lines
    from .figures.spectrum import spectrum_figure

    table = {
        "wavelength_nm": found.wavelengths_nm,
        "radiance": found.spectrum,
        "standard_error": found.error,
        "lower_95": found.band_95[0],
        "upper_95": found.band_95[1],
    }
    nm, estimated, band = found.wavelengths_nm, found.spectrum, found.band_95
    if measured is not None:  # on its wavelengths alone, or the energies would not be those of one range
        table["measured"] = _measured_column(found, measured)
        nm, estimated, band = WAVELENGTHS_NM, resample(nm, estimated), resample(nm, band)
    csv_path = stem.with_name(f"{stem.name}.csv")
    _write_csv(csv_path, table)
    *lines, last = comparison_lines(nm, estimated, measured)
    figure = spectrum_figure(
        nm,
        estimated,
        measured,
        band,
        band_label="95 % band",
        title=title,
        numbers=[*lines, last | _sure(found)],
        families=found.families,
    )
    plot = _save(figure, stem)
    return {"csv": str(csv_path), "plot": plot}


def _sure(found: DirectionSpectrum) -> dict[str, str]:
    """How sure the spectrum is, for the plot's heading."""
    lines = {"confidence": f"{found.confidence:.3f}"}
    if found.metamer_risk_de2000 is not None:
        lines["metamer risk ΔE₀₀"] = f"{found.metamer_risk_de2000:.1f}"
    if found.residual is not None:
        lines["residual"] = f"{100 * found.residual:.2g} %"
    return lines


def _measured_column(found: DirectionSpectrum, measured: FloatArray) -> FloatArray:
    """The measured spectrum at the wavelengths of the estimate, scaled to its energy; not a number where it is not known."""
    scaled = scaled_to_energy(measured, resample(found.wavelengths_nm, found.spectrum))
    return np.interp(found.wavelengths_nm, WAVELENGTHS_NM, scaled, left=np.nan, right=np.nan)


def write_basis(stem: Path, wavelengths_nm: FloatArray, basis: FloatArray) -> str:
    """Write STEM.csv, STEM.png and STEM.svg of basis functions (K, L) (fig. 7 of the paper); returns the PNG's path."""
    from .figures.curves import basis_figure

    columns = {f"E{number}": curve for number, curve in enumerate(basis, start=1)}
    _write_csv(stem.with_name(f"{stem.name}.csv"), {"wavelength_nm": wavelengths_nm, **columns})
    return _save(basis_figure(wavelengths_nm, basis), stem)


def write_sensitivities(stem: Path, sensitivities: FloatArray, title: str, shots: Sequence[str] = ()) -> str:
    """Write STEM.csv, STEM.png and STEM.svg of a camera's sensitivities (fig. 2 of the paper); returns the PNG's path.

    `sensitivities` is (61, 3), or (61, 6) or (61, 9) with those through filters after them; `shots` says what each three
    were taken through, as in `sensitivities_figure`.
    """
    from .figures.curves import sensitivities_figure

    figure = sensitivities_figure(WAVELENGTHS_NM, sensitivities, shots=shots, title=title)
    suffixes = ["", *(f"_{number}" for number in range(2, sensitivities.shape[1] // 3 + 1))]
    names = [letter + suffix for suffix in suffixes for letter in "rgb"]
    columns = dict(zip(names, sensitivities.T, strict=True))
    _write_csv(stem.with_name(f"{stem.name}.csv"), {"wavelength_nm": WAVELENGTHS_NM, **columns})
    return _save(figure, stem)


def _save(figure: Any, stem: Path) -> str:
    from .figures.style import save_figure

    for suffix in _SUFFIXES:
        save_figure(figure, stem.with_name(stem.name + suffix))
    return str(stem.with_name(f"{stem.name}.png"))


def _write_csv(path: Path, columns: Mapping[str, FloatArray]) -> None:
    """Columns (N,) by name; what is not a number stays empty."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    for row in zip(*columns.values(), strict=True):
        writer.writerow(f"{value:.7g}" if np.isfinite(value) else "" for value in row)
    with written_whole(path) as temporary:
        temporary.write_text(text.getvalue(), encoding="utf-8")

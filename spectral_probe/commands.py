"""What the verbs of the command line do that need no Blender: calibrate, probe, spectrum, compare.

Each is a job: it yields progress, writes its files, and returns the numbers worth telling.
"""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .errors import FileFormatError, SpectralProbeError
from .files.atomic import written_whole
from .files.capture import load_capture
from .files.image_exr import read_channels
from .files.probe_exr import read_probe
from .files.spectral_exr import read_spectral
from .files.spectrum_csv import read_spectrum_csv
from .geometry.boards import Board
from .geometry.calibration import calibrate as calibrate_camera
from .geometry.calibration import write_calibration
from .geometry.frames import bearing_to_direction, panorama_directions, panorama_solid_angles
from .model import FloatArray, Job, Progress, SpectralPanorama, part
from .probe import build_probe, write_outputs
from .render.compare import Comparison, compare_images, comparison_report, write_comparison
from .spectra.colorimetry import chromaticity, rec709_to_xyz, spectra_to_xyz
from .spectra.edits import edited_confidence
from .spectra.grid import resample
from .spectra.metrics import colour_temperature, goodness_of_fit, relative_rmse, scaled_to_energy
from .spectra.recovery import error_of_confidence
from .spectra.regions import mean_spectrum

type Numbers = dict[str, Any]


def probe(capture_path: Path, directory: Path, width: int | None) -> Job[Numbers]:
    """Photographs to probe.exr, spectral.exr, layers.exr, world.exr, report.json and preview.png in a folder."""
    capture = load_capture(capture_path)
    check_folder(directory)
    building = build_probe(capture, width)
    result = yield from part(building, 0.0, 0.7)
    yield from part(write_outputs(result, directory), 0.7, 1.0)
    return {**result.report, "written": str(directory)}


def calibrate(photos: Sequence[Path], output: Path, board: Board) -> Job[Numbers]:
    """Photographs of a board to camera.json: focal length, principal point and distortion, with their errors."""
    if output.is_dir():
        raise FileFormatError(f"{output} is a folder. Give the name of a file to write, such as camera.json.")
    if any(output.resolve() == photo.resolve() for photo in photos):
        raise FileFormatError(f"{output.name} is one of the photographs. Give another file to write.")
    check_folder(output.parent)
    calibration = yield from part(calibrate_camera(photos, board), 0.0, 0.99)
    return {**write_calibration(output, calibration), "written": str(output)}


def check_folder(directory: Path) -> None:
    """Refuse, before any work and without making anything, a folder that cannot be written to.

    Raises
    ------
    FileFormatError
        If the path, or what it lies in, is a file or may not be written to.
    """
    nearest = next(path for path in (directory, *directory.resolve().parents) if path.exists())
    if not nearest.is_dir():
        raise FileFormatError(f"{nearest} is a file, not a folder. Choose another folder to write to.")
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise FileFormatError(f"The folder {nearest} may not be written to. Choose another.")


@dataclass(frozen=True)
class DirectionSpectrum:
    """The spectrum from one direction: `spectrum` and its standard error, (L,), and the mean confidence.

    `direction_error_deg` is the standard error of the direction, None where the probe does not tell.
    """

    wavelengths_nm: FloatArray
    spectrum: FloatArray
    error: FloatArray
    confidence: float
    direction_error_deg: float | None = None


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
    closeness = panorama_directions(height, width) @ bearing_to_direction(azimuth_deg, elevation_deg)
    disc = closeness >= min(np.cos(np.radians(radius_deg)), closeness.max())
    chosen = disc & panorama.valid
    if not chosen.any():
        raise FileFormatError(
            f"No view saw the direction {azimuth_deg:g},{elevation_deg:g} unclipped. Choose another, or photograph it "
            "from another side or with a shorter exposure."
        )
    solid_angles = np.broadcast_to(panorama_solid_angles(height, width), (height, width))[chosen]
    shares = solid_angles / solid_angles.sum()
    spectrum = mean_spectrum(panorama, chosen)
    confidence = float(shares @ edited_confidence(panorama)[chosen])
    error = error_of_confidence(confidence) * np.linalg.norm(spectrum) / np.sqrt(len(spectrum))
    direction_error = None
    if panorama.direction_error_rad is not None:
        direction_error = float(np.degrees(shares @ panorama.direction_error_rad[chosen]))
    return DirectionSpectrum(
        panorama.wavelengths_nm, spectrum, np.full_like(spectrum, error), confidence, direction_error
    )


def spectrum(
    probe_path: Path,
    at: tuple[float, float],
    measured_path: Path | None,
    directory: Path | None,
    radius_deg: float,
) -> Job[Numbers]:
    """One direction's spectrum as CSV, PNG and SVG; against a measured one with GFC and relative RMSE."""
    measured = None if measured_path is None else read_spectrum_csv(measured_path)[0]
    yield Progress(0.1, "Reading the probe")
    found = spectrum_at(read_probe(probe_path), *at, radius_deg)
    directory = probe_path.parent if directory is None else directory
    check_folder(directory)
    stem = directory / f"spectrum_{at[0]:g}_{at[1]:g}"
    estimated = resample(found.wavelengths_nm, found.spectrum)
    xyz = spectra_to_xyz(estimated)
    temperature = colour_temperature(estimated)
    numbers: Numbers = {
        "azimuth_deg": at[0],
        "elevation_deg": at[1],
        "confidence": found.confidence,
        "direction_error_deg": found.direction_error_deg,
        "xy": chromaticity(xyz).tolist(),
        "cct_kelvin": None if temperature is None else temperature[0],
        "duv": None if temperature is None else temperature[1],
        "csv": str(stem.with_name(stem.name + ".csv")),
        "plot": str(stem.with_name(stem.name + ".png")),
    }
    if measured is not None:
        numbers["gfc"] = float(goodness_of_fit(estimated, measured))
        numbers["relative_rmse"] = float(relative_rmse(estimated, measured))
    yield Progress(0.5, "Drawing the spectrum")
    _write_spectrum_csv(Path(numbers["csv"]), found, measured, estimated)
    from .figures.spectrum import spectrum_figure
    from .figures.style import save_figure

    figure = spectrum_figure(
        found.wavelengths_nm,
        found.spectrum,
        measured,
        np.stack([found.spectrum - found.error, found.spectrum + found.error]),
        band_label="± 1 standard error",
        title=f"Light from {at[0]:g}°, elevation {at[1]:g}°",
    )
    for suffix in (".png", ".svg"):
        save_figure(figure, stem.with_name(stem.name + suffix))
    return numbers


def _write_spectrum_csv(
    path: Path, found: DirectionSpectrum, measured: FloatArray | None, estimated: FloatArray
) -> None:
    """Columns wavelength_nm, radiance, standard_error and, scaled to the estimate's energy, measured."""
    columns = {
        "wavelength_nm": found.wavelengths_nm,
        "radiance": found.spectrum,
        "standard_error": found.error,
    }
    if measured is not None:
        columns["measured"] = scaled_to_energy(measured, estimated)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([f"{value:.7g}" for value in row] for row in zip(*columns.values(), strict=True))
    with written_whole(path) as temporary:
        temporary.write_text(text.getvalue(), encoding="utf-8")


def compare(spectral_path: Path, rgb_path: Path, directory: Path, blur_px: float) -> Job[Numbers]:
    """Two renders of one scene: sheet, dE2000 map, xy diagram, numbers in compare.json."""
    yield Progress(0.05, "Reading the renders")
    spectral, rgb = read_xyz(spectral_path), read_xyz(rgb_path)
    if spectral.shape != rgb.shape:
        raise FileFormatError(
            f"{spectral_path.name} is {spectral.shape[1]} x {spectral.shape[0]} pixels, {rgb_path.name} is "
            f"{rgb.shape[1]} x {rgb.shape[0]}. Compare renders of one size."
        )
    check_folder(directory)
    yield Progress(0.2, "Computing colour differences")
    comparison = compare_images(spectral, rgb, blur_px=blur_px)
    write_comparison(directory / "compare.json", comparison)
    yield Progress(0.5, "Drawing the sheet")
    draw_comparison(directory, comparison, spectral, rgb)
    return {**comparison_report(comparison), "written": str(directory)}


def draw_comparison(directory: Path, comparison: Comparison, spectral: FloatArray, rgb: FloatArray) -> None:
    """Draw sheet, dE2000 map and xy diagram into a folder, as PNG and SVG."""
    from .figures.chromaticity import chromaticity_figure, shifts_of
    from .figures.difference import delta_e_figure
    from .figures.sheet import SheetContent, comparison_sheet
    from .figures.style import save_figure

    figures = {
        "sheet": comparison_sheet(SheetContent(comparison, spectral, rgb)),
        "delta_e": delta_e_figure(comparison),
        "chromaticity": chromaticity_figure(shifts_of(comparison)),
    }
    for name, figure in figures.items():
        for suffix in (".png", ".svg"):
            save_figure(figure, directory / f"{name}{suffix}")


def read_xyz(path: Path) -> FloatArray:
    """Tristimulus values (H, W, 3) of an image: from X, Y, Z, from linear Rec.709 R, G, B, or from a spectral image."""
    channels, _ = read_channels(path)
    for names, to_xyz in (("XYZ", None), ("RGB", rec709_to_xyz)):
        if all(name in channels for name in names):
            image = np.stack([np.asarray(channels[name], np.float32) for name in names], axis=-1)
            return image if to_xyz is None else to_xyz(image)
    try:
        spectra, wavelengths_nm = read_spectral(path)
    except SpectralProbeError:
        raise FileFormatError(
            f"{path.name} holds neither X, Y, Z nor R, G, B nor a spectrum. Give xyz.exr, image.exr or rgb.exr of a render."
        ) from None
    return spectra_to_xyz(resample(wavelengths_nm, spectra, name=path.name))

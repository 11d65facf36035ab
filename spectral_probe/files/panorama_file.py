"""Spectral panoramas of any kind: our own probe.exr, or a spectral image in equirectangular projection."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..errors import FileFormatError
from ..model import FloatArray, SpectralPanorama
from ..spectra.grid import WAVELENGTHS_NM, resampling_matrix
from .image_exr import read_channels
from .probe_exr import read_probe
from .spectral_channels import is_spectral
from .spectral_exr import SpectralImage, spectral_image

MOST_BASIS_FUNCTIONS = 12
"""A foreign panorama is put into so few spectra; what they do not hold stands in the provenance as `residual`."""

_CHUNK = 65536  # rows at a time in double precision
_NEGLIGIBLE = 1e-7  # share of the energy: that of 16-bit pixels' rounding


def read_panorama(path: Path) -> SpectralPanorama:
    """Read a probe, or a spectral panorama of another program (the layout of Fichet et al., or Indigo's channels).

    Of a foreign panorama, 400-700 nm are used, and its directions are taken to be as in Blender's equirectangular
    projection. It is certain of itself: its confidence is 1.

    Raises
    ------
    FileFormatError
        If the file is neither, or is not twice as wide as high.
    SpectralDataError
        If it does not cover 400-700 nm.
    """
    channels, header = read_channels(path)
    if "eps.0" in channels or not any(is_spectral(name) for name in channels):
        return read_probe(path)  # or its sentence on what the file is not
    return panorama_from_image(spectral_image(channels, header, Path(path).name, "emissive"), Path(path).name)


def panorama_from_image(image: SpectralImage, name: str) -> SpectralPanorama:
    """A spectral image (H, 2H, L) as a panorama: weights of the few spectra that hold most of its energy.

    Raises
    ------
    FileFormatError
        If it is not twice as wide as high.

    Examples
    --------
    >>> spectra = np.broadcast_to(np.linspace(1.0, 2.0, 61), (2, 4, 61))
    >>> image = SpectralImage(spectra, WAVELENGTHS_NM, np.ones((2, 4), bool))
    >>> panorama_from_image(image, "even.exr").bases.shape
    (1, 1, 61)
    """
    height, width, _ = image.spectra.shape
    if width != 2 * height:
        raise FileFormatError(
            f"{name} is {width} x {height} pixels, but a panorama is twice as wide as high. Give an equirectangular one."
        )
    onto_grid = resampling_matrix(image.wavelengths_nm, name=name).astype(np.float32)
    spectra = np.where(image.valid[..., None], image.spectra, 0.0).astype(np.float32) @ onto_grid
    basis, residual = _few_spectra(spectra.reshape(-1, len(WAVELENGTHS_NM)))
    return SpectralPanorama(
        weights=spectra @ basis.T.astype(np.float32),
        bases=basis[None],
        basis_index=np.zeros((height, width), np.uint8),
        wavelengths_nm=WAVELENGTHS_NM,
        valid=image.valid,
        confidence=image.valid.astype(np.float32),
        provenance={"file": name, "residual": f"{residual:.3g}"},
    )


def _few_spectra(spectra: FloatArray) -> tuple[FloatArray, float]:
    """The fewest orthonormal spectra (K, L) that hold spectra (N, L), at most 12, and the share of energy they miss.

    Pixels count by the square root of their energy, so that lamps do not leave the rest without a basis.
    """
    moment = np.zeros((spectra.shape[-1],) * 2)
    for start in range(0, len(spectra), _CHUNK):
        rows = spectra[start : start + _CHUNK].astype(float)
        level = np.linalg.norm(rows, axis=-1)
        moment += rows.T @ (rows / np.where(level > 0, level, 1.0)[:, None])
    energy, vectors = np.linalg.eigh(moment)
    energy, basis = np.maximum(energy[::-1], 0.0), vectors.T[::-1]
    total = float(energy.sum()) or 1.0
    needed = int(np.searchsorted(np.cumsum(energy) / total, 1.0 - _NEGLIGIBLE)) + 1
    chosen = np.ascontiguousarray(basis[: min(needed, MOST_BASIS_FUNCTIONS)])
    held = float(((spectra @ chosen.T.astype(np.float32)) ** 2).sum(dtype=float))
    whole = float((spectra**2).sum(dtype=float))
    return chosen, max(0.0, 1.0 - held / whole) if whole > 0 else 0.0

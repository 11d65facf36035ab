"""Spectral images in OpenEXR, one channel a wavelength.

The layout of Fichet, Pacanowski & Wilkie, "An OpenEXR Layout for Spectral Images", JCGT 10(3), 2021: emissive
channels `S0.550,000000nm`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ..errors import FileFormatError
from ..model import BoolArray, FloatArray, SpectralPanorama
from .image_exr import read_channels, write_channels

_CHANNEL = re.compile(r"S0\.(\d+(?:[.,]\d+)?)nm")
_HALF_LIMIT = 6.0e4


def channel_name(wavelength_nm: float) -> str:
    """Name of the emissive channel of a wavelength.

    Examples
    --------
    >>> channel_name(550)
    'S0.550,000000nm'
    """
    return f"S0.{wavelength_nm:.6f}nm".replace(".", ",").replace("S0,", "S0.")


def write_spectral_panorama(path: Path, panorama: SpectralPanorama) -> None:
    """Write the spectra of a panorama, with its `valid` mask as a further channel."""
    planes: dict[str, FloatArray] = {}
    for index, wavelength in enumerate(panorama.wavelengths_nm):
        per_basis = panorama.bases[..., index].astype(np.float32)
        planes[channel_name(float(wavelength))] = np.einsum(
            "hwk,hwk->hw", panorama.weights, per_basis[panorama.basis_index]
        )
    _write(path, planes, panorama.valid)


def write_spectral(
    path: Path, spectra: FloatArray, wavelengths_nm: FloatArray, valid: BoolArray | None = None
) -> None:
    """Write a spectral image (H, W, L)."""
    planes = {channel_name(float(nm)): spectra[..., index] for index, nm in enumerate(wavelengths_nm)}
    _write(path, planes, valid)


def _write(path: Path, planes: Mapping[str, FloatArray], valid: BoolArray | None) -> None:
    """16-bit channels where they can hold the range (a 2048 x 1024 panorama is 256 MB so), else 32-bit."""
    brightest = max(float(np.abs(plane).max()) for plane in planes.values())
    kind = np.float16 if 1.0 < brightest < _HALF_LIMIT else np.float32
    channels = {name: plane.astype(kind) for name, plane in planes.items()}
    if valid is not None:
        channels["valid"] = valid.astype(kind)
    header = {
        "spectralLayoutVersion": "1.0",
        "polarisationHandedness": "right",
        "emissiveUnits": "W.m^-2.sr^-1.nm^-1",
        "comment": "Relative spectral radiance: the scale is that of the photographs' exposures.",
    }
    write_channels(path, channels, header)


def read_spectral(path: Path) -> tuple[FloatArray, FloatArray]:
    """Spectra (H, W, L) float32 and wavelengths (L,) in nm of a spectral image.

    Raises
    ------
    FileFormatError
        If the file is missing or has no emissive spectral channels.
    """
    channels, _ = read_channels(path)
    found = {
        float(match.group(1).replace(",", ".")): name
        for name in channels
        if (match := _CHANNEL.fullmatch(name))
    }
    if not found:
        raise FileFormatError(
            f"{Path(path).name} is no spectral image: it has no channels such as S0.550,000000nm."
        )
    wavelengths = np.array(sorted(found))
    spectra = np.stack([np.asarray(channels[found[nm]], np.float32) for nm in wavelengths], axis=-1)
    return spectra, wavelengths

"""`probe.exr` and `layers.exr`: weights per pixel, with the spectra they weigh in the header."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FileFormatError
from ..model import FloatArray, LightLayers, SpectralPanorama
from .image_exr import read_channels, write_channels, write_rgb

_PROBE_HEADER = "spectralProbe"
_LAYERS_HEADER = "spectralProbeLayers"


def write_probe(path: Path, panorama: SpectralPanorama) -> None:
    """Write a spectral panorama: channels eps.0 .. eps.K-1, valid, confidence, basis_index; bases in the header.

    Where it is known, the standard error of the directions goes into the channel direction_error, in radians.
    """
    weights = np.asarray(panorama.weights, np.float32)
    channels = {f"eps.{k}": weights[..., k] for k in range(weights.shape[-1])}
    channels |= {
        "valid": panorama.valid.astype(np.float32),
        "confidence": np.asarray(panorama.confidence, np.float32),
        "basis_index": panorama.basis_index.astype(np.float32),
    }
    if panorama.direction_error_rad is not None:
        channels["direction_error"] = np.asarray(panorama.direction_error_rad, np.float32)
    header = {
        "version": 1,
        "wavelengths_nm": np.asarray(panorama.wavelengths_nm, float).tolist(),
        "bases": np.asarray(panorama.bases, float).tolist(),
        "provenance": dict(panorama.provenance),
    }
    write_channels(path, channels, {_PROBE_HEADER: json.dumps(header)})


def read_probe(path: Path) -> SpectralPanorama:
    """Read a spectral panorama written by `write_probe`.

    Raises
    ------
    FileFormatError
        If the file is missing or is no probe.
    """
    channels, header = read_channels(path)
    data = _header(header, _PROBE_HEADER, path)
    try:
        bases = np.asarray(data["bases"], float)
        wavelengths = np.asarray(data["wavelengths_nm"], float)
        weights = np.stack([channels[f"eps.{k}"] for k in range(bases.shape[1])], axis=-1).astype(np.float32)
        index = np.rint(channels["basis_index"]).astype(np.uint8)
        valid = np.asarray(channels["valid"]) > 0.5
        confidence = np.asarray(channels["confidence"], np.float32)
        provenance = {str(key): str(value) for key, value in data.get("provenance", {}).items()}
    except (KeyError, ValueError, IndexError, TypeError):
        raise FileFormatError(
            f"{Path(path).name} is a damaged probe. Build it again from its capture."
        ) from None
    if bases.ndim != 3 or bases.shape[-1] != len(wavelengths) or index.max(initial=0) >= len(bases):
        raise FileFormatError(f"{Path(path).name} is a damaged probe. Build it again from its capture.")
    error = channels.get("direction_error")
    return SpectralPanorama(
        weights,
        bases,
        index,
        wavelengths,
        valid,
        confidence,
        provenance,
        None if error is None else np.asarray(error, np.float32),
    )


def write_layers(path: Path, layers: LightLayers) -> None:
    """Write three non-negative light layers as R, G, B (to be read as Non-Color); their spectra in the header."""
    header = {
        "version": 1,
        "wavelengths_nm": np.asarray(layers.wavelengths_nm, float).tolist(),
        "spectra": np.asarray(layers.spectra, float).tolist(),
        "residual": float(layers.residual),
    }
    write_rgb(path, layers.weights, header={_LAYERS_HEADER: json.dumps(header)})


def read_layers(path: Path) -> LightLayers:
    """Read light layers written by `write_layers`.

    Raises
    ------
    FileFormatError
        If the file is missing or holds no light layers.
    """
    channels, header = read_channels(path)
    data = _header(header, _LAYERS_HEADER, path)
    if not {"R", "G", "B"} <= set(channels) or not {"spectra", "wavelengths_nm", "residual"} <= set(data):
        raise FileFormatError(f"{Path(path).name} is damaged. Build the probe again from its capture.")
    weights: FloatArray = np.stack([np.asarray(channels[name], np.float32) for name in "RGB"], axis=-1)
    return LightLayers(
        weights,
        np.asarray(data["spectra"], float),
        np.asarray(data["wavelengths_nm"], float),
        float(data["residual"]),
    )


def _header(header: dict[str, Any], key: str, path: Path) -> dict[str, Any]:
    try:
        data = json.loads(header[key])
    except (KeyError, ValueError, TypeError):
        kind = "probe.exr" if key == _PROBE_HEADER else "layers.exr"
        raise FileFormatError(
            f"{Path(path).name} was not written as a {kind} by this program. Choose that file."
        ) from None
    return dict(data)

"""`probe.exr` and `layers.exr`: weights per pixel, with the spectra they weigh in the header."""

from __future__ import annotations

import json
import operator
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FileFormatError
from ..model import Edit, FloatArray, SpectralPanorama
from ..render_model import LightLayers
from .image_exr import read_channels, write_channels, write_rgb
from .json_object import UNREADABLE

_PROBE_HEADER = "spectralProbe"
_LAYERS_HEADER = "spectralProbeLayers"

_LARGEST = 1e30
"""Basis functions are of about unit norm; larger numbers than this are damage."""

_KNOWN_ENTRIES = {"version", "wavelengths_nm", "bases", "provenance", "edits", "derived_bases"}
"""Entries of a probe's header that are fields of `SpectralPanorama`; all others travel in its `further`."""


def write_probe(path: Path, panorama: SpectralPanorama) -> None:
    """Write a spectral panorama: channels eps.0 .. eps.K-1, valid, confidence, basis_index; bases in the header.

    Where it is known, the standard error of the directions goes into the channel direction_error, in radians. Header entries are
    JSON, whose decimal numbers give back a double precision number to the bit.
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
        **panorama.further,
        "version": 1,
        "wavelengths_nm": np.asarray(panorama.wavelengths_nm, float).tolist(),
        "bases": np.asarray(panorama.bases, float).tolist(),
        "provenance": dict(panorama.provenance),
        "edits": [_edit_entry(edit) for edit in panorama.edits],
        "derived_bases": [list(stack) for stack in panorama.derived_bases],
    }
    write_channels(path, channels, {_PROBE_HEADER: json.dumps(header)})


def read_probe(path: Path) -> SpectralPanorama:
    """Read a spectral panorama written by `write_probe`, equal to the bit.

    Header entries that are not known here are kept in `further`, and written again.

    Raises
    ------
    FileFormatError
        If the file is missing, is no probe, or is damaged.
    """
    channels, header = read_channels(path)
    data = _header(header, _PROBE_HEADER, path)
    try:
        panorama = _panorama(channels, data)
    except UNREADABLE:
        raise FileFormatError(
            f"{Path(path).name} is a damaged probe. Build it again from its capture."
        ) from None
    return panorama


def _panorama(channels: Mapping[str, Any], data: Mapping[str, Any]) -> SpectralPanorama:
    """The panorama of a file's channels and header; ValueError and the like where they do not fit."""
    bases = np.asarray(data["bases"], float)
    wavelengths = np.asarray(data["wavelengths_nm"], float)
    edits = tuple(_edit(entry, len(wavelengths)) for entry in data.get("edits", ()))
    derived = tuple(tuple(map(operator.index, stack)) for stack in data.get("derived_bases", ()))
    index = np.rint(channels["basis_index"])
    if bases.ndim != 3 or bases.shape[-1] != len(wavelengths) or not (np.abs(bases) < _LARGEST).all():
        raise ValueError("the bases do not fit the wavelengths")
    if not (wavelengths[0] > 0 and np.isfinite(wavelengths[-1]) and (np.diff(wavelengths) > 0).all()):
        raise ValueError("the wavelengths do not ascend")
    if not ((index >= 0) & (index < len(bases))).all():
        raise ValueError("a texel has a basis that is not there")
    recovered = len(bases) - len(derived)
    if recovered < 1 or any(
        len(stack) < 2
        or not 0 <= stack[0] < recovered
        or not 0 <= min(stack[1:]) <= max(stack[1:]) < len(edits)
        for stack in derived
    ):
        raise ValueError("a derived basis comes from nothing")
    error = channels.get("direction_error")
    weights = np.stack([channels[f"eps.{k}"] for k in range(bases.shape[1])], axis=-1).astype(np.float32)
    confidence = np.asarray(channels["confidence"], np.float32)
    if not (np.isfinite(weights).all() and np.isfinite(confidence).all()):
        raise ValueError("a texel is not a number")
    return SpectralPanorama(
        weights=weights,
        bases=bases,
        basis_index=index.astype(np.uint8),
        wavelengths_nm=wavelengths,
        valid=np.asarray(channels["valid"]) > 0.5,
        confidence=confidence,
        provenance={str(key): str(value) for key, value in data.get("provenance", {}).items()},
        direction_error_rad=None if error is None else np.asarray(error, np.float32),
        edits=edits,
        derived_bases=derived,
        further={key: value for key, value in data.items() if key not in _KNOWN_ENTRIES},
    )


def _edit_entry(edit: Edit) -> dict[str, Any]:
    return {
        "kind": edit.kind,
        "name": edit.name,
        "region": edit.region,
        "keeps": edit.keeps,
        "spectrum": np.asarray(edit.spectrum, float).tolist(),
    }


def _edit(entry: Mapping[str, Any], wavelengths: int) -> Edit:
    spectrum = np.asarray(entry["spectrum"], float)
    if entry["kind"] not in {"glass", "lamp"} or entry["keeps"] not in {"luminance", "power", "surfaces"}:
        raise ValueError("an edit of an unknown kind")
    if spectrum.shape != (wavelengths,) or not np.isfinite(spectrum).all():
        raise ValueError("the spectrum of an edit does not fit the wavelengths")
    return Edit(entry["kind"], str(entry["name"]), str(entry["region"]), spectrum, entry["keeps"])


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
    try:
        weights: FloatArray = np.stack([np.asarray(channels[name], np.float32) for name in "RGB"], axis=-1)
        wavelengths = np.asarray(data["wavelengths_nm"], float)
        spectra = np.asarray(data["spectra"], float).reshape(3, len(wavelengths))
        return LightLayers(weights, spectra, wavelengths, float(data["residual"]))
    except UNREADABLE:
        raise FileFormatError(
            f"{Path(path).name} is damaged. Build the probe again from its capture."
        ) from None


def _header(header: dict[str, Any], key: str, path: Path) -> dict[str, Any]:
    try:
        data = dict(json.loads(header[key]))
    except UNREADABLE:
        kind = "probe.exr" if key == _PROBE_HEADER else "layers.exr"
        raise FileFormatError(
            f"{Path(path).name} was not written as a {kind} by this program. Choose that file."
        ) from None
    return data

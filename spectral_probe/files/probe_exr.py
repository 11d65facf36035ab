"""`probe.exr` and `layers.exr`: weights per pixel, with the spectra they weigh in the header."""

from __future__ import annotations

import json
import operator
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FileFormatError
from ..large import large_array, let_go
from ..model import Edit, FloatArray, SpectralPanorama
from ..render_model import LightLayers
from ..spectra.colorimetry import panorama_rec709
from .exr_rows import ExrRows
from .image_exr import open_rows, write_rgb, write_rows
from .json_object import UNREADABLE

_PROBE_HEADER = "spectralProbe"
_LAYERS_HEADER = "spectralProbeLayers"

_ERROR = "direction_error"

_LARGEST = 1e30
"""Basis functions are of about unit norm; larger numbers than this are damage."""

_KNOWN_ENTRIES = {"version", "wavelengths_nm", "bases", "provenance", "edits", "derived_bases"}
"""Entries of a probe's header that are fields of `SpectralPanorama`; all others travel in its `further`."""


def write_probe(path: Path, panorama: SpectralPanorama) -> None:
    """Write a spectral panorama: channels eps.0 .. eps.K-1, valid, confidence, basis_index; bases in the header.

    Where it is known, the standard error of the directions goes into the channel direction_error, in radians. Header entries are
    JSON, whose decimal numbers give back a double precision number to the bit.
    """
    header = {
        **panorama.further,
        "version": 1,
        "wavelengths_nm": np.asarray(panorama.wavelengths_nm, float).tolist(),
        "bases": np.asarray(panorama.bases, float).tolist(),
        "provenance": dict(panorama.provenance),
        "edits": [_edit_entry(edit) for edit in panorama.edits],
        "derived_bases": [list(stack) for stack in panorama.derived_bases],
    }

    def rows_of(rows: slice) -> dict[str, Any]:
        weights = np.asarray(panorama.weights[rows], np.float32)
        channels = {f"eps.{k}": weights[..., k] for k in range(weights.shape[-1])}
        channels |= {
            "valid": panorama.valid[rows].astype(np.float32),
            "confidence": np.asarray(panorama.confidence[rows], np.float32),
            "basis_index": panorama.basis_index[rows].astype(np.float32),
        }
        if panorama.direction_error_rad is not None:
            channels[_ERROR] = np.asarray(panorama.direction_error_rad[rows], np.float32)
        let_go(panorama.weights)  # and come back for those that are not encoded yet
        return channels

    height, width = panorama.valid.shape
    write_rows(path, (height, width), rows_of, {_PROBE_HEADER: json.dumps(header)})


def read_probe(path: Path) -> SpectralPanorama:
    """Read a spectral panorama written by `write_probe`, equal to the bit.

    Header entries that are not known here are kept in `further`, and written again.

    Raises
    ------
    FileFormatError
        If the file is missing, is no probe, or is damaged.
    """
    with open_rows(path) as image:
        data = _header(image.header, _PROBE_HEADER, path)
        try:
            return _panorama(image, data)
        except UNREADABLE:
            raise FileFormatError(
                f"{Path(path).name} is a damaged probe. Build it again from its capture."
            ) from None


def _panorama(image: ExrRows, data: Mapping[str, Any]) -> SpectralPanorama:
    """The panorama of a file's rows and header; ValueError and the like where they do not fit."""
    bases = np.asarray(data["bases"], float)
    wavelengths = np.asarray(data["wavelengths_nm"], float)
    edits = tuple(_edit(entry, len(wavelengths)) for entry in data.get("edits", ()))
    derived = tuple(tuple(map(operator.index, stack)) for stack in data.get("derived_bases", ()))
    if bases.ndim != 3 or bases.shape[-1] != len(wavelengths) or not (np.abs(bases) < _LARGEST).all():
        raise ValueError("the bases do not fit the wavelengths")
    if not (wavelengths[0] > 0 and np.isfinite(wavelengths[-1]) and (np.diff(wavelengths) > 0).all()):
        raise ValueError("the wavelengths do not ascend")
    recovered = len(bases) - len(derived)
    if recovered < 1 or any(
        len(stack) < 2
        or not 0 <= stack[0] < recovered
        or not 0 <= min(stack[1:]) <= max(stack[1:]) < len(edits)
        for stack in derived
    ):
        raise ValueError("a derived basis comes from nothing")
    return SpectralPanorama(
        **_texels(image, *bases.shape[:2]),
        bases=bases,
        wavelengths_nm=wavelengths,
        provenance={str(key): str(value) for key, value in data.get("provenance", {}).items()},
        edits=edits,
        derived_bases=derived,
        further={key: value for key, value in data.items() if key not in _KNOWN_ENTRIES},
    )


def _texels(image: ExrRows, bases: int, count: int) -> dict[str, Any]:
    """What a panorama of so many bases and weights holds of every texel; ValueError where it cannot be."""
    weights_of = [f"eps.{k}" for k in range(count)]
    names = [*weights_of, "valid", "confidence", "basis_index", *({_ERROR} & set(image.names))]
    if not set(names) <= set(image.names):
        raise KeyError("a channel is missing")
    size = (image.height, image.width)
    found = {
        "weights": large_array((*size, count)),
        "basis_index": np.empty(size, np.uint8),
        "valid": np.empty(size, bool),
        "confidence": np.empty(size, np.float32),
        **({"direction_error_rad": np.empty(size, np.float32)} if _ERROR in names else {}),
    }
    for rows in image.blocks():
        channels = image.read(names, rows)
        for k, name in enumerate(weights_of):
            found["weights"][rows][..., k] = channels[name]
        index = np.rint(channels["basis_index"])
        if not ((index >= 0) & (index < bases)).all():
            raise ValueError("a texel has a basis that is not there")
        found["basis_index"][rows] = index.astype(np.uint8)
        found["valid"][rows] = channels["valid"] > 0.5
        found["confidence"][rows] = channels["confidence"]
        if not (np.isfinite(found["weights"][rows]).all() and np.isfinite(found["confidence"][rows]).all()):
            raise ValueError("a texel is not a number")
        if _ERROR in names:
            found["direction_error_rad"][rows] = channels[_ERROR]
        let_go(found["weights"])
    return found


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


def write_world(path: Path, panorama: SpectralPanorama, header: Mapping[str, str] | None = None) -> None:
    """Write a panorama's colours, scene-linear Rec.709, as R, G, B: the world of an ordinary render."""

    def rows_of(rows: slice) -> dict[str, FloatArray]:
        colours = panorama_rec709(panorama, rows)
        return {name: colours[..., number] for number, name in enumerate("RGB")}

    height, width = panorama.valid.shape
    write_rows(path, (height, width), rows_of, header)


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
    with open_rows(path) as image:
        data = _header(image.header, _LAYERS_HEADER, path)
        try:
            wavelengths = np.asarray(data["wavelengths_nm"], float)
            spectra = np.asarray(data["spectra"], float).reshape(3, len(wavelengths))
            residual = float(data["residual"])
            weights = np.empty((image.height, image.width, 3), np.float32)
            for rows in image.blocks():
                for number, plane in enumerate(image.read("RGB", rows).values()):
                    weights[rows][..., number] = plane
        except UNREADABLE:
            raise FileFormatError(
                f"{Path(path).name} is damaged. Build the probe again from its capture."
            ) from None
    return LightLayers(weights, spectra, wavelengths, residual)


def _header(header: dict[str, Any], key: str, path: Path) -> dict[str, Any]:
    try:
        data = dict(json.loads(header[key]))
    except UNREADABLE:
        kind = "probe.exr" if key == _PROBE_HEADER else "layers.exr"
        raise FileFormatError(
            f"{Path(path).name} was not written as a {kind} by this program. Choose that file."
        ) from None
    return data

"""Light layers as a file beside the frames that they light: found once, by whoever begins a frame, and read by all other tasks.

Finding them takes far longer than most passes, and need not give the very same on another machine. The file is named after its
content, so frames in one light share it, and whoever reads it sees whether it is whole.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FileFormatError
from ..files.image_exr import read_channels, write_channels
from ..files.json_object import UNREADABLE, number, numbers, table
from ..render_model import LightLayers, LightSet
from ..spectra.grid import WAVELENGTHS_NM

LIGHT_FOLDER = "light"
"""Its name, beside the folders of the frames."""

_HEADER = "spectralProbeLight"


def save_light_sets(sets: Sequence[LightSet], folder: Path) -> str:
    """Write the layers of light sets into a folder, if they are not there yet; returns their name.

    Raises
    ------
    FileFormatError
        If they cannot be written there.
    """
    channels = {
        f"{number}.{letter}": np.ascontiguousarray(light.layers.weights[..., index], np.float32)
        for number, light in enumerate(sets)
        for index, letter in enumerate("RGB")
    }
    layers = [light.layers for light in sets]
    told = json.dumps(
        [
            {"spectra": np.asarray(one.spectra, float).tolist(), "residual": float(one.residual)}
            for one in layers
        ]
    )
    name = _name_of(channels, told)
    if load_light_sets(folder, name) is None:
        write_channels(_path(folder, name), channels, {_HEADER: told})
    return name


def load_light_sets(folder: Path, name: str) -> tuple[LightSet, ...] | None:
    """The layers of that name; None where they are not there, or damaged."""
    try:
        channels, header = read_channels(_path(folder, name))
        told = str(header[_HEADER])
        if _name_of(channels, told) != name:
            return None
        return tuple(_light_set(channels, number, one) for number, one in enumerate(json.loads(told)))
    except (*UNREADABLE, FileFormatError):
        return None


def _path(folder: Path, name: str) -> Path:
    return folder / f"{name}.exr"


def _name_of(channels: Mapping[str, Any], told: str) -> str:
    digest = hashlib.blake2b(told.encode(), digest_size=16)
    for channel in sorted(channels):
        plane = np.ascontiguousarray(channels[channel])
        digest.update(repr((channel, plane.shape, str(plane.dtype))).encode())
        digest.update(plane.data)
    return digest.hexdigest()


def _light_set(channels: Mapping[str, Any], number_of_set: int, kept: Any) -> LightSet:
    weights = np.stack([channels[f"{number_of_set}.{letter}"] for letter in "RGB"], -1)
    count = len(WAVELENGTHS_NM)
    first, second, third = (numbers(row, count) for row in table(kept)["spectra"])
    spectra = np.array([first, second, third])
    return LightSet(LightLayers(weights, spectra, WAVELENGTHS_NM.copy(), number(kept["residual"])))

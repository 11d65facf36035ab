"""objects.exr: which pixels of a render show which object, with partly covered pixels at edges."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..composite_model import ObjectCoverage
from ..errors import FileFormatError
from .image_exr import read_channels, write_channels

_OBJECT = "object."


def write_objects(path: Path, found: ObjectCoverage) -> None:
    """Write channels `coverage`, `ground`, and `object.NAME` for each virtual object, whole or not at all."""
    planes = {"coverage": found.coverage, "ground": found.ground}
    planes |= {f"{_OBJECT}{name}": plane for name, plane in found.objects.items()}
    write_channels(path, {name: np.asarray(plane, np.float32) for name, plane in planes.items()})


def read_objects(path: Path) -> ObjectCoverage:
    """Read what `write_objects` wrote.

    Raises
    ------
    FileFormatError
        If the file is missing or holds something else.
    """
    channels, _ = read_channels(path)
    if "coverage" not in channels or "ground" not in channels:
        raise FileFormatError(
            f"{Path(path).name} does not say which pixels show which object. Render the scene again."
        )
    planes = {name: np.asarray(plane, np.float32) for name, plane in channels.items()}
    objects = {
        name.removeprefix(_OBJECT): plane for name, plane in planes.items() if name.startswith(_OBJECT)
    }
    return ObjectCoverage(objects, planes["coverage"], planes["ground"])

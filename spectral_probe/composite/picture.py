"""Scene-linear pictures of a render as tristimulus values."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FileFormatError
from ..model import FloatArray
from ..render.outputs import WHITE_ATTRIBUTE
from ..spectra.white import parse_white
from ..spectra.working_space import space_of_header


def picture_xyz(channels: Mapping[str, Any], header: Mapping[str, Any], path: Path) -> FloatArray:
    """Tristimulus values (H, W, 3) of R, G, B in the space that the header says, not adapted from any white.

    Raises
    ------
    FileFormatError
        If R, G, B are missing.
    """
    if any(name not in channels for name in "RGB"):
        raise FileFormatError(f"{path} does not hold R, G, B. Render the scene again.")
    rgb = np.stack([np.asarray(channels[name], np.float32) for name in "RGB"], -1)
    xyz = space_of_header(header, path.name).to_xyz(rgb)
    white = parse_white(str(header.get(WHITE_ATTRIBUTE, "")))
    if white is not None:
        xyz = xyz @ np.linalg.inv(white.adapted(np.eye(3))).astype(np.float32)
    return np.asarray(xyz, np.float32)

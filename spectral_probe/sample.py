"""The bundled sample, a gym of which everything is known, and the stained glass of the paper's fig. 12 before its windows."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from .errors import CaptureError
from .model import SpectralPanorama
from .spectra.edits import apply_edit, glass_edit
from .spectra.regions import polygon_mask

GYM = Path(__file__).resolve().parents[1] / "sample_scenes" / "gym"

GLASSES = ("red", "yellow", "green")
"""The paper's three, before the windows from west to east, and over again."""

_REVEAL_M = 0.25
"""How far a pane's region reaches beyond the window: the white reveal glares, and photographs of a ball blur it by a degree."""


def gym_truth() -> dict[str, Any]:
    """The sample's lamps and windows, `truth/scene.json`; one of each is recommended and has a true spectrum.

    Raises
    ------
    CaptureError
        If this copy of the project has no sample.

    Examples
    --------
    >>> len(gym_truth()["windows"])
    6
    """
    path = GYM / "truth" / "scene.json"
    if not path.is_file():
        raise CaptureError(f"The bundled sample is not in {GYM}. Get a whole copy of the project.")
    return dict(json.loads(path.read_text("utf-8")))


def window_polygons(truth: dict[str, Any]) -> list[tuple[tuple[float, float], ...]]:
    """The windows' corners as seen from the ball, (bearing, elevation) in degrees, from west to east.

    Examples
    --------
    >>> corners = window_polygons(gym_truth())[3]  # from the bottom left corner on, counter-clockwise
    >>> [[round(float(angle)) for angle in corner] for corner in corners]
    [[352, 8], [16, 8], [16, 30], [352, 31]]
    """
    half_width, half_height = (side / 2 + _REVEAL_M for side in truth["window_size_m"])
    polygons = []
    for window in truth["windows"]:
        east, north, up = np.subtract(window["at_m"], truth["ball_at_m"])
        polygons.append(
            tuple(
                _bearing(east + right * half_width, north, up + above * half_height)
                for right, above in ((-1, -1), (1, -1), (1, 1), (-1, 1))
            )
        )
    return polygons


def stained_gym(panorama: SpectralPanorama) -> SpectralPanorama:
    """The gym's light with red, yellow and green glass before its windows in turn, as three edits.

    Parameters
    ----------
    panorama
        What `probe` made of the sample's photographs; any width.
    """
    windows = window_polygons(gym_truth())
    for first, glass in enumerate(GLASSES):
        masks = [polygon_mask(corners, *panorama.valid.shape) for corners in windows[first :: len(GLASSES)]]
        panes = np.logical_or.reduce(masks)
        where = f"windows {', '.join(str(number) for number in range(first, len(windows), len(GLASSES)))}"
        panorama = apply_edit(panorama, glass_edit(panorama, glass, where), panes)
    return panorama


def _bearing(east_m: float, north_m: float, up_m: float) -> tuple[float, float]:
    across_m = math.hypot(east_m, north_m)
    return math.degrees(math.atan2(east_m, north_m)) % 360.0, math.degrees(math.atan2(up_m, across_m))

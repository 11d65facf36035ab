"""The bundled sample, a gym of which everything is known, and the stained glass of the paper's fig. 12 before its windows."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from .errors import CaptureError
from .model import BoolArray, SpectralPanorama
from .spectra.edits import apply_edit, glass_edit
from .spectra.growing import panorama_luminance
from .spectra.regions import polygon_mask

GYM = Path(__file__).resolve().parents[1] / "sample_scenes" / "gym"

GLASSES = ("red", "yellow", "green")
"""The paper's three, before the windows from west to east, and over again."""

_WALL_M = 0.35
"""Thickness of the wall with the windows, `sample_scenes/gym/builder/layout.py`; the panes are level with its outside."""

_MARGIN_M = 0.25
"""How far beyond its opening a window's light is looked for: photographs of a ball blur and shift it by up to a degree."""

_BRIGHT = 0.2
"""Share of a window's light from which a texel belongs to it: the wall beside has a tenth."""

_BARS_DEG = 2.5
"""Glazing bars are less wide, and belong to the window."""

_RIM_DEG = 0.7
"""How far the blurred edge of a window reaches beyond what is bright."""


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
    """Corners about the windows' openings as seen from the ball, (bearing, elevation) in degrees, from west to east.

    The openings are those in the wall's inside: what is seen in them is the panes and, glaring in their light, the white reveals.

    Examples
    --------
    >>> corners = window_polygons(gym_truth())[3]  # from the bottom left corner on, counter-clockwise
    >>> [[round(float(angle)) for angle in corner] for corner in corners]
    [[352, 8], [17, 8], [17, 31], [352, 32]]
    """
    half_width, half_height = (side / 2 + _MARGIN_M for side in truth["window_size_m"])
    polygons = []
    for window in truth["windows"]:
        east, north, up = np.subtract(window["at_m"], truth["ball_at_m"]) - (0.0, _WALL_M, 0.0)
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
        panes = np.logical_or.reduce([_glazed(panorama, window) for window in windows[first :: len(GLASSES)]])
        where = f"windows {', '.join(str(number) for number in range(first, len(windows), len(GLASSES)))}"
        panorama = apply_edit(panorama, glass_edit(panorama, glass, where), panes)
    return panorama


def _glazed(panorama: SpectralPanorama, corners: tuple[tuple[float, float], ...]) -> BoolArray:
    """The texels (H, W) of one window: what is bright near its opening, and the bars between."""
    near = polygon_mask(corners, *panorama.valid.shape)
    luminance = panorama_luminance(panorama)
    bright = near & (luminance > _BRIGHT * np.percentile(luminance[near], 75))
    texels_per_deg = panorama.valid.shape[1] / 360
    bars, rim = max(1, round(_BARS_DEG * texels_per_deg)), 2 * round(_RIM_DEG * texels_per_deg) + 1
    closed = cv2.morphologyEx(bright.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((bars, bars), np.uint8))
    return np.asarray(cv2.dilate(closed, np.ones((rim, rim), np.uint8)) > 0) & near


def _bearing(east_m: float, north_m: float, up_m: float) -> tuple[float, float]:
    across_m = math.hypot(east_m, north_m)
    return math.degrees(math.atan2(east_m, north_m)) % 360.0, math.degrees(math.atan2(up_m, across_m))

"""The paper's objects put where the ball stood, in the sizes that they have to each other."""

import math
from collections.abc import Callable, Mapping, Sequence

import bpy
import numpy as np

from .objects import (
    COPPER_RADIUS_M,
    PEDESTAL_HEIGHT_M,
    SILVER_RADIUS_M,
    add_copper_ball,
    add_gold_pedestal,
    add_silver_ball,
    scale_beside_ball,
)

_ADD: Mapping[str, Callable[..., bpy.types.Object]] = {
    "gold-pedestal": add_gold_pedestal,
    "silver-ball": add_silver_ball,
    "copper-ball": add_copper_ball,
}
_HEIGHT_M = {
    "gold-pedestal": PEDESTAL_HEIGHT_M,
    "silver-ball": 2 * SILVER_RADIUS_M,
    "copper-ball": 2 * COPPER_RADIUS_M,
}
_APART_M = 0.37
"""Between the middles of things that stand side by side: the pedestal and the large ball clear each other."""


def scale_of(name: str, height_m: float | None, ball_radius_m: float) -> float:
    """The scale at which an object has a height; without one, the copper ball is as large as the mirrored one was."""
    return scale_beside_ball(ball_radius_m) if height_m is None else height_m / _HEIGHT_M[name]


def place_objects(
    scene: bpy.types.Scene, names: Sequence[str], scale: float, heading_rad: float
) -> list[bpy.types.Object]:
    """Put objects on the ground at the world's origin, the first where the ball stood and the others to its right.

    A silver ball that follows a gold pedestal stands on it.

    Parameters
    ----------
    scene
        The scene.
    names
        "gold-pedestal", "silver-ball", "copper-ball".
    scale
        Of all of them, in metres (`scale_of`).
    heading_rad
        Compass bearing of the camera's view: what "right" is.
    """
    unit = scene.unit_settings.scale_length
    right = np.array([math.cos(heading_rad), -math.sin(heading_rad), 0.0])
    nearer = -np.array([math.sin(heading_rad), math.cos(heading_rad), 0.0])
    placed, standing = [], 0
    for index, name in enumerate(names):
        on_top = name == "silver-ball" and index > 0 and names[index - 1] == "gold-pedestal"
        if on_top:
            place = np.asarray(placed[-1].location) * unit / scale + (0.0, 0.0, PEDESTAL_HEIGHT_M)
        else:
            place = standing * _APART_M * right + (0.4 * _APART_M * nearer if standing % 2 else 0.0)
            standing += 1
        placed.append(_ADD[name](scene.collection, tuple(place * scale / unit), scale / unit))
    return placed

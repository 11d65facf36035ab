"""Scene-linear RGB spaces: those Blender can work in, and the `chromaticities` attribute of OpenEXR.

A space whose white is not D65 (ACEScg) is taken to D65 and back by the Bradford transform, as Blender does: its R = G = B
is then our white too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import FileFormatError
from ..model import FloatArray
from .colorimetry import rec709_to_xyz, xyz_to_rec709
from .colour_science import colour

_KNOWN = {"Linear Rec.709": "ITU-R BT.709", "Linear Rec.2020": "ITU-R BT.2020", "ACEScg": "ACEScg"}
_SAME = 2e-4
"""Largest difference of two matrices of one space: primaries are given with three or four digits."""


@dataclass(frozen=True)
class WorkingSpace:
    """A scene-linear RGB space.

    Parameters
    ----------
    name
        As Blender calls it; "scene-linear" for one that is not known by name.
    to_rec709
        (3, 3) matrix to linear Rec.709.
    chromaticities
        x, y of red, green, blue and white: the attribute of OpenEXR.
    """

    name: str
    to_rec709: FloatArray
    chromaticities: tuple[float, ...]

    def of_xyz(self, xyz: FloatArray) -> FloatArray:
        """Colours (..., 3) in this space of tristimulus values (..., 3)."""
        from_rec709 = np.linalg.inv(self.to_rec709).astype(np.asarray(xyz).dtype)
        return xyz_to_rec709(xyz) @ from_rec709.T

    def to_xyz(self, rgb: FloatArray) -> FloatArray:
        """Tristimulus values (..., 3) of colours (..., 3) in this space; the inverse of `of_xyz`."""
        return rec709_to_xyz(rgb @ self.to_rec709.T.astype(np.asarray(rgb).dtype))


def working_space(to_rec709: FloatArray | None = None) -> WorkingSpace:
    """The space of a matrix to linear Rec.709; None is Rec.709 itself.

    Examples
    --------
    >>> working_space().name
    'Linear Rec.709'
    >>> working_space(np.diag([2.0, 1.0, 0.5])).name
    'scene-linear'
    """
    matrix = np.eye(3) if to_rec709 is None else np.asarray(to_rec709, float)
    for name, known in _KNOWN.items():
        space = colour.RGB_COLOURSPACES[known]
        points = (*np.ravel(space.primaries).tolist(), *np.ravel(space.whitepoint).tolist())
        if np.abs(_matrix_of(points) - matrix).max() < _SAME:
            return WorkingSpace(name, matrix, points)
    corners = rec709_to_xyz(np.vstack([np.eye(3), np.ones(3)]) @ matrix.T)
    xy = corners[:, :2] / corners.sum(1, keepdims=True)
    return WorkingSpace("scene-linear", matrix, tuple(np.ravel(xy).tolist()))


def space_of_header(header: Mapping[str, Any], name: str) -> WorkingSpace:
    """The space of an OpenEXR image: that of its attribute `chromaticities`, Rec.709 without one.

    Raises
    ------
    FileFormatError
        If they span no space.
    """
    given = header.get("chromaticities")
    if given is None:
        return working_space()
    points = tuple(np.ravel(np.asarray(given, float)).tolist())
    try:
        matrix = _matrix_of(points)
    except (np.linalg.LinAlgError, ValueError, IndexError):
        matrix = np.full((3, 3), np.nan)
    if len(points) != 8 or not np.isfinite(matrix).all():
        raise FileFormatError(f"The chromaticities of {name} span no colours. Write it in Rec.709.")
    return working_space(matrix)


def _matrix_of(points: Sequence[float]) -> FloatArray:
    """(3, 3) matrix to linear Rec.709 of x, y of red, green, blue and white."""
    white = np.asarray(points[6:8], float)
    to_xyz = colour.normalised_primary_matrix(np.asarray(points[:6], float).reshape(3, 2), white)
    d65 = colour.RGB_COLOURSPACES["ITU-R BT.709"].whitepoint
    adapted = colour.adaptation.matrix_chromatic_adaptation_VonKries(
        colour.xy_to_XYZ(white), colour.xy_to_XYZ(d65), transform="Bradford"
    )
    return xyz_to_rec709((np.asarray(adapted) @ np.asarray(to_xyz)).T).T

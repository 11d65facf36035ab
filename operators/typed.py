"""Values of properties as people typed them."""

from __future__ import annotations

import math
import os
import re
from pathlib import Path

import bpy

from ..spectral_probe.errors import SpectralDataError

_NUMBER = r"([-+]?(?:\d+\.?\d*|\.\d+))"
_CORNER = re.compile(rf"{_NUMBER}(?:\s*,\s*|\s+){_NUMBER}")


def path_of(text: str) -> Path | None:
    """Absolute path of a path property, or None where it is empty."""
    return Path(os.path.normpath(bpy.path.abspath(text))) if text else None


def path_text(path: Path | str) -> str:
    """A path as a property keeps it: relative to a saved .blend where Blender's preference is Relative Paths."""
    if bpy.data.filepath and bpy.context.preferences.filepaths.use_relative_paths:
        try:
            return str(bpy.path.relpath(str(path)))
        except ValueError:  # on another drive
            pass
    return str(path)


def decimal(value: float) -> float:
    """The decimal number a person typed: Blender keeps 32 bits, which hold about seven digits."""
    return float(f"{value:.7g}")


def degrees(angle_rad: float) -> float:
    """An angle of Blender's in degrees."""
    return round(math.degrees(angle_rad), 4)


def corners_of(text: str) -> tuple[tuple[float, float], ...]:
    """Corners of a polygon as people write them: `10 5, 40 5, 25 30` or `10,5; 40,5; 25,30`.

    Raises
    ------
    SpectralDataError
        If a corner is not two numbers.
    """
    corners = []
    for written in text.strip().strip(",;").split(";" if ";" in text else ","):
        corner = _CORNER.fullmatch(written.strip())
        if corner is None:
            raise SpectralDataError(
                f'"{written.strip()}" is no corner. Write bearing and elevation of each in degrees: 10 5, 40 5, 25 30.'
            )
        corners.append((float(corner[1]), float(corner[2])))
    return tuple(corners)

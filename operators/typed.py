"""Values of properties as people typed them."""

from __future__ import annotations

import math
from pathlib import Path

import bpy


def path_of(text: str) -> Path | None:
    """Absolute path of a path property, or None where it is empty."""
    return Path(bpy.path.abspath(text)) if text else None


def decimal(value: float) -> float:
    """The decimal number a person typed: Blender keeps 32 bits, which hold about seven digits."""
    return float(f"{value:.7g}")


def degrees(angle_rad: float) -> float:
    """An angle of Blender's in degrees."""
    return round(math.degrees(angle_rad), 4)

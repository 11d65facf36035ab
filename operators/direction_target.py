"""What a direction, or a polygon, that was pointed at is for: the fields that take it."""

from __future__ import annotations

from dataclasses import dataclass

import bpy

from ..spectral_probe.errors import SpectralDataError

TARGETS = (
    ("SPECTRUM", "Plots", "The direction whose spectrum is shown"),
    ("EDIT", "Glass and Lamps", "The region that a glass or another lamp is put into"),
    ("LIGHT", "Lamps by Region", "The active region with a light of its own"),
    ("CALIBRATION", "Calibration", "The known light in the ball"),
    ("COMPARE", "Compare", "The light in which metals are compared by four ways of RGB"),
    ("SWAP", "Swap", "The active region whose light can be exchanged after rendering"),
)
"""Items of an enumeration: whatever has a bearing and an elevation."""

POLYGON_TARGETS = tuple(item for item in TARGETS if item[0] in {"EDIT", "LIGHT", "SWAP"})
"""Those that have a polygon."""


@dataclass(frozen=True)
class RegionFields:
    """A group of settings that says where a region is, and the names of its fields."""

    group: bpy.types.PropertyGroup
    kind: str
    azimuth: str
    polygon: str

    @property
    def corners(self) -> str:
        """The polygon's corners as text; empty where the region is none."""
        return getattr(self.group, self.polygon) if getattr(self.group, self.kind) == "POLYGON" else ""

    def set_corners(self, text: str) -> None:
        """Make the region a polygon with these corners."""
        setattr(self.group, self.kind, "POLYGON")
        setattr(self.group, self.polygon, text)

    def set_seed(self, azimuth_rad: float, elevation_rad: float) -> None:
        """Make the region that which lies round a direction."""
        setattr(self.group, self.kind, "SEED")
        setattr(self.group, self.azimuth, azimuth_rad)
        self.group.elevation = elevation_rad

    def state(self) -> tuple[str, str]:
        """What `restore` needs."""
        return getattr(self.group, self.kind), getattr(self.group, self.polygon)

    def restore(self, state: tuple[str, str]) -> None:
        """As it was at `state`."""
        setattr(self.group, self.kind, state[0])
        setattr(self.group, self.polygon, state[1])


def region_fields(settings: bpy.types.PropertyGroup, target: str) -> RegionFields | None:
    """The fields of a target's region; None where it has no region (yet)."""
    known, swap = settings.known_light, settings.swap
    if target == "EDIT":
        return RegionFields(settings.region, "kind", "azimuth", "polygon")
    if target == "LIGHT" and known.active_region < len(known.regions):
        return RegionFields(known.regions[known.active_region], "place", "bearing", "polygon_deg")
    if target == "SWAP" and swap.active_item < len(swap.items):
        return RegionFields(swap.items[swap.active_item], "kind", "azimuth", "polygon")
    return None


def needed_fields(settings: bpy.types.PropertyGroup, target: str) -> RegionFields:
    """The fields of a target's region.

    Raises
    ------
    SpectralDataError
        If there is no such region yet.
    """
    fields = region_fields(settings, target)
    if fields is None:
        panel = next(name for key, name, _ in TARGETS if key == target)
        raise SpectralDataError(f"There is no region yet. Add one in {panel} first.")
    return fields


def put_direction(
    settings: bpy.types.PropertyGroup, target: str, azimuth_rad: float, elevation_rad: float
) -> None:
    """Fill the fields of a target with a bearing and an elevation.

    Raises
    ------
    SpectralDataError
        If the target is a region that is not there yet.
    """
    if target == "SPECTRUM":
        settings.spectrum.azimuth, settings.spectrum.elevation = azimuth_rad, elevation_rad
    elif target == "CALIBRATION":
        known = settings.known_light.calibration
        known.bearing, known.elevation = azimuth_rad, elevation_rad
    elif target == "COMPARE":
        settings.compare.light = "DIRECTION"
        settings.compare.azimuth, settings.compare.elevation = azimuth_rad, elevation_rad
    else:
        needed_fields(settings, target).set_seed(azimuth_rad, elevation_rad)

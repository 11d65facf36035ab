"""What is known of the light, between the settings of a scene and the `Capture` that the core works with."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path

import bpy

from ..spectral_probe.errors import CaptureError, SpectralDataError
from ..spectral_probe.light_settings import CalibrationSettings, Rectangle, Region, RegionLight
from ..spectral_probe.model import Capture
from .typed import corners_of, decimal, degrees, path_of, path_text


def filter_from(text: str) -> str | Path | None:
    """A view's filter: a path, or the name of a glass, which is neither a file nor has a suffix."""
    path = path_of(text)
    if path is None:
        return None
    return path if path.suffix or text.startswith("//") or path.is_file() else text.strip()


def families_from(group: bpy.types.PropertyGroup) -> tuple[str, ...]:
    """The lamp families chosen in a group, in the library's order.

    Raises
    ------
    CaptureError
        If none is chosen.
    """
    if group.families_automatic:
        return ("automatic",)
    known = group.bl_rna.properties["families"].enum_items.keys()
    families = tuple(family for family in known if family in group.families)
    if not families:
        raise CaptureError("No lamp family is chosen. Choose those that may be present, or Any Lamps.")
    return families


def fill_families(group: bpy.types.PropertyGroup, families: Iterable[str]) -> None:
    """The inverse of `families_from`."""
    group.families_automatic = "automatic" in families
    group.families = set(families) - {"automatic"}


def own_lights_from(known: bpy.types.PropertyGroup) -> tuple[Path, ...]:
    """Files of the user's own lights."""
    return tuple(path for light in known.own_lights if (path := path_of(light.path)) is not None)


def regions_from(known: bpy.types.PropertyGroup) -> tuple[RegionLight, ...]:
    """The regions with a light of their own."""
    return tuple(_region_from(region, number) for number, region in enumerate(known.regions, 1))


def calibration_from(known: bpy.types.PropertyGroup) -> CalibrationSettings | None:
    """The known light, None where there is none."""
    group = known.calibration
    if group.source == "NONE":
        return None
    patch, measured = group.source == "PATCH", group.light == "SPECTRUM"
    return CalibrationSettings(
        light_at=None if patch else (degrees(group.bearing), degrees(group.elevation)),
        patch_px=_rectangle(group.patch_px) if patch else None,
        view=group.view if patch else 1,
        spectrum=path_of(group.spectrum) if measured else None,
        illuminant=None if measured else group.illuminant,
        reflectance=path_of(group.reflectance_path) or decimal(group.reflectance),
        absolute=group.absolute and measured,
        ball_patch_px=_rectangle(group.ball_patch_px) if patch and group.has_ball_patch else None,
    )


def fill_known_light(settings: bpy.types.PropertyGroup, capture: Capture) -> None:
    """Put what a capture knows of the light into a scene's settings; what an earlier one gave is cleared."""
    settings.property_unset("known_light")
    known = settings.known_light
    for path in capture.spectra:
        known.own_lights.add().path = path_text(path)
    for number, light in enumerate(capture.regions, 1):
        region = known.regions.add()
        region.name = f"Region {number}"
        _fill_region(region, light)
    if capture.calibration is not None:
        _fill_calibration(known.calibration, capture.calibration)


def _region_from(group: bpy.types.PropertyGroup, number: int) -> RegionLight:
    seed = (degrees(group.bearing), degrees(group.elevation))
    region = Region(
        polygon_deg=_corners(group.polygon_deg, number) if group.place == "POLYGON" else None,
        mask=path_of(group.mask) if group.place == "MASK" else None,
        seed_deg=seed if group.place == "SEED" else None,
    )
    if group.light == "SPECTRUM":
        return RegionLight(region, spectrum=path_of(group.spectrum))
    return RegionLight(region, families=families_from(group))


def _corners(text: str, number: int) -> tuple[tuple[float, float], ...]:
    try:
        return corners_of(text)
    except SpectralDataError as problem:
        raise CaptureError(f"Region {number}: {problem}") from problem


def _fill_region(group: bpy.types.PropertyGroup, light: RegionLight) -> None:
    region = light.region
    if region.polygon_deg is not None:
        group.place = "POLYGON"
        group.polygon_deg = ", ".join(
            f"{bearing:g} {elevation:g}" for bearing, elevation in region.polygon_deg
        )
    elif region.mask is not None:
        group.place, group.mask = "MASK", path_text(region.mask)
    elif region.seed_deg is not None:
        group.place = "SEED"
        group.bearing, group.elevation = map(math.radians, region.seed_deg)
    if light.spectrum is not None:
        group.light, group.spectrum = "SPECTRUM", path_text(light.spectrum)
    else:
        fill_families(group, light.families or ())


def _fill_calibration(group: bpy.types.PropertyGroup, given: CalibrationSettings) -> None:
    group.source = "BALL" if given.patch_px is None else "PATCH"
    group.view = given.view
    if given.patch_px is not None:
        group.patch_px = given.patch_px
    if given.light_at is not None:
        group.bearing, group.elevation = map(math.radians, given.light_at)
    group.light = "ILLUMINANT" if given.spectrum is None else "SPECTRUM"
    group.illuminant = given.illuminant or "A"
    group.spectrum = path_text(given.spectrum) if given.spectrum else ""
    group.absolute = given.absolute
    if isinstance(given.reflectance, Path):
        group.reflectance_path = path_text(given.reflectance)
    else:
        group.reflectance = given.reflectance
    group.has_ball_patch = given.ball_patch_px is not None
    group.ball_patch_px = given.ball_patch_px or (0.0,) * 4


def _rectangle(values: bpy.types.bpy_prop_array) -> Rectangle:
    left, top, right, bottom = (decimal(value) for value in values)
    return (left, top, right, bottom)

"""From the region in the panel to the texels of a panorama, and the job that edits the light there."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..spectral_probe.model import Job, Region
from .job import JobOperator
from .polls import has_probe, has_region
from .results import keep_edits
from .settings import built_folder, probe_folder
from .typed import corners_of

if TYPE_CHECKING:
    from ..spectral_probe.editing import Change, EditedLight
    from ..spectral_probe.model import BoolArray, SpectralPanorama

type Find = Callable[[SpectralPanorama], BoolArray]


def region_from(settings: bpy.types.PropertyGroup) -> tuple[str, Find]:
    """The region of the panel in words, and the function that finds its texels in a panorama.

    Blender data are read here and not in the function, which may run in another thread.

    Raises
    ------
    SpectralProbeError
        If the corners or the mask cannot be used.
    """
    from ..spectral_probe.spectra.regions import check_region, describe, region_mask

    if settings.kind == "MASK":
        return _painted(settings.mask)
    if settings.kind == "POLYGON":
        region = Region(polygon_deg=corners_of(settings.polygon))
    else:
        seed = math.degrees(settings.azimuth) % 360.0, math.degrees(settings.elevation)
        region = Region(seed_deg=(round(seed[0], 4), round(seed[1], 4)))
    check_region(region)
    return describe(region), lambda panorama: region_mask(region, panorama)


def _painted(image: bpy.types.Image) -> tuple[str, Find]:
    from ..spectral_probe.spectra.regions import checked_mask, mask_from_pixels
    from .bridge.images import pixels_of

    pixels, name = pixels_of(image), image.name

    def find(panorama: SpectralPanorama) -> BoolArray:
        mask = mask_from_pixels(pixels, *panorama.valid.shape, name)
        return checked_mask(mask, panorama, f"mask {name}")

    return f"mask {name}", find


class EditsLight(JobOperator):
    """Mixin for operators that edit the probe's light: `edit` says how, the files are written, and the world follows."""

    in_thread = True

    def edit(self, context: bpy.types.Context) -> Callable[[SpectralPanorama], SpectralPanorama]:
        """Read the settings and return what is to be done to the panorama; every operator has its own."""
        raise NotImplementedError

    def job(self, context: bpy.types.Context) -> Job[EditedLight]:
        """Read the settings and start."""
        settings = context.scene.spectral_probe
        return _edited(probe_folder(settings), built_folder(settings), self.edit(context))

    def done(self, context: bpy.types.Context, result: Any) -> None:
        """Keep the list of edits, and light the world with the new state."""
        from .bridge.panorama_image import follow_picture
        from .bridge.world import follow_light

        settings = context.scene.spectral_probe
        base = built_folder(settings)
        keep_edits(settings, result)
        follow_light(context.scene, base, result.directory / "world.exr")
        follow_picture(settings)
        self.tell("INFO", _said(len(result.edits)))


def _edited(
    directory: Path, base: Path, edit: Callable[[SpectralPanorama], SpectralPanorama]
) -> Job[EditedLight]:
    """Edit the light, and keep it in memory for the panorama's tools."""
    from ..spectral_probe.editing import edit_light
    from .bridge.opened_probe import MEMORY

    light = yield from edit_light(directory, base, edit)
    MEMORY.keep(light.directory / "probe.exr", light.panorama)
    return light


def _said(count: int) -> str:
    if count == 0:
        return "The probe's light is as it was built"
    if count == 1:
        return rpt_("The probe's light has 1 edit")
    return rpt_("The probe's light has {count} edits").format(count=count)


class ChangesRegion(EditsLight):
    """Mixin for operators that put something into the panel's region."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a probe and a region."""
        return has_probe(cls, context) and has_region(cls, context)

    def change(self, settings: bpy.types.PropertyGroup) -> Change:
        """What to put there; every operator has its own."""
        raise NotImplementedError

    def edit(self, context: bpy.types.Context) -> Callable[[SpectralPanorama], SpectralPanorama]:
        """Find the region, and put it there."""
        from ..spectral_probe.spectra.edits import apply_edit

        settings = context.scene.spectral_probe.region
        change = self.change(settings)
        where, find = region_from(settings)
        return lambda panorama: apply_edit(panorama, change.of(panorama, where), find(panorama))

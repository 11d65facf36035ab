"""List metals, glasses, measured surfaces and lamps with the colours they have under a light."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import bpy
from bpy.app.translations import pgettext_iface as iface_
from bpy.app.translations import pgettext_rpt as rpt_

from ..preferences import library_folder
from ..spectral_probe.model import Job, Progress
from .bridge.swatches import SwatchShelf
from .job import JobOperator
from .polls import has_probe
from .settings import probe_folder

if TYPE_CHECKING:
    from pathlib import Path

    from ..spectral_probe.spectra.swatches import Swatch


@dataclass(frozen=True)
class _Listed:
    named: tuple[Swatch, ...]
    pages: tuple[Swatch, ...]
    light: str


class SPECTRAL_PROBE_OT_show_swatches(JobOperator, bpy.types.Operator):
    """List the library's metals, glasses, measured surfaces and lamps, with the colours they have under the light chosen"""

    bl_idname = "spectral_probe.show_swatches"
    bl_label = "Show Swatches"

    in_thread = True

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """The probe must be there where its light is asked for."""
        asked = context.scene.spectral_probe.swatches.light == "DIRECTION"
        return not asked or has_probe(
            cls, context, "Build the probe first, or choose another light for the swatches"
        )

    def job(self, context: bpy.types.Context) -> Job[_Listed]:
        """Compute the swatches under the light chosen."""
        settings = context.scene.spectral_probe
        chosen = settings.swatches
        light, at = chosen.lamp if chosen.light == "LAMP" else "D65", None
        if chosen.light != "LAMP" and settings.probe_directory:
            probe = probe_folder(settings) / "probe.exr"
            light = str(probe) if chosen.light == "DIRECTION" or probe.is_file() else light
        if chosen.light == "DIRECTION":
            at = (math.degrees(chosen.azimuth) % 360, math.degrees(chosen.elevation))
        return _swatches(light, at, library_folder())

    def done(self, context: bpy.types.Context, result: _Listed) -> None:
        """Fill the list."""
        listed = context.window_manager.spectral_probe_swatches
        SwatchShelf.fill(listed, result.named, result.pages, result.light)
        counted = rpt_("{named} entries and {pages} pages of refractiveindex.info under {light}")
        self.tell(
            "INFO",
            counted.format(named=len(result.named), pages=len(result.pages), light=result.light),
        )


def _swatches(light: str, at: tuple[float, float] | None, folder: Path | None) -> Job[_Listed]:
    yield Progress(0.0, iface_("Loading the library"))
    from ..spectral_probe.light_choice import chosen_light
    from ..spectral_probe.spectra.swatches import library_swatches, page_swatches

    seen_by = chosen_light(light, at)
    yield Progress(0.3, iface_("Colours of the library"))
    named = library_swatches(seen_by.spectrum, folder)
    pages = yield from page_swatches(seen_by.spectrum)
    return _Listed(named, pages, seen_by.name)

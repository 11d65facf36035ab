"""Point at a direction of the panorama: its spectrum follows the mouse, a click takes it."""

from __future__ import annotations

import math
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.props import EnumProperty, FloatProperty

from ..spectral_probe.errors import SpectralProbeError
from .base import FINISHED, OperatorResult
from .bridge.opened_probe import MEMORY
from .bridge.panorama_image import redraw_panoramas
from .direction_target import TARGETS, put_direction
from .job import RUNNING
from .open_modals import timer
from .pointing import PointsAtPanorama
from .results import keep_spectrum
from .settings import path_of, probe_folder
from .typed import degrees

if TYPE_CHECKING:
    from ..spectral_probe.model import SpectralPanorama
    from ..spectral_probe.spectrum_command import DirectionSpectrum

_KINDS_SHOWN = 3
_TICK_S = 0.1


class SPECTRAL_PROBE_OT_pick_direction(PointsAtPanorama, bpy.types.Operator):
    """Point at the panorama to see the spectrum of the light from there; click to take the direction"""

    bl_idname = "spectral_probe.pick_direction"
    bl_label = "Pick Direction"
    words = "Click: take this direction, ESC: stop"

    target: EnumProperty(
        name="For", description="What the direction is for", items=TARGETS, options={"SKIP_SAVE"}
    )
    azimuth: FloatProperty(
        name="Bearing",
        description="Compass bearing of the direction: 0 along +Y, clockwise seen from above",
        subtype="ANGLE",
        options={"SKIP_SAVE"},
    )
    elevation: FloatProperty(
        name="Elevation",
        description="Elevation of the direction above the horizon",
        subtype="ANGLE",
        min=-math.pi / 2,
        max=math.pi / 2,
        options={"SKIP_SAVE"},
    )

    _reading: Future[Any] | None = None
    _waiting: ExitStack | None = None  # with the timer, while the probe is being read
    _at: tuple[float, float] | None = None  # where the mouse is while the probe is being read

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Take the direction given, and compute what its light is."""
        settings = context.scene.spectral_probe
        panorama = MEMORY.read(probe_folder(settings) / "probe.exr").panorama
        put_direction(settings, self.target, self.azimuth, self.elevation)
        found = show_direction(context, panorama, degrees(self.azimuth) % 360.0, degrees(self.elevation))
        if found is not None and self.target == "SPECTRUM":
            keep_spectrum(settings, numbers_beside(settings, found))
        return FINISHED

    def begin(self, context: bpy.types.Context, opened: ExitStack) -> None:
        """Read the probe in another thread: it may be large."""
        path = probe_folder(context.scene.spectral_probe) / "probe.exr"
        with_one = ThreadPoolExecutor(max_workers=1)
        self._reading = with_one.submit(_read, path)
        with_one.shutdown(wait=False)
        self._waiting = opened.enter_context(ExitStack())
        self._waiting.enter_context(timer(context, _TICK_S))

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        """Called by Blender for every event: once the probe was read the light under the mouse is shown, moved or not."""
        if event.type == "TIMER" and self._reading is not None and self._reading.done():
            self._waiting.close()
            if self._at is not None and self._reading.exception() is None:
                show_direction(context, self._reading.result(), *self._at)
                redraw_panoramas(context.window_manager)
        return super().modal(context, event)

    def restore(self, context: bpy.types.Context) -> None:
        """Nothing was changed but what is shown."""
        context.window_manager.spectral_probe_panorama.has_spectrum = False

    def handle(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        """Show the spectrum under the mouse; take it on a click."""
        shown = context.window_manager.spectral_probe_panorama
        if event.type == "RIGHTMOUSE" and event.value == "PRESS":
            self.restore(context)
            return {"CANCELLED"}
        place = self.under(context, event)
        shown.following = place is not None
        shown.cursor_px = (event.mouse_x, event.mouse_y)
        if place is None or self._reading is None:
            return RUNNING
        azimuth_deg, elevation_deg = place[3]
        if not self._reading.done():
            self._at = (azimuth_deg, elevation_deg)
            wait(context, azimuth_deg, elevation_deg)
            return RUNNING
        panorama = self._reading.result()
        if event.type == "LEFTMOUSE" and event.value == "PRESS":
            self.azimuth, self.elevation = math.radians(azimuth_deg), math.radians(elevation_deg)
            return self.run(context)
        if event.type == "MOUSEMOVE":
            show_direction(context, panorama, azimuth_deg, elevation_deg)
        return RUNNING


def _read(path: Path) -> SpectralPanorama:
    """The panorama, and everything imported and computed once that its first spectrum needs."""
    from ..spectral_probe.spectrum_command import numbers_of, region_spectrum

    panorama = MEMORY.read(path).panorama
    if panorama.valid.any():
        first = panorama.valid & (panorama.valid.cumsum().reshape(panorama.valid.shape) == 1)
        numbers_of(region_spectrum(panorama, first))
    return panorama


def show_direction(
    context: bpy.types.Context, panorama: SpectralPanorama, azimuth_deg: float, elevation_deg: float
) -> DirectionSpectrum | None:
    """Compute the spectrum of a direction and keep it where overlay and panel find it; None where no view saw it."""
    from ..spectral_probe.spectrum_command import spectrum_at

    shown = context.window_manager.spectral_probe_panorama
    shown.has_spectrum, shown.problem = True, ""
    shown.azimuth, shown.elevation = math.radians(azimuth_deg), math.radians(elevation_deg)
    radius_deg = math.degrees(context.scene.spectral_probe.spectrum.radius)
    try:
        found = spectrum_at(panorama, azimuth_deg, elevation_deg, radius_deg)
    except SpectralProbeError:
        shown.problem, shown.kinds = rpt_("No view saw this direction unclipped"), ""
        shown.points.clear()
        return None
    shown.confidence = found.confidence
    kinds = sorted((found.families or {}).items(), key=lambda kind: -kind[1])[:_KINDS_SHOWN]
    shown.kinds = "\n".join(f"{name} {chance:.0%}" for name, chance in kinds if chance >= 0.005)
    lower, upper = found.band_95
    while len(shown.points) < len(found.spectrum):
        shown.points.add()
    while len(shown.points) > len(found.spectrum):
        shown.points.remove(len(shown.points) - 1)
    columns = {
        "wavelength_nm": found.wavelengths_nm,
        "radiance": found.spectrum,
        "lower": lower,
        "upper": upper,
    }
    for name, values in columns.items():
        shown.points.foreach_set(name, values.astype("float32"))
    return found


def numbers_beside(settings: bpy.types.PropertyGroup, found: DirectionSpectrum) -> dict[str, Any]:
    """The numbers of a spectrum, and how well it fits the measured one of the settings."""
    from ..spectral_probe.files.spectrum_csv import read_spectrum_csv
    from ..spectral_probe.spectra.curves import LIGHT
    from ..spectral_probe.spectrum_command import numbers_of

    measured = path_of(settings.spectrum.measured)
    known = None if measured is None else read_spectrum_csv(measured, quantity=LIGHT)[0]
    return numbers_of(found, known)


def wait(context: bpy.types.Context, azimuth_deg: float, elevation_deg: float) -> None:
    """Say that the probe is being read."""
    shown = context.window_manager.spectral_probe_panorama
    shown.has_spectrum, shown.problem = True, rpt_("Reading the probe")
    shown.azimuth, shown.elevation = math.radians(azimuth_deg), math.radians(elevation_deg)
    shown.points.clear()

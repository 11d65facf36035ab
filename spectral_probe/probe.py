"""The paper's pipeline from photographs to a spectral panorama, stage by stage."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from .composite.probe_views import MATCHING_KEY, ProbeView, probe_view, view_table
from .composition import compose
from .errors import CaptureError
from .files.atomic import written_together
from .files.probe_exr import write_layers, write_probe, write_world
from .files.spectral_exr import write_spectral_panorama
from .filters import FilterSets, filter_sets
from .geometry.frames import camera_to_world
from .geometry.outline import FoundBall
from .geometry.panorama import WIDTHS, natural_width
from .geometry.registration import PlacedView, ViewRegistration, register_with_partners, small_panorama
from .geometry.sampling import sampling
from .geometry.stitch import doubts
from .known_light import Calibration, calibrated, calibration_note, check_calibration, patch_of
from .light import recover_light
from .model import Capture, FloatArray, Job, Photograph, Progress, SpectralPanorama, part
from .recoveries import Recoveries, recoveries_of
from .render.layers import colour_error, light_layers
from .render_model import LightLayers
from .report import probe_report
from .spectra.camera import REC709, camera_sensitivities
from .spectra.incidence import IncidenceCorrection, incidence_cosines
from .spectra.metals import ball_reflectance
from .view import MeasuredView, measure_view

type ViewSeen = Callable[[int, Sequence[Photograph], FoundBall], None]
"""Told of a view's number (from 0), its photographs and the ball in them, while they are in memory."""

_WORLD_COMMENT = "Scene-linear Rec.709, D65 white; Blender's equirectangular"


@dataclass(frozen=True)
class Probe:
    """A recovered light probe: the spectral panorama, the report of how it was made, and what photographs are matched by."""

    panorama: SpectralPanorama
    report: Mapping[str, Any]
    views: tuple[ProbeView, ...] = ()


@dataclass
class _Stopwatch:
    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start


def build_probe(capture: Capture, width: int | None = None, seen: ViewSeen | None = None) -> Job[Probe]:
    """Recover the spectral panorama of a capture.

    Parameters
    ----------
    capture
        What was photographed, and how.
    width
        Width of the panorama in pixels, even; the height is half of it. None: as fine as the photographs where they sample
        most densely.
    seen
        Called with the number of each view (from 0), its photographs and the ball found in them: whoever shows them need not
        read and search again.

    Yields
    ------
    Progress

    Returns
    -------
    Probe

    Raises
    ------
    SpectralProbeError
        If anything about the capture cannot be used; the message says what to do.
    """
    if width is not None and (width % 2 or not WIDTHS[0] <= width <= WIDTHS[1]):
        raise CaptureError(
            f"A panorama's width must be an even number from {WIDTHS[0]} to {WIDTHS[1]}, not {width}."
        )
    if not capture.views:
        raise CaptureError("The capture has no view. Add a view with its photos.")
    watch = _Stopwatch()
    yield Progress(0.0, "Preparing the spectral basis")
    with watch.stage("spectra"):  # before any photograph is read: wrong names must fail at once
        check_calibration(capture)
        filters = filter_sets(capture.views)
        camera = _sensitivities(capture, converted=False)
        recoveries = recoveries_of(capture, filters.sensitivities(camera))
        reflectances = ball_reflectance(capture.ball.material, incidence_cosines())
    measured = yield from part(_measured(capture, filters, watch, seen), 0.02, 0.52)
    yield Progress(0.52, "Registering the views" if len(filters.leaders) > 1 else "Measuring the sampling")
    placed = [_placed(view) for view in measured]
    with watch.stage("registration"):
        registration, doubt = _registered(placed, filters)
    with watch.stage("spectra"):
        converted = measured[0].converted
        camera = _sensitivities(capture, converted=True) if converted else camera
        calibration = calibrated(capture, measured, placed, registration.views, camera)
        if calibration is not None:
            camera = camera / calibration.gains
        if converted or calibration is not None:
            recoveries = recoveries_of(capture, filters.sensitivities(camera))
    if width is None:
        width = natural_width([sampling(view.camera, view.ball, view.rotation) for view in placed])
    with watch.stage("panorama"):
        corrections = _corrections(reflectances, recoveries, calibration)
        composing = compose(
            placed, registration, doubt, corrections, width, capture.composition, filters.group
        )
        responses = yield from part(composing, 0.6, 0.85)
    with watch.stage("light"):
        provenance = {**_provenance(capture), **calibration_note(calibration)}
        recovering = recover_light(responses, recoveries.lights(responses), provenance)
        panorama = yield from part(recovering, 0.85, 0.95)
    yield Progress(0.95, "Writing the report")
    report = probe_report(
        capture, measured, registration, responses, panorama, recoveries, watch.seconds, calibration
    )
    views = tuple(
        probe_view(capture, *each, calibration) for each in zip(measured, registration.views, strict=True)
    )
    return Probe(panorama, report, views)


def _sensitivities(capture: Capture, *, converted: bool) -> FloatArray:
    """Of the camera, (61, 3); converted pictures (JPEG) are Rec.709, whatever camera took them."""
    if converted:
        return camera_sensitivities(REC709)
    return camera_sensitivities(capture.camera.model, capture.camera.sensitivities)


def _measured(
    capture: Capture, filters: FilterSets, watch: _Stopwatch, seen: ViewSeen | None
) -> Job[list[MeasuredView]]:
    """Every view of a capture, those without a filter first, which the others may take the ball's place from."""
    found: dict[int, MeasuredView] = {}
    order = sorted(range(len(capture.views)), key=lambda number: filters.group[number] > 0)
    for done, number in enumerate(order):
        label = f"View {number + 1} of {len(capture.views)}"
        yield Progress(done / len(order), f"{label}: reading the photographs and finding the ball")
        with watch.stage("photographs"):
            found[number] = measure_view(
                capture,
                capture.views[number],
                patch_of(capture.calibration, number),
                found.get(filters.partner[number]),
                None if seen is None else partial(seen, number),
            )
    if len({view.converted for view in found.values()}) > 1:
        raise CaptureError("Some views are raw and some converted photographs (JPEG). Use one kind.")
    return [found[number] for number in range(len(capture.views))]


def _registered(views: Sequence[PlacedView], filters: FilterSets) -> tuple[ViewRegistration, FloatArray]:
    """The views as registered, and (V, h, w) how little each is to be believed; those through a filter as their partners."""
    leaders = list(filters.leaders)
    small = [small_panorama(views[number]) for number in leaders] if len(leaders) > 1 else []
    registration = register_with_partners(views, filters.partner, small)
    doubt = np.zeros((1, 2, 4), np.float32)
    if small:
        leading = [registration.views[number] for number in leaders]
        doubt = doubts(
            small, np.stack([one.turn for one in leading]), np.stack([one.gain for one in leading])
        )
    return registration, doubt[[leaders.index(partner) for partner in filters.partner]]


def _corrections(
    reflectances: FloatArray, recoveries: Recoveries, calibration: Calibration | None
) -> list[IncidenceCorrection]:
    """How the ball is divided out of the responses without a filter, and through each."""
    if calibration is not None and calibration.ball is not None:
        reflectances = calibration.ball.applied(reflectances)
    channels = recoveries.whole.sensitivities.shape[1]
    return [
        recoveries.whole.incidence_correction(reflectances, slice(first, first + 3))
        for first in range(0, channels, 3)
    ]


def _placed(view: MeasuredView) -> PlacedView:
    settings = view.settings
    rotation = camera_to_world(settings.azimuth_deg, settings.elevation_deg, settings.roll_deg)
    return PlacedView(view.image, view.camera, view.ball, rotation, settings.refine)


def write_outputs(probe: Probe, directory: Path) -> Job[LightLayers]:
    """Write probe.exr, spectral.exr, layers.exr, world.exr, preview.png, confidence.png and report.json into a folder.

    They take their places together at the end, the report last: a job that is stopped leaves an earlier probe as it was. Hold the
    folder's lock (`files.lock.folder_lock`).
    """
    from .figures.confidence import confidence_preview
    from .figures.panorama import panorama_preview, write_png

    directory = Path(directory)
    start = time.perf_counter()
    layers = light_layers(probe.panorama)  # refuses a panorama without light before anything is made
    with written_together(directory, last="report.json") as folder:
        yield Progress(0.0, "Writing probe.exr")
        write_probe(folder / "probe.exr", probe.panorama)
        yield Progress(0.1, "Writing layers.exr")
        write_layers(folder / "layers.exr", layers)
        yield Progress(0.2, "Writing world.exr")
        write_world(folder / "world.exr", probe.panorama, {"comment": _WORLD_COMMENT})
        yield Progress(0.3, "Writing preview.png")
        write_png(folder / "preview.png", panorama_preview(probe.panorama))
        write_png(folder / "confidence.png", confidence_preview(probe.panorama))
        yield Progress(0.4, "Writing spectral.exr")
        write_spectral_panorama(folder / "spectral.exr", probe.panorama)
        seconds = {**probe.report["seconds"], "writing": round(time.perf_counter() - start, 3)}
        report = {
            **probe.report,
            **_views_to_match(probe, directory),
            "layers_residual": layers.residual,
            "layers_de2000": colour_error(probe.panorama, layers),
            "seconds": seconds,
        }
        (folder / "report.json").write_text(json.dumps(report, indent=1), encoding="utf-8")
    return layers


def _views_to_match(probe: Probe, directory: Path) -> dict[str, Any]:
    """The report's views with what later photographs are matched by, paths relative to the probe's folder."""
    if not probe.views:
        return {}
    tables = [{MATCHING_KEY: view_table(view, directory)} for view in probe.views]
    return {"views": [row | table for row, table in zip(probe.report["views"], tables, strict=True)]}


def _provenance(capture: Capture) -> dict[str, str]:
    camera = (
        capture.camera.sensitivities.name
        if capture.camera.sensitivities
        else capture.camera.model or "Rec.709"
    )
    material = capture.ball.material
    return {
        "camera": camera,
        "ball": material
        if isinstance(material, str)
        else ", ".join(f"{metal} {share:g}" for metal, share in material.items()),
        "families": ", ".join(capture.families),
        "method": capture.method,
        "views": str(len(capture.views)),
        "photographs": ", ".join(photo.name for view in capture.views for photo in view.photos),
    }

"""The paper's pipeline from photographs to a spectral panorama, stage by stage."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from .composition import compose
from .errors import CaptureError
from .files.image_exr import write_rgb
from .files.probe_exr import write_layers, write_probe
from .files.spectral_exr import write_spectral_panorama
from .geometry.frames import camera_to_world
from .geometry.panorama import WIDTHS, natural_width
from .geometry.registration import PlacedView, register_views, small_panorama
from .geometry.sampling import sampling
from .geometry.stitch import doubts
from .light import LightOf, recover_light
from .model import Capture, Job, LightLayers, Progress, SpectralPanorama, part
from .render.layers import light_layers
from .report import probe_report
from .spectra.camera import REC709, camera_sensitivities
from .spectra.colorimetry import panorama_xyz, xyz_to_rec709
from .spectra.incidence import incidence_cosines
from .spectra.metals import ball_reflectance
from .spectra.recovery import SpectralRecovery, spectral_recovery
from .view import MeasuredView, measure_view

_WORLD_COMMENT = "Scene-linear Rec.709, D65 white; Blender's equirectangular"


@dataclass(frozen=True)
class Probe:
    """A recovered light probe: the spectral panorama and the report of how it was made."""

    panorama: SpectralPanorama
    report: Mapping[str, Any]


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


def build_probe(capture: Capture, width: int | None = None) -> Job[Probe]:
    """Recover the spectral panorama of a capture.

    Parameters
    ----------
    capture
        What was photographed, and how.
    width
        Width of the panorama in pixels, even; the height is half of it. None: as fine as the photographs where they sample
        most densely.

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
        recovery = _recovery(capture, converted=False)
    measured: list[MeasuredView] = []
    for number, settings in enumerate(capture.views, start=1):
        share, label = (number - 1) / len(capture.views), f"View {number} of {len(capture.views)}"
        yield Progress(0.02 + 0.5 * share, f"{label}: reading the photographs and finding the ball")
        with watch.stage("photographs"):
            measured.append(measure_view(capture, settings))
    if len({view.converted for view in measured}) > 1:
        raise CaptureError("Some views are raw and some converted photographs (JPEG). Use one kind.")
    if measured[0].converted:
        with watch.stage("spectra"):
            recovery = _recovery(capture, converted=True)
    yield Progress(0.52, "Registering the views" if len(measured) > 1 else "Measuring the sampling")
    placed = [_placed(view) for view in measured]
    with watch.stage("registration"):
        small = [small_panorama(view) for view in placed] if len(placed) > 1 else []
        registration = register_views(placed, small)
        doubt = np.zeros((1, 2, 4), np.float32)
        if small:
            turns = np.stack([view.turn for view in registration.views])
            doubt = doubts(small, turns, np.stack([view.gain for view in registration.views]))
        del small
    if width is None:
        width = natural_width([sampling(view.camera, view.ball, view.rotation) for view in placed])
    with watch.stage("panorama"):
        correction = recovery.incidence_correction(
            ball_reflectance(capture.ball.material, incidence_cosines())
        )
        composing = compose(placed, registration, doubt, [correction], width, capture.composition)
        responses = yield from part(composing, 0.6, 0.85)
    with watch.stage("light"):
        recovering = recover_light(responses, [LightOf(recovery)], _provenance(capture))
        panorama = yield from part(recovering, 0.85, 0.95)
    yield Progress(0.95, "Writing the report")
    report = probe_report(capture, measured, registration, responses, panorama, watch.seconds)
    return Probe(panorama, report)


def _recovery(capture: Capture, *, converted: bool) -> SpectralRecovery:
    """How responses become spectra; converted pictures (JPEG) are Rec.709, whatever camera took them."""
    sensitivities = (
        camera_sensitivities(REC709)
        if converted
        else camera_sensitivities(capture.camera.model, capture.camera.sensitivities)
    )
    return spectral_recovery(sensitivities, capture.families, capture.method)


def _placed(view: MeasuredView) -> PlacedView:
    settings = view.settings
    rotation = camera_to_world(settings.azimuth_deg, settings.elevation_deg, settings.roll_deg)
    return PlacedView(view.image, view.camera, view.ball, rotation, settings.refine)


def write_outputs(probe: Probe, directory: Path) -> Job[LightLayers]:
    """Write probe.exr, spectral.exr, layers.exr, world.exr, preview.png and report.json into a folder.

    They take their places together at the end, the report last: a job that is stopped leaves an earlier probe as it was.
    """
    from .figures.panorama import panorama_preview, write_png

    directory = Path(directory)
    start = time.perf_counter()
    layers = light_layers(probe.panorama)  # refuses a panorama without light before anything is made
    directory.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory(prefix=".writing-", dir=directory) as name:
        folder = Path(name)
        yield Progress(0.0, "Writing probe.exr")
        write_probe(folder / "probe.exr", probe.panorama)
        yield Progress(0.1, "Writing layers.exr")
        write_layers(folder / "layers.exr", layers)
        yield Progress(0.2, "Writing world.exr")
        world = np.maximum(xyz_to_rec709(panorama_xyz(probe.panorama)), 0.0)
        write_rgb(folder / "world.exr", world, header={"comment": _WORLD_COMMENT})
        yield Progress(0.3, "Writing preview.png")
        write_png(folder / "preview.png", panorama_preview(probe.panorama))
        yield Progress(0.4, "Writing spectral.exr")
        write_spectral_panorama(folder / "spectral.exr", probe.panorama)
        seconds = {**probe.report["seconds"], "writing": round(time.perf_counter() - start, 3)}
        report = {**probe.report, "layers_residual": layers.residual, "seconds": seconds}
        (folder / "report.json").write_text(json.dumps(report, indent=1), encoding="utf-8")
        for file in sorted(folder.iterdir(), key=lambda file: file.name == "report.json"):
            file.replace(directory / file.name)
    return layers


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

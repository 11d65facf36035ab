"""The paper's pipeline from photographs to a spectral panorama, stage by stage."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from .errors import CaptureError
from .files.image_exr import write_rgb
from .files.probe_exr import write_layers, write_probe
from .files.spectral_exr import write_spectral_panorama
from .geometry.ball import fit_ball
from .geometry.camera import camera_for
from .geometry.frames import camera_to_world, panorama_solid_angles
from .geometry.outline import check_in_frame, find_ball, outline_from_circle
from .geometry.panorama import ViewPanorama, view_panorama
from .geometry.stitch import fill_unseen, view_weights
from .model import (
    BallFit,
    BoolArray,
    Camera,
    Capture,
    Job,
    LightLayers,
    Outline,
    Photograph,
    Progress,
    RadianceImage,
    SpectralPanorama,
    ViewSettings,
)
from .photo.align import align
from .photo.exposure import resolve_exposures
from .photo.merge import merge
from .photo.read import read_photograph
from .render.layers import light_layers
from .spectra.camera import REC709, camera_names, camera_sensitivities
from .spectra.colorimetry import panorama_xyz, xyz_to_rec709
from .spectra.grid import WAVELENGTHS_NM
from .spectra.recovery import SpectralRecovery, spectral_recovery

DEFAULT_WIDTH = 2048
_WORLD_COMMENT = "Scene-linear Rec.709, D65 white; Blender's equirectangular"
_WIDTHS = (64, 16384)


@dataclass(frozen=True)
class MeasuredView:
    """One view of the ball: its radiance image and geometry; `converted` where a tone curve had been applied (JPEG)."""

    settings: ViewSettings
    image: RadianceImage
    camera: Camera
    outline: Outline
    ball: BallFit
    converted: bool = False

    @property
    def clipped_fraction(self) -> float:
        """Share of the ball's pixels that are clipped in every photograph."""
        height, width = self.image.valid.shape
        rows, columns = np.mgrid[:height, :width] + 0.5
        x, y = columns - self.outline.centre_px[0], rows - self.outline.centre_px[1]
        on_ball = np.hypot(x, y) < min(self.outline.semi_axes_px)
        return float(1.0 - self.image.valid[on_ball].mean())


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


def build_probe(capture: Capture, width: int = DEFAULT_WIDTH) -> Job[Probe]:
    """Recover the spectral panorama of a capture.

    Parameters
    ----------
    capture
        What was photographed, and how.
    width
        Width of the panorama in pixels, even; the height is half of it.

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
    if width % 2 or not _WIDTHS[0] <= width <= _WIDTHS[1]:
        raise CaptureError(
            f"A panorama's width must be an even number from {_WIDTHS[0]} to {_WIDTHS[1]}, not {width}."
        )
    if not capture.views:
        raise CaptureError("The capture has no view. Add a view with its photos.")
    watch = _Stopwatch()
    yield Progress(0.0, "Preparing the spectral basis")
    with watch.stage("spectra"):  # before any photograph is read: wrong names must fail at once
        sensitivities = camera_sensitivities(capture.camera.model, capture.camera.sensitivities)
        recovery = spectral_recovery(sensitivities, capture.ball.material, capture.families, capture.method)
    measured: list[MeasuredView] = []
    seen: list[ViewPanorama] = []
    for number, settings in enumerate(capture.views, start=1):
        share, label = (number - 1) / len(capture.views), f"View {number} of {len(capture.views)}"
        yield Progress(0.02 + 0.68 * share, f"{label}: reading the photographs and finding the ball")
        with watch.stage("photographs"):
            view = measure_view(capture, settings)
        yield Progress(0.02 + 0.68 * (share + 0.7 / len(capture.views)), f"{label}: unwrapping the ball")
        with watch.stage("panorama"):
            rotation = camera_to_world(settings.azimuth_deg, settings.elevation_deg, settings.roll_deg)
            seen.append(view_panorama(view.image, view.camera, view.ball, rotation, width))
        measured.append(view)
    yield Progress(0.72, "Recovering spectra")
    with watch.stage("spectra"):
        if len({view.converted for view in measured}) > 1:
            raise CaptureError("Some views are raw and some converted photographs (JPEG). Use one kind.")
        if measured[0].converted:
            recovery = spectral_recovery(
                camera_sensitivities(REC709), capture.ball.material, capture.families, capture.method
            )
        panorama = compose(seen, recovery, _provenance(capture))
    yield Progress(0.95, "Writing the report")
    return Probe(panorama, _report(capture, measured, panorama, watch.seconds))


def _check_kind(capture: Capture, photographs: Sequence[Photograph]) -> bool:
    """Whether the photographs went through a tone curve; refuses raw of an unnamed camera, and mixtures.

    A camera's own curves apply to raw only: pictures a camera or a program converted are linear Rec.709 once their
    tone curve is undone.
    """
    kinds = {photograph.display_referred for photograph in photographs}
    if len(kinds) > 1:
        raise CaptureError("A view mixes raw and converted photographs (JPEG). Use one kind.")
    if photographs[0].camera_raw and capture.camera.model is None and capture.camera.sensitivities is None:
        raise CaptureError(
            f"{photographs[0].path.name} is camera raw, so its camera must be known. Add to [camera] a model "
            f'({", ".join(camera_names()[:-1])}) or sensitivities = "camera.csv".'
        )
    return kinds.pop()


def measure_view(capture: Capture, settings: ViewSettings) -> MeasuredView:
    """Read one view's bracket, find the ball in it, and merge it to radiance."""
    photographs = [read_photograph(path) for path in settings.photos]
    converted = _check_kind(capture, photographs)
    exposures = resolve_exposures(photographs, settings)
    height, width = photographs[0].pixels.shape[:2]
    camera = camera_for(capture.camera, photographs[0])
    outlines: Sequence[Outline]
    if settings.outline is not None:
        outline = outline_from_circle(*settings.outline)
        check_in_frame(outline, (width, height), given=True)
        outlines = [outline] * len(photographs)
    else:
        outlines = find_ball(photographs, camera, settings.ball_at).outlines
    image = merge(align(photographs, outlines), exposures)
    ball = fit_ball(camera, outlines[0], capture.ball.radius_m)
    return MeasuredView(settings, image, camera, outlines[0], ball, converted)


def compose(
    views: Sequence[ViewPanorama], recovery: SpectralRecovery, provenance: Mapping[str, str]
) -> SpectralPanorama:
    """Recover every view's weights (eq. 10) and put the views together into one panorama."""
    shares = view_weights(views)
    height, width = shares.shape[1:]
    weights = np.zeros((height, width, recovery.basis.shape[0]), np.float32)
    confidence = np.zeros((height, width), np.float32)
    for view, share in zip(views, shares, strict=True):
        own = recovery.weights(view.responses, view.cos_incidence)
        weights += share[..., None] * own
        confidence += share * recovery.confidence(own, view.variance, view.cos_incidence)
    valid: BoolArray = np.any([view.valid for view in views], axis=0)
    known: BoolArray = shares.sum(0) > 0.5
    return SpectralPanorama(
        weights=fill_unseen(recovery.non_negative(weights), known),
        bases=recovery.basis[None].copy(),
        basis_index=np.zeros((height, width), np.uint8),
        wavelengths_nm=WAVELENGTHS_NM,
        valid=valid,
        confidence=np.where(valid, confidence, 0.0).astype(np.float32),
        provenance=provenance,
    )


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


def _report(
    capture: Capture, views: Sequence[MeasuredView], panorama: SpectralPanorama, seconds: Mapping[str, float]
) -> dict[str, Any]:
    height, width = panorama.valid.shape
    solid_angles = np.broadcast_to(panorama_solid_angles(height, width), (height, width))
    return {
        "views": [
            {
                "photos": [photo.name for photo in view.settings.photos],
                "centre_px": list(view.outline.centre_px),
                "radius_px": list(view.outline.semi_axes_px),
                "outline_rms_px": view.outline.rms_px,
                "outline_given": view.settings.outline is not None,
                "cone_angle_deg": float(np.degrees(view.ball.cone_angle_rad)),
                "distance_m": view.ball.distance_m,
                "focal_px": list(view.camera.focal_px),
                "focal_source": view.camera.source,
                "azimuth_deg": view.settings.azimuth_deg,
                "elevation_deg": view.settings.elevation_deg,
                "clipped_fraction": view.clipped_fraction,
            }
            for view in views
        ],
        "blind_fraction": float(solid_angles[~panorama.valid].sum() / (4 * np.pi)),
        "camera_curves": _curves_used(capture, views),
        "warnings": _warnings(views),
        "negative_fraction": _negative_fraction(panorama),
        "median_confidence": float(np.median(panorama.confidence[panorama.valid]))
        if panorama.valid.any()
        else 0.0,
        "width": width,
        "families": list(capture.families),
        "method": capture.method,
        "seconds": {stage: round(value, 3) for stage, value in seconds.items()},
    }


def _curves_used(capture: Capture, views: Sequence[MeasuredView]) -> str:
    if all(view.converted for view in views):
        return REC709
    return (
        capture.camera.sensitivities.name if capture.camera.sensitivities else capture.camera.model or REC709
    )


def _warnings(views: Sequence[MeasuredView]) -> list[str]:
    """What the user should know about how far the result can be trusted."""
    told = []
    if all(view.converted for view in views):
        told.append(
            "The photographs are converted pictures (JPEG): sRGB's tone curve and Rec.709's colours were assumed. Use raw."
        )
    if any(view.settings.refine for view in views) and len(views) > 1:
        told.append("Azimuths are used as given; registration of the views does not refine them yet.")
    return told


def _negative_fraction(panorama: SpectralPanorama) -> float:
    """Share of spectral samples below zero (only the paper's method leaves any)."""
    basis = panorama.bases[0].astype(np.float32)
    count: int = sum(int(((panorama.weights @ column) < 0).sum()) for column in basis.T)
    return float(count / (panorama.valid.size * basis.shape[-1]))

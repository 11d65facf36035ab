"""Between the settings of a scene and the `Capture` that the core works with."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import Path

import bpy

from ..preferences import library_folder
from ..spectral_probe.errors import CaptureError
from ..spectral_probe.files.atomic import check_folder
from ..spectral_probe.model import BallSettings, CameraSettings, Capture, ViewSettings
from .bridge import packed_probe
from .bridge.packed_probe import EDITS, PROBE
from .settings_light import (
    calibration_from,
    families_from,
    fill_families,
    fill_known_light,
    filter_from,
    own_lights_from,
    regions_from,
)
from .typed import decimal, degrees, path_of, path_text

_FRACTION = re.compile(r"\s*([A-Z][a-z]?)\s*[\s=:]\s*([0-9]*\.?[0-9]+)\s*")


def folder_of(text: str, name: str) -> Path:
    """Absolute path of a folder that something is written to.

    Raises
    ------
    CaptureError
        If it is relative to a .blend that was never saved, or empty.
    FileFormatError
        If nothing may be written there.
    """
    if not text or (text.startswith("//") and not bpy.data.filepath):
        raise CaptureError(f"Save the .blend first, or choose a {name} folder that is not relative to it.")
    folder = Path(bpy.path.abspath(text))
    check_folder(folder)
    return folder


def built_folder(settings: bpy.types.PropertyGroup) -> Path:
    """Folder of the probe's files as it was built: its own, or that of this session where only the packed copy is there."""
    folder = Path(bpy.path.abspath(settings.probe_directory))
    if not (settings.packed.files and settings.probe_directory):
        return folder
    temporary = packed_probe.temporary_folder(settings)
    needed = Path(EDITS, settings.edits.state, PROBE) if _is_edited(settings) else Path(PROBE)
    return temporary if not (folder / needed).is_file() and (temporary / needed).is_file() else folder


def probe_folder(settings: bpy.types.PropertyGroup) -> Path:
    """Folder of the probe's files that light the scene: as built, or edited where there are glasses and lamps."""
    folder = built_folder(settings)
    return folder / EDITS / settings.edits.state if _is_edited(settings) else folder


def _is_edited(settings: bpy.types.PropertyGroup) -> bool:
    edits = settings.edits
    return bool(edits.state and edits.probe_directory == settings.probe_directory)


def capture_from(settings: bpy.types.PropertyGroup) -> Capture:
    """The capture that the settings of a scene describe.

    Raises
    ------
    CaptureError
        If there is no view, or a view is incomplete.
    """
    if not settings.views:
        raise CaptureError("There is no view. Import a capture file or add the photographs of a view.")
    scale = settings.id_data.unit_settings.scale_length
    return Capture(
        views=tuple(_view_from(view, number) for number, view in enumerate(settings.views, 1)),
        camera=_camera_from(settings.camera),
        ball=BallSettings(decimal(settings.ball_radius * scale), material_from(settings.ball_material)),
        families=families_from(settings),
        method=settings.method,
        composition=settings.composition,
        spectra=own_lights_from(settings.known_light),
        regions=regions_from(settings.known_light),
        calibration=calibration_from(settings.known_light),
    )


def fill(settings: bpy.types.PropertyGroup, capture: Capture, path: Path) -> None:
    """Put a capture into the settings of a scene; what an earlier capture gave is cleared."""
    settings.capture_path = path_text(path)
    _fill_camera(settings.camera, capture.camera)
    settings.ball_radius = capture.ball.radius_m / settings.id_data.unit_settings.scale_length
    settings.ball_material = material_text(capture.ball.material)
    fill_families(settings, capture.families)
    fill_known_light(settings, capture)
    settings.method = capture.method
    settings.composition = capture.composition
    settings.views.clear()
    settings.active_view = 0
    for result in ("probe", "edits", "render", "comparison"):
        settings.property_unset(result)
    if not bpy.data.filepath:  # nothing to be relative to yet: beside the capture, then
        settings.probe_directory = str(path.parent / "probe")
        settings.render_directory = str(path.parent / "render")
    for view in capture.views:
        _fill_view(settings.views.add(), view)


def add_photos(view: bpy.types.PropertyGroup, paths: list[Path]) -> None:
    """Append photographs to a view, which is named after the first."""
    for path in paths:
        view.photos.add().path = path_text(path)
    if not view.name and paths:
        view.name = paths[0].stem


def material_from(text: str) -> str | Mapping[str, float]:
    """A ball material: "Fe 0.74, Cr 0.18" as fractions of metals, a file's name as its path, anything else as a name."""
    from ..spectral_probe.files.spectrum_file import is_spectrum_file

    if is_spectrum_file(text.strip()):
        return bpy.path.abspath(text.strip())
    parts = [_FRACTION.fullmatch(part) for part in text.split(",")]
    if all(parts):
        return {part[1]: float(part[2]) for part in parts if part}
    return text.strip()


def material_text(material: str | Mapping[str, float]) -> str:
    """The inverse of `material_from`."""
    if isinstance(material, str):
        return material
    return ", ".join(f"{metal} {fraction:g}" for metal, fraction in material.items())


def _view_from(view: bpy.types.PropertyGroup, number: int) -> ViewSettings:
    photos = tuple(path for photo in view.photos if (path := path_of(photo.path)) is not None)
    if not photos or len(photos) < len(view.photos):
        raise CaptureError(f'View {number} ("{view.name}") lacks a photograph. Add it, or remove the view.')
    return ViewSettings(
        photos=photos,
        azimuth_deg=degrees(view.azimuth),
        elevation_deg=degrees(view.elevation),
        roll_deg=degrees(view.roll),
        refine=view.refine,
        exposures_s=_all_or_none([photo.exposure_s for photo in view.photos], "exposure time", number),
        iso=_all_or_none([photo.iso for photo in view.photos], "ISO speed", number),
        f_number=_all_or_none([photo.f_number for photo in view.photos], "f-number", number),
        outline=_given_outline(view, number),
        ball_at=_pair(view.ball_at_px) if view.has_ball_at else None,
        solve_exposures=view.solve_exposures,
        filter=filter_from(view.filter),
        snap_outline=view.outline_source == "SNAP",
    )


def _all_or_none(values: list[float], what: str, number: int) -> tuple[float, ...] | None:
    if not any(values):
        return None
    if not all(values):
        raise CaptureError(
            f"View {number} gives the {what} of some photographs. Give it for all, or for none (EXIF)."
        )
    return tuple(decimal(value) for value in values)


def _given_outline(view: bpy.types.PropertyGroup, number: int) -> tuple[float, ...] | None:
    if view.outline_source == "AUTOMATIC":
        return None
    x_px, y_px, radius_px = (decimal(value) for value in view.outline_px)
    if radius_px <= 0:
        raise CaptureError(
            f"The circle of view {number} has no radius. Give it, or set the outline to Automatic."
        )
    if view.outline_source == "GIVEN" and view.outline_minor_px > 0:
        return (x_px, y_px, radius_px, decimal(view.outline_minor_px), degrees(view.outline_angle))
    return (x_px, y_px, radius_px)


def _camera_from(camera: bpy.types.PropertyGroup) -> CameraSettings:
    source = camera.focal_source
    if source == "PX" and not all(camera.focal_px):
        raise CaptureError("The focal length in pixels is 0. Give it, or take it from the photographs.")
    return CameraSettings(
        model=camera.model or None,
        sensitivities=path_of(camera.sensitivities) or _own_camera(camera.model),
        focal_px=_pair(camera.focal_px) if source == "PX" else None,
        focal_mm=decimal(camera.focal_mm) if source == "MM" else None,
        sensor_width_mm=decimal(camera.sensor_width_mm) or None if source in {"EXIF", "MM"} else None,
        calibration=path_of(camera.calibration) if source == "CALIBRATION" else None,
        principal_px=_pair(camera.principal_px) if camera.has_principal else None,
        distortion=tuple(
            decimal(value) for value in camera.distortion[: 8 if any(camera.distortion[5:]) else 5]
        ),
        half_size=camera.half_size,
    )


def _own_camera(model: str) -> Path | None:
    """The file of a camera of the user's library folder; None for every other camera."""
    folder = library_folder()
    if folder is None or not model:
        return None
    from ..spectral_probe.spectra.camera import cameras_in

    return cameras_in(folder).get(model)


def _fill_camera(camera: bpy.types.PropertyGroup, given: CameraSettings) -> None:
    camera.model = given.model or ""
    camera.sensitivities = path_text(given.sensitivities) if given.sensitivities else ""
    camera.calibration = path_text(given.calibration) if given.calibration else ""
    camera.focal_px = given.focal_px or (0.0, 0.0)
    camera.half_size = given.half_size
    camera.sensor_width_mm = given.sensor_width_mm or 0.0
    if given.focal_mm:
        camera.focal_mm = given.focal_mm
    if given.calibration:
        camera.focal_source = "CALIBRATION"
    elif given.focal_px:
        camera.focal_source = "PX"
    else:
        camera.focal_source = "MM" if given.focal_mm else "EXIF"
    camera.has_principal = given.principal_px is not None
    camera.principal_px = given.principal_px or (0.0, 0.0)
    camera.distortion = (*given.distortion, *(0.0,) * 8)[:8]


def _fill_view(view: bpy.types.PropertyGroup, given: ViewSettings) -> None:
    add_photos(view, list(given.photos))
    for name, values in (("exposure_s", given.exposures_s), ("iso", given.iso), ("f_number", given.f_number)):
        for photo, value in zip(view.photos, values or (), strict=False):
            setattr(photo, name, value)
    view.azimuth = math.radians(given.azimuth_deg)
    view.elevation = math.radians(given.elevation_deg)
    view.roll = math.radians(given.roll_deg)
    view.refine = given.refine
    view.solve_exposures = given.solve_exposures
    view.filter = str(given.filter or "")
    view.has_ball_at = given.ball_at is not None
    view.ball_at_px = given.ball_at or (0.0, 0.0)
    if given.outline is not None:
        view.outline_source = "SNAP" if given.snap_outline else "GIVEN"
        view.outline_px = given.outline[:3]
        if len(given.outline) == 5:
            view.outline_minor_px, view.outline_angle = given.outline[3], math.radians(given.outline[4])


def _pair(values: bpy.types.bpy_prop_array) -> tuple[float, float]:
    return (decimal(values[0]), decimal(values[1]))

"""What a probe's report.json says of each view, so that a photograph can be matched to it later."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import FileFormatError
from ..files.json_object import UNREADABLE, read_object
from ..model import Camera, Capture, FloatArray

if TYPE_CHECKING:
    from ..geometry.registration import RegisteredView
    from ..known_light import Calibration
    from ..view import MeasuredView

REPORT_NAME = "report.json"
MATCHING_KEY = "matching"
"""In each view of report.json: what `ProbeView` holds."""


@dataclass(frozen=True)
class ProbeView:
    """One view of a probe: its photographs, the camera that took them, the ball in front of it.

    Parameters
    ----------
    photos
        The bracket's files.
    camera
        The pinhole camera of the whole picture, with its distortion.
    half_size
        Whether camera raw was developed at half its size; `camera` is then that of the half size.
    rotation
        (3, 3) camera to world, as registered.
    ball_centre_m, ball_radius_m
        The ball in the camera's coordinates (3,), in metres.
    outline_px
        Centre x, y and largest radius of the ball's outline in the first photograph, in pixels.
    shifts_px
        (E, 2) where the ball lies in each photograph from the first.
    exposures
        (E,) relative exposures used (`model.Exposure.relative`), one for each photograph.
    converted
        Whether the photographs went through a tone curve (JPEG).
    response_log_gain
        (3, K) measured response of converted pictures (`photo.response.ResponseCurve.log_gain`); None where none was measured.
    gain
        (3,) a photograph's linear pixels over its exposure are `gain` times what `camera_model`'s sensitivities make of the
        probe's spectra: registration and calibration gains undone.
    camera_model, sensitivities
        Name, and file, of the sensitivities that the probe was made with.
    """

    photos: tuple[Path, ...]
    camera: Camera
    half_size: bool
    rotation: FloatArray
    ball_centre_m: FloatArray
    ball_radius_m: float
    outline_px: tuple[float, float, float]
    shifts_px: FloatArray
    exposures: tuple[float, ...]
    converted: bool
    response_log_gain: FloatArray | None
    gain: FloatArray
    camera_model: str
    sensitivities: Path | None


def probe_view(
    capture: Capture, view: MeasuredView, registered: RegisteredView, calibration: Calibration | None
) -> ProbeView:
    """What is kept of a view that was measured and registered."""
    left, top = view.corner_px
    part = view.camera
    whole = replace(
        part, principal_px=(part.principal_px[0] + left, part.principal_px[1] + top), size_px=view.size_px
    )
    response = view.bracket.response
    gain = np.asarray(registered.gain, float) * (1.0 if calibration is None else calibration.gains)
    rec709 = view.converted or (capture.camera.model is None and capture.camera.sensitivities is None)
    return ProbeView(
        photos=view.settings.photos,
        camera=whole,
        half_size=capture.camera.half_size,
        rotation=registered.rotation,
        ball_centre_m=view.ball.centre_m,
        ball_radius_m=view.ball.radius_m,
        outline_px=(*view.outline.centre_px, max(view.outline.semi_axes_px)),
        shifts_px=np.asarray(view.shifts_px, float).reshape(-1, 2),
        exposures=tuple(exposure.relative for exposure in view.bracket.exposures),
        converted=view.converted,
        response_log_gain=None if response is None else response.log_gain,
        gain=1.0 / gain,
        camera_model="Rec.709" if rec709 else capture.camera.model or "",
        sensitivities=None if rec709 else capture.camera.sensitivities,
    )


def view_table(view: ProbeView, folder: Path) -> dict[str, Any]:
    """A view as JSON can hold it; paths are relative to `folder` where they can be."""
    return {
        "photos": [relative_path(photo, folder) for photo in view.photos],
        "camera": camera_table(view.camera),
        "half_size": view.half_size,
        "rotation": np.asarray(view.rotation, float).tolist(),
        "ball_centre_m": np.asarray(view.ball_centre_m, float).tolist(),
        "ball_radius_m": view.ball_radius_m,
        "outline_px": list(view.outline_px),
        "shifts_px": np.asarray(view.shifts_px, float).tolist(),
        "exposures": list(view.exposures),
        "converted": view.converted,
        "response_log_gain": None
        if view.response_log_gain is None
        else np.asarray(view.response_log_gain, float).tolist(),
        "gain": np.asarray(view.gain, float).tolist(),
        "camera_model": view.camera_model,
        "sensitivities": None if view.sensitivities is None else relative_path(view.sensitivities, folder),
    }


def read_probe_views(folder: Path) -> tuple[ProbeView, ...]:
    """The views of a probe, from the report in its folder.

    Parameters
    ----------
    folder
        The probe's folder, or its probe.exr.

    Raises
    ------
    FileFormatError
        If there is no report, or it was written by an earlier version and says nothing of the cameras.
    """
    folder = Path(folder)
    folder = folder.parent if folder.suffix.lower() == ".exr" else folder
    path = folder / REPORT_NAME
    if not path.is_file():
        raise FileFormatError(
            f"There is no {REPORT_NAME} in {folder}, which says where the camera stood. Give the folder of a probe."
        )
    try:
        rows = read_object(path)["views"]
        if not rows or any(MATCHING_KEY not in row for row in rows):
            raise ValueError("an earlier version's")
        return tuple(_view(row[MATCHING_KEY], folder.resolve()) for row in rows)
    except UNREADABLE:
        raise FileFormatError(
            f"{path} does not say which camera took the photographs. Build the probe again with the verb `probe`."
        ) from None


def _view(table: Mapping[str, Any], folder: Path) -> ProbeView:
    response, curves = table["response_log_gain"], table["sensitivities"]
    centre_x, centre_y, radius = table["outline_px"]
    return ProbeView(
        photos=tuple(absolute_path(photo, folder) for photo in table["photos"]),
        camera=camera_from_table(table["camera"]),
        half_size=bool(table["half_size"]),
        rotation=finite_array(table["rotation"], (3, 3)),
        ball_centre_m=finite_array(table["ball_centre_m"], (3,)),
        ball_radius_m=float(table["ball_radius_m"]),
        outline_px=(float(centre_x), float(centre_y), float(radius)),
        shifts_px=finite_array(table["shifts_px"], (len(table["photos"]), 2)),
        exposures=tuple(float(exposure) for exposure in table["exposures"]),
        converted=bool(table["converted"]),
        response_log_gain=None if response is None else finite_array(response, (3, len(response[0]))),
        gain=finite_array(table["gain"], (3,)),
        camera_model=str(table["camera_model"]),
        sensitivities=None if curves is None else absolute_path(curves, folder),
    )


# ---------------------------------------------------------------- shared with backplate.json


def camera_table(camera: Camera) -> dict[str, Any]:
    """A camera as JSON can hold it."""
    return {
        "focal_px": list(camera.focal_px),
        "principal_px": list(camera.principal_px),
        "size_px": list(camera.size_px),
        "distortion": list(camera.distortion),
        "source": camera.source,
    }


def camera_from_table(table: Mapping[str, Any]) -> Camera:
    """The camera that `camera_table` describes; KeyError, TypeError or ValueError where it describes none."""
    focal, principal = finite_array(table["focal_px"], (2,)), finite_array(table["principal_px"], (2,))
    width, height = table["size_px"]
    distortion = tuple(float(value) for value in table["distortion"])
    if len(distortion) not in (4, 5, 8) or not np.isfinite(distortion).all():
        raise ValueError("no distortion of OpenCV's")
    if focal.min() <= 0 or min(width, height) < 1:
        raise ValueError("not a camera")
    return Camera(
        (float(focal[0]), float(focal[1])),
        (float(principal[0]), float(principal[1])),
        (int(width), int(height)),
        distortion,
        str(table["source"]),
    )


def finite_array(values: Any, shape: tuple[int, ...]) -> FloatArray:
    """Numbers as an array; ValueError where it is not of the shape, or one is not finite."""
    array = np.asarray(values, float)
    if array.shape != shape or not np.isfinite(array).all():
        raise ValueError(f"not of shape {shape}")
    return array


def relative_path(path: Path, folder: Path) -> str:
    """A path with forward slashes, from `folder` on where it lies on the same drive; empty for the empty path."""
    if path == Path():
        return ""
    try:
        return Path(os.path.relpath(path.resolve(), folder.resolve())).as_posix()
    except ValueError:  # another drive of Windows
        return path.resolve().as_posix()


def absolute_path(text: str, folder: Path) -> Path:
    """The inverse of `relative_path`."""
    return Path(os.path.normpath(folder / str(text))) if text else Path()

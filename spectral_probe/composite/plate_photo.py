"""The photograph behind a render: its pixels as light in the camera's own colours, and back to a picture's codes."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ..composite_model import Backplate
from ..errors import FileFormatError, PhotographError
from ..files.json_object import UNREADABLE, read_object
from ..model import BoolArray, Exposure, FloatArray, Photograph
from ..photo.exposure import plausible
from ..photo.read import read_photograph, srgb_to_linear
from ..photo.response import KNOTS
from ..spectra.camera import REC709, camera_names, camera_sensitivities
from .plate_light import linear_pixels, response_curve

SRGB = "srgb"
"""The response of a picture that follows the sRGB curve."""

_FINE_CODES = np.arange(255 * 16 + 1) / (255.0 * 16.0)

type Codes = npt.NDArray[np.uint8]


@dataclass(frozen=True)
class PlateSettings:
    """What was said of the plate besides its file; None where nothing was.

    `response` is "srgb", or a file with a measured response: a backplate.json, or the report.json of a probe. `camera` is a
    camera's name or a file of its sensitivities. `exposure_s`, `iso` and `f_number` go before what the file says.
    """

    response: str | Path | None = None
    camera: str | Path | None = None
    exposure_s: float | None = None
    iso: float | None = None
    f_number: float | None = None


@dataclass(frozen=True)
class Plate:
    """A photograph, linear, in the colours of its camera.

    Parameters
    ----------
    pixels
        (H, W, 3) float32 linear; 1 is saturation, or radiance for EXR and HDR.
    clipped
        (H, W) bool, where the photograph is saturated and `pixels` a lower bound.
    camera
        Name of the camera or of the file of its sensitivities; "Rec.709" for converted pictures, EXR and HDR.
    sensitivities
        (61, 3).
    scale
        (3,) linear pixels over the camera's response to a radiance in the render's unit: exposure times gain.
    converted
        Whether the photograph went through a tone curve.
    log_gain
        (3, K) response of a converted photograph; None for sRGB's.
    neutral
        (3,) linear pixels of what the camera took for white; None where it does not say, or the picture is balanced already.
    remarks
        Sentences for the user.
    """

    pixels: FloatArray
    clipped: BoolArray
    camera: str
    sensitivities: FloatArray
    scale: FloatArray = field(default_factory=lambda: np.ones(3))
    converted: bool = False
    log_gain: FloatArray | None = None
    neutral: FloatArray | None = None
    remarks: tuple[str, ...] = ()

    def codes(self, pixels: FloatArray) -> Codes:
        """A converted picture's 8-bit codes (H, W, 3) of linear pixels: the response applied, the inverse of reading.

        Examples
        --------
        >>> plate = Plate(np.zeros((1, 1, 3)), np.zeros((1, 1), bool), "Rec.709", np.ones((61, 3)), converted=True)
        >>> plate.codes(np.array([[[0.0, 0.2, 2.0]]])).tolist()
        [[[0, 124, 255]]]
        """
        decoded = np.repeat(srgb_to_linear(_FINE_CODES)[:, None], 3, 1)
        curve = response_curve(self.log_gain)
        light = decoded if curve is None else curve.linear(decoded)
        encoded = [
            np.interp(pixels[..., c], np.maximum.accumulate(light[:, c]), _FINE_CODES) for c in range(3)
        ]
        return np.asarray(np.rint(np.stack(encoded, -1) * 255), np.uint8)


def read_plate(path: Path, settings: PlateSettings, backplate: Backplate | None) -> Plate:
    """Read a photograph as a plate.

    Parameters
    ----------
    path
        The photograph.
    settings
        What was said of it; goes before what the backplate says.
    backplate
        That of the render, None without one. One without a photograph says nothing of this one.

    Raises
    ------
    SpectralProbeError
        If it cannot be read, is not that of the backplate, holds pixels that are not numbers, is a converted picture without a
        response curve, or a raw one of an unknown camera.
    """
    known = backplate if backplate is not None and backplate.photo != Path() else None
    photograph = _read(path, known)
    if photograph.scene_referred_float and photograph.clipped.any():
        raise PhotographError(
            f"{path.name} has {int(photograph.clipped.sum())} pixels that are not finite numbers, or negative. Mend the plate: "
            "they would show as holes in the composite."
        )
    name, sensitivities = _camera(photograph, settings, known)
    log_gain = _response(photograph, settings, known)
    size_px = photograph.clipped.shape[::-1] if known is None else known.camera.size_px
    pixels, clipped = linear_pixels(photograph, response_curve(log_gain), size_px)
    exposure, remarks = _exposure(photograph, settings, known)
    gain = np.ones(3) if known is None else np.asarray(known.gain)
    return Plate(
        pixels,
        clipped > 0,
        name,
        sensitivities,
        exposure * gain,
        converted=photograph.display_referred,
        log_gain=log_gain,
        neutral=_neutral(photograph),
        remarks=(*photograph.remarks, *remarks),
    )


# ---------------------------------------------------------------- what is known of it


def _read(path: Path, known: Backplate | None) -> Photograph:
    """The photograph, of the size that the backplate's has."""
    photograph = read_photograph(path)
    if known is None:
        return photograph
    height, width = photograph.clipped.shape
    wanted = known.photo_size_px
    if (width, height) != wanted and photograph.camera_raw and width > wanted[0]:
        photograph = read_photograph(path, half_size=True)
        height, width = photograph.clipped.shape
    if (width, height) != wanted:
        raise PhotographError(
            f"{path.name} is {width} x {height} pixels, but the backplate of the scene was made from {known.photo.name} of "
            f"{wanted[0]} x {wanted[1]}. Give that photograph, or make the backplate anew from this one."
        )
    return photograph


def _camera(
    photograph: Photograph, settings: PlateSettings, known: Backplate | None
) -> tuple[str, FloatArray]:
    """Name and sensitivities of the camera; converted pictures, EXR and HDR are Rec.709 unless another is named."""
    if settings.camera is not None:
        given = str(settings.camera)
        if given in camera_names():
            return given, camera_sensitivities(given)
        path = Path(settings.camera).expanduser()
        if path.exists():
            return path.name, camera_sensitivities(file=path)
        return given, camera_sensitivities(given)  # which says what there is
    if photograph.display_referred or photograph.scene_referred_float:
        return REC709, camera_sensitivities(REC709)
    if known is not None:
        curves = known.sensitivities
        return (
            known.camera_model if curves is None else curves.name,
            camera_sensitivities(known.camera_model, curves),
        )
    if photograph.camera_raw:
        raise PhotographError(
            f"{photograph.path.name} is camera raw, and nothing says how the camera sees colours. Give --camera, a name of "
            "`library list camera` or a file of its sensitivities."
        )
    return REC709, camera_sensitivities(REC709)


def _response(photograph: Photograph, settings: PlateSettings, known: Backplate | None) -> FloatArray | None:
    """The response of a converted picture; None for sRGB's own curve and for linear pictures."""
    if not photograph.display_referred:
        return None
    if settings.response == SRGB:
        return None
    if settings.response is not None:
        return read_response(Path(settings.response).expanduser())
    if known is None:
        raise PhotographError(
            f"{photograph.path.name} is a converted picture, and its response curve is missing: give --response srgb, or the "
            "report.json of a probe built from the same camera's converted pictures."
        )
    return known.response_log_gain


def read_response(path: Path) -> FloatArray:
    """The measured response (3, K) in a backplate.json, or of the first view that has one in the report.json of a probe.

    Raises
    ------
    FileFormatError
        If there is none.
    """
    none = FileFormatError(
        f'{path} holds no response curve. Give a backplate.json, the report.json of a probe from converted pictures, or "srgb".'
    )
    try:
        table = read_object(path)
        tables = [table, *table.get("views", ())]
        found = [_log_gain_in(entry) for entry in tables]
    except UNREADABLE:
        raise none from None
    known = [log_gain for log_gain in found if log_gain is not None]
    if not known:
        raise none
    return known[0]


def _log_gain_in(table: dict[str, object]) -> FloatArray | None:
    """The response in a JSON table or in one table within it."""
    for entry in (table, *(value for value in table.values() if isinstance(value, dict))):
        values = entry.get("response_log_gain")
        if values is not None:
            log_gain = np.asarray(values, float)
            if log_gain.shape != (3, len(KNOTS)) or not np.isfinite(log_gain).all():
                raise ValueError("not a response")
            return log_gain
    return None


def _exposure(
    photograph: Photograph, settings: PlateSettings, known: Backplate | None
) -> tuple[float, tuple[str, ...]]:
    """Relative exposure, and what is to be said of it."""
    stated = photograph.exposure if plausible(photograph.exposure) else None
    given = {
        key: value
        for key, value in (
            ("time_s", settings.exposure_s),
            ("iso", settings.iso),
            ("f_number", settings.f_number),
        )
        if value is not None
    }
    if given:
        if stated is None and settings.exposure_s is None:
            raise PhotographError(
                f"{photograph.path.name} says no exposure time. Give --exposure-s beside --iso and --f-number."
            )
        stated = replace(stated or Exposure(1.0), **given)
        if not plausible(stated):
            raise PhotographError(
                f"{stated.time_s:g} s at ISO {stated.iso:g} and f/{stated.f_number:g} cannot be. Correct the exposure."
            )
        return stated.relative, ()
    if known is not None:
        return known.exposure, ()
    if photograph.scene_referred_float:
        return 1.0, ()
    if stated is not None:
        return stated.relative, ()
    told = f"{photograph.path.name} does not say its exposure, which is taken as 1. Give --exposure-s if the objects stand out."
    return 1.0, (told,)


def _neutral(photograph: Photograph) -> FloatArray | None:
    """Camera RGB of the white that a raw file says it was balanced for; None elsewhere."""
    if not photograph.camera_raw:
        return None
    import rawpy

    try:
        with rawpy.imread(str(photograph.path)) as raw:
            factors = np.asarray(raw.camera_whitebalance[:3], float)
    except (rawpy.LibRawError, OSError):
        return None
    if not (np.isfinite(factors).all() and factors.min() > 0):
        return None
    return np.asarray(factors.max() / factors)

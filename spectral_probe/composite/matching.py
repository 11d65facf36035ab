"""A photograph matched to a probe: the camera that took it, where that stood, and how its pixels follow the probe's light.

The world: the ball's centre lies above the origin, and the first ground plane is z = 0, which the ball touches from above unless
the ground is said to lie lower.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..composite_model import Backplate
from ..errors import PhotographError, RenderError
from ..geometry.bundle import rotation_of
from ..geometry.camera import pixel_rays
from ..model import Camera, Exposure, FloatArray, Job, Photograph, Progress, ViewSettings
from ..photo.exposure import plausible, resolve_exposures
from ..photo.read import read_photograph
from ..spectra.camera import REC709, camera_sensitivities
from .plate_alignment import PlateAlignment, align_plate
from .plate_geometry import at_size, reduced_size, rendered_frame
from .plate_light import brightness_ratio, linear_pixels, response_curve
from .probe_views import ProbeView, read_probe_views

_GAIN_WIDTH_PX = 480
"""Width at which the brightness of plate and photograph is compared."""

_SAME_GAIN = 0.01
"""Channels that differ by less than this share, or two standard errors, are taken for equal."""

_ODD_GAIN = 0.15
_ODD_BALANCE = 0.05
"""Shares from which a difference in brightness, or between the channels, is worth a sentence."""

_SAME_FOCAL = 0.01


@dataclass(frozen=True)
class MatchSettings:
    """How a plate is to be matched.

    Parameters
    ----------
    view
        Which view of the probe was taken from the plate's place, from 1.
    ground_below_m
        Distance of the ground below the ball's centre; None: the ball stands on it.
    width_px
        Width to reduce the plate to; None: its own.
    align
        Whether the plate is registered to the photographs of the ball.
    exposure
        Of the plate, where its EXIF is missing or wrong.
    srgb
        Take a converted plate as plain sRGB, whatever the photographs of the ball are.
    """

    view: int = 1
    ground_below_m: float | None = None
    width_px: int | None = None
    align: bool = True
    exposure: Exposure | None = None
    srgb: bool = False


@dataclass(frozen=True)
class PlateMatch:
    """A matched plate.

    `backplate` is the result, `photograph` the plate as read, `beside` the photograph of the ball that it was compared with (None
    where that is gone). `alignment` is None where none was made; `gain` (3,) is how much brighter the plate is than the
    photographs of the ball apart from exposure, as measured, None where it was not. `remarks` are sentences for the user.
    """

    backplate: Backplate
    photograph: Photograph
    beside: Photograph | None
    alignment: PlateAlignment | None
    gain: FloatArray | None
    remarks: tuple[str, ...]


def match_plate(probe: Path, plate: Path, settings: MatchSettings) -> Job[PlateMatch]:
    """Match a photograph to a probe.

    Parameters
    ----------
    probe
        The probe's folder, or its probe.exr.
    plate
        The photograph: taken with the same camera and lens from the same place as those of a view, with the ball or without.
    settings
        What else is known.

    Yields
    ------
    Progress

    Returns
    -------
    PlateMatch

    Raises
    ------
    SpectralProbeError
        If the plate is of another size or camera, shows another scene, or its exposure is not known; if the probe's report
        is missing.
    """
    yield Progress(0.0, f"Reading {Path(plate).name}")
    view = _view(read_probe_views(probe), settings.view)
    photograph = read_photograph(plate, half_size=view.half_size)
    response = _response(photograph, view, settings)
    _check_same_camera(photograph, view)
    stated = _stated_exposure(photograph, settings)
    yield Progress(0.25, "Reading the photograph of the ball")
    nearest = _nearest(view, stated)
    beside, remarks = _photograph_of_ball(view, nearest, photograph)
    turn: FloatArray = np.eye(3)
    alignment: PlateAlignment | None = None
    ball_px = _ball_in(view, nearest)
    exposure = stated if stated is not None else view.exposures[nearest]
    if beside is photograph:  # the plate is one of the ball's photographs
        turn = _turn_to(view, nearest)
    elif settings.align and beside is not None:
        yield Progress(0.5, "Aligning the plate")
        brighter = exposure / view.exposures[nearest]
        alignment = align_plate(beside, photograph, view.camera, ball_px, brighter)
        turn = alignment.turn @ _turn_to(view, nearest)
        remarks += alignment.remarks
    yield Progress(0.85, "Comparing the brightness")
    gain = None
    if beside is not None:
        shift = (0.0, 0.0) if alignment is None else alignment.shift_px
        gain = _gain(beside, photograph, (view, nearest), settings, exposure, shift)
    if stated is None:
        remarks += (_unknown_exposure(photograph, known=gain is not None),)
    else:
        remarks += _gain_remarks(gain, photograph)
    camera = at_size(view.camera, reduced_size(view.camera.size_px, settings.width_px))
    backplate = _placed(view, camera, turn, settings)
    backplate = replace(
        backplate,
        photo=Path(plate).resolve(),
        photo_size_px=view.camera.size_px,
        response_log_gain=response,
        exposure=exposure,
        gain=_used_gain(view, photograph, gain),
        camera_model=REC709 if photograph.display_referred else view.camera_model,
        sensitivities=None if photograph.display_referred else view.sensitivities,
    )
    return PlateMatch(backplate, photograph, beside, alignment, None if gain is None else gain[0], remarks)


# ---------------------------------------------------------------- what must fit


def _view(views: Sequence[ProbeView], number: int) -> ProbeView:
    if not 1 <= number <= len(views):
        raise RenderError(
            f"The probe has {len(views)} view(s); there is no view {number}. Give one from 1 on."
        )
    return views[number - 1]


def _response(photograph: Photograph, view: ProbeView, settings: MatchSettings) -> FloatArray | None:
    """The response of a converted plate; None for sRGB's curve and for linear pictures.

    Raises
    ------
    RenderError
        If the plate is not of the kind that the photographs of the ball are.
    """
    name = photograph.path.name
    if not photograph.display_referred:
        if view.converted:
            raise RenderError(
                f"{name} is not converted as the photographs of the ball are (JPEG). Give the plate that the camera wrote "
                "with them."
            )
        return None
    if settings.srgb:
        return None
    if not view.converted:
        raise RenderError(
            f"{name} is a converted picture, the photographs of the ball are raw, so its response curve is missing. Give the "
            "plate as raw, or take it as plain sRGB with --response srgb."
        )
    return view.response_log_gain


def _check_same_camera(photograph: Photograph, view: ProbeView) -> None:
    """Refuse a plate of another size or focal length.

    Raises
    ------
    RenderError
    """
    name, size = photograph.path.name, photograph.clipped.shape[::-1]
    wanted = view.camera.size_px
    if size != wanted:
        raise RenderError(
            f"{name} is {size[0]} x {size[1]} pixels, the photographs of the ball {wanted[0]} x {wanted[1]}. Give a plate of "
            "the same camera and size, uncropped."
        )
    first = view.photos[0]
    if photograph.focal_mm is None or not first.is_file():
        return
    focal = _focal_mm(first)
    if focal is not None and abs(photograph.focal_mm / focal - 1.0) > _SAME_FOCAL:
        raise RenderError(
            f"{name} was taken at {photograph.focal_mm:g} mm, the photographs of the ball at {focal:g} mm. Give a plate taken "
            "with the same lens and zoom."
        )


def _focal_mm(path: Path) -> float | None:
    """The focal length that a photograph states, as far as its header says without its pixels."""
    from ..photo.metadata import read_record

    try:
        return read_record(path).focal_mm
    except PhotographError:
        return None


def _stated_exposure(photograph: Photograph, settings: MatchSettings) -> float | None:
    """The plate's relative exposure; None where neither the user nor the file says it."""
    given = settings.exposure
    if given is not None:
        if not plausible(given):
            raise PhotographError(
                f"{given.time_s:g} s at ISO {given.iso:g} and f/{given.f_number:g} cannot be. Correct the plate's exposure."
            )
        return given.relative
    if photograph.exposure is None and not photograph.scene_referred_float:
        return None
    return resolve_exposures([photograph], ViewSettings(photos=(photograph.path,)))[0].relative


# ---------------------------------------------------------------- the photograph of the ball beside it


def _nearest(view: ProbeView, exposure: float | None) -> int:
    """Number of the photograph of the ball that was exposed most nearly as the plate; without a word, the middle one's."""
    logs = np.log(view.exposures)
    wanted = float(np.median(logs)) if exposure is None else float(np.log(exposure))
    return int(np.argmin(np.abs(logs - wanted)))


def _photograph_of_ball(
    view: ProbeView, number: int, plate: Photograph
) -> tuple[Photograph | None, tuple[str, ...]]:
    """One of the bracket's photographs, or None and why."""
    path = view.photos[number]
    if path.resolve() == plate.path.resolve():
        return plate, ()
    if not path.is_file():
        told = f"{path.name} is no longer where the probe was built from ({path.parent}): the plate is not aligned to it."
        return None, (told,)
    photograph = read_photograph(path, half_size=view.half_size)
    if photograph.clipped.shape != plate.clipped.shape:
        return None, (f"{path.name} has another size than the plate: they are not aligned.",)
    return photograph, ()


def _ball_in(view: ProbeView, number: int) -> tuple[float, float, float]:
    """Centre x, y and radius of the ball in one of the photographs."""
    x, y, radius = view.outline_px
    return x + float(view.shifts_px[number, 0]), y + float(view.shifts_px[number, 1]), radius


def _turn_to(view: ProbeView, number: int) -> FloatArray:
    """The smallest turn (3, 3) of the camera that moves the ball as between the first photograph and another."""
    first = np.array(view.outline_px[:2])
    before, after = pixel_rays(view.camera, np.stack([first, first + view.shifts_px[number]]))
    axis = np.cross(before, after)
    sine = float(np.linalg.norm(axis))
    if sine < 1e-12:
        return np.eye(3)
    return rotation_of(axis / sine * np.arctan2(sine, float(before @ after)))


def _gain(
    beside: Photograph,
    plate: Photograph,
    which: tuple[ProbeView, int],
    settings: MatchSettings,
    exposure: float,
    shift_px: tuple[float, float],
) -> tuple[FloatArray, FloatArray] | None:
    """How much brighter the plate is than a photograph of the ball apart from exposure (3,), and its standard error (3,)."""
    view, number = which
    width, height = view.camera.size_px
    small = (min(width, _GAIN_WIDTH_PX), max(1, round(height * min(width, _GAIN_WIDTH_PX) / width)))
    scale = small[0] / width
    x, y, radius = _ball_in(view, number)
    here = linear_pixels(beside, response_curve(view.response_log_gain), small)
    there = linear_pixels(plate, response_curve(_response(plate, view, settings)), small)
    if plate.display_referred and not view.converted:
        here = (np.asarray(here[0] @ _to_rec709(view), np.float32), here[1])
    exposures = (view.exposures[number], exposure)
    return brightness_ratio(
        (here, there), exposures, np.multiply(shift_px, scale), (x * scale, y * scale, radius * scale)
    )


def _to_rec709(view: ProbeView) -> FloatArray:
    """(3, 3) that takes the linear RGB of a camera to Rec.709 as nearly as its sensitivities allow: least squares of curves."""
    camera = camera_sensitivities(view.camera_model or None, view.sensitivities) * view.gain
    return np.asarray(np.linalg.lstsq(camera, camera_sensitivities(REC709), rcond=None)[0])


def _used_gain(view: ProbeView, plate: Photograph, gain: tuple[FloatArray, FloatArray] | None) -> FloatArray:
    """`Backplate.gain`: that of the view's photographs times what the plate is brighter by, where that is certain."""
    own = np.ones(3) if plate.display_referred and not view.converted else view.gain
    if gain is None:
        return own
    ratio, error = gain
    equal = np.abs(ratio - 1.0) < np.maximum(_SAME_GAIN, 2.0 * error)
    return np.asarray(own * np.where(equal.all(), 1.0, ratio))


def _gain_remarks(gain: tuple[FloatArray, FloatArray] | None, plate: Photograph) -> tuple[str, ...]:
    """A sentence on a plate that is brighter, darker or of another balance than its exposure says."""
    if gain is None:
        return ()
    ratio = gain[0]
    level = float(np.exp(np.log(ratio).mean()))
    balance = ratio / level
    name = plate.path.name
    if np.abs(balance - 1.0).max() > _ODD_BALANCE:
        red, green, blue = ratio
        told = (
            f"{name} differs in colour from the photographs of the ball (red {red:.2f}, green {green:.2f}, blue {blue:.2f} times "
            "as bright): it had another white balance, or the light changed. The renders are matched to it."
        )
        return (told,)
    if abs(level - 1.0) > _ODD_GAIN:
        told = (
            f"{name} is {level:.2f} times as bright as the photographs of the ball at its exposure: the exposure stated is "
            "wrong, or the light changed. The renders are matched to it."
        )
        return (told,)
    return ()


def _unknown_exposure(plate: Photograph, *, known: bool) -> str:
    """What is said of a plate without exposure.

    Raises
    ------
    PhotographError
        If its brightness does not tell it either.
    """
    if not known:
        raise PhotographError(
            f"{plate.path.name} says no exposure time, and shows too little in common with the photographs of the ball to "
            "tell it. Give --exposure-s, and --iso and --f-number where they differ."
        )
    return (
        f"{plate.path.name} says no exposure time: its brightness was matched to the photographs of the ball."
    )


# ---------------------------------------------------------------- the camera in the world


def _placed(view: ProbeView, camera: Camera, turn: FloatArray, settings: MatchSettings) -> Backplate:
    """The camera over the ground, the ball above the world's origin.

    Raises
    ------
    RenderError
        If the ground would cut the ball, or lie above the camera.
    """
    radius = view.ball_radius_m
    below = radius if settings.ground_below_m is None else settings.ground_below_m
    if not radius * (1.0 - 1e-6) <= below < np.inf:
        raise RenderError(
            f"The ground cannot lie {below:g} m below the centre of a ball of {radius:g} m radius. Give {radius:g} m or more."
        )
    centre = np.array([0.0, 0.0, below])
    position = centre - view.rotation @ view.ball_centre_m
    if position[2] <= 0.0:
        raise RenderError(
            f"The camera would stand {-position[2]:.2f} m below the ground. Correct elevation_deg of the view in the capture "
            "(above 0 the camera looks down), or say how far below the ball the ground is."
        )
    return Backplate(
        camera=camera,
        rotation=view.rotation @ turn.T,
        position_m=position,
        photo=Path(),
        photo_size_px=view.camera.size_px,
        frame_px=rendered_frame(camera),
        ball_centre_m=centre,
        ball_radius_m=radius,
    )

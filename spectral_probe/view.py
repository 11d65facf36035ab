"""One view, from its photographs to a radiance image and the ball in it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .errors import CaptureError, OutlineError
from .geometry.ball import fit_ball
from .geometry.camera import camera_for
from .geometry.near_rim import find_ball_near
from .geometry.outline import FoundBall, check_in_frame, find_ball, outline_given
from .light_settings import Rectangle
from .model import (
    BallFit,
    BoolArray,
    Camera,
    Capture,
    Exposure,
    FloatArray,
    Outline,
    Photograph,
    RadianceImage,
    ViewSettings,
)
from .patch import Patch, direct_patch
from .photo.align import align, register
from .photo.bracket import MergedBracket, merge_bracket
from .photo.exposure import resolve_exposures
from .photo.read import read_photograph

_MARGIN_PX = 12
"""Pixels round the ball that are kept: whoever resamples at its rim needs some."""

_TOUCHED = 0.05
"""How far, in radii, the ball may lie from where it was without the filter: whoever screws one on may touch the tripod."""

_STILL_PX = 1.0
"""Nearer than this it did not move: a tripod that stood still is likelier than an outline that is exact."""

_AS_WITHOUT = "its outline without the filter is used."

type BallSeen = Callable[[Sequence[Photograph], FoundBall], None]
"""Told of a view's photographs and the ball in them, while they are in memory."""


@dataclass(frozen=True)
class MeasuredView:
    """One view of the ball: its radiance image and geometry.

    `image` and the `camera` that took it are cut to the ball; `corner_px` is their left and upper edge in the photograph, whose
    pixels `outline` counts. `converted` where a tone curve had been applied (JPEG). `others` are further balls in the
    picture (x, y, radius), `remarks` sentences for the user. `patch` is what was asked for beside the ball. `size_px` is the
    (width, height) of the whole photograph, `shifts_px` (E, 2) where the ball lies in each photograph from the first.
    """

    settings: ViewSettings
    image: RadianceImage
    camera: Camera
    corner_px: tuple[int, int]
    outline: Outline
    ball: BallFit
    converted: bool
    bracket: MergedBracket
    others: tuple[tuple[float, float, float], ...] = ()
    remarks: tuple[str, ...] = ()
    patch: Patch | None = None
    size_px: tuple[int, int] = (0, 0)
    shifts_px: tuple[FloatArray, ...] = ()

    @property
    def clipped_fraction(self) -> float:
        """Share of the ball's pixels that are clipped in every photograph."""
        return float(1.0 - self.image.valid[self._on_ball].mean())

    @property
    def moved_fraction(self) -> float:
        """Share of the ball's pixels where some photograph was left out because it disagrees with the others."""
        return float(self.bracket.moved[self._on_ball].mean())

    @property
    def _on_ball(self) -> BoolArray:
        return on_ball(self.outline, self.image.valid.shape, self.corner_px)


def on_ball(outline: Outline, shape: tuple[int, ...], corner_px: tuple[int, int] = (0, 0)) -> BoolArray:
    """Pixels (H, W) inside the outline's inscribed circle, of a picture that begins at `corner_px`."""
    rows, columns = np.ogrid[: shape[0], : shape[1]]
    x = columns + 0.5 + corner_px[0] - outline.centre_px[0]
    y = rows + 0.5 + corner_px[1] - outline.centre_px[1]
    return np.asarray(np.hypot(x, y) < min(outline.semi_axes_px))


def measure_view(
    capture: Capture,
    settings: ViewSettings,
    patch_px: Rectangle | None = None,
    partner: MeasuredView | None = None,
    seen: BallSeen | None = None,
) -> MeasuredView:
    """Read one view's bracket, find the ball in it, and merge it to radiance.

    Parameters
    ----------
    capture, settings
        The capture, and which of its views.
    patch_px
        A patch of the first photograph to measure as well.
    partner
        For photographs through a filter, the same view without it: where they are too dark to find the ball, it is where that
        has it.
    seen
        Called once the ball is found.

    Raises
    ------
    SpectralProbeError
        If a photograph, an exposure or the ball cannot be had; the message says what to do.
    """
    photographs = [read_photograph(path, half_size=capture.camera.half_size) for path in settings.photos]
    converted = _check_kind(capture, photographs)
    stated = resolve_exposures(photographs, settings)
    camera = camera_for(capture.camera, photographs[0])
    found = locate_ball(photographs, settings, partner)
    if seen is not None:
        seen(photographs, found)
    outline = found.outlines[0]
    ball = fit_ball(camera, outline, capture.ball.radius_m)
    size_px = camera.size_px
    bracket, camera, corner_px = _merged(photographs, stated, found, camera, settings)
    patch = None if patch_px is None else direct_patch(photographs, bracket, patch_px, found.shifts_px)
    remarks = [remark for photograph in photographs for remark in photograph.remarks]
    return MeasuredView(
        settings,
        bracket.image,
        camera,
        corner_px,
        outline,
        ball,
        converted,
        bracket,
        found.others,
        (*remarks, *found.warnings, *bracket.warnings),
        patch,
        size_px,
        found.shifts_px,
    )


def _check_kind(capture: Capture, photographs: Sequence[Photograph]) -> bool:
    """Whether the photographs went through a tone curve; refuses raw of an unnamed camera, and mixtures.

    A camera's own curves apply to raw only: pictures a camera or a program converted are linear Rec.709 once their
    tone curve is undone.
    """
    kinds = {photograph.display_referred for photograph in photographs}
    if len(kinds) > 1:
        raise CaptureError("A view mixes raw and converted photographs (JPEG). Use one kind.")
    if photographs[0].camera_raw and capture.camera.model is None and capture.camera.sensitivities is None:
        from .spectra.camera import camera_names  # takes seconds to import: not to find balls

        raise CaptureError(
            f"{photographs[0].path.name} is camera raw, so its camera must be known. Add to [camera] a model "
            f'({", ".join(camera_names()[:-1])}) or sensitivities = "camera.csv".'
        )
    return kinds.pop()


def locate_ball(
    photographs: Sequence[Photograph], settings: ViewSettings, partner: MeasuredView | None = None
) -> FoundBall:
    """The ball in every photograph: found, or where or near where the user says, or where the partner has it."""
    if settings.outline is not None:
        return _where_given(photographs, settings.outline, snap=settings.snap_outline)
    if partner is None:
        return find_ball(photographs, settings.ball_at)
    try:
        found = find_ball(photographs, settings.ball_at)
    except OutlineError:
        told = f"Too dark through the filter to find the ball: {_AS_WITHOUT}"
        return _at(partner.outline, photographs, (told,))
    moved_px, limit_px = (
        _moved_px(found.outlines[0], partner.outline),
        max(partner.outline.semi_axes_px) * _TOUCHED,
    )
    if moved_px > limit_px:
        told = f"Through the filter something else seemed to be the ball: {_AS_WITHOUT}"
        return _at(partner.outline, photographs, (told,))
    if (
        moved_px < _STILL_PX
    ):  # what the two differ by is the error of either, and would tear the channels apart at edges
        return replace(found, outlines=(partner.outline,) * len(photographs))
    return found


def _where_given(photographs: Sequence[Photograph], values: tuple[float, ...], *, snap: bool) -> FoundBall:
    """The ball where the user says, or with `snap` its rim near there."""
    outline = outline_given(values)
    if snap:
        return find_ball_near(photographs, outline)
    height, width = photographs[0].clipped.shape
    check_in_frame(outline, (width, height), given=True)
    return _at(outline, photographs)


def _at(outline: Outline, photographs: Sequence[Photograph], warnings: tuple[str, ...] = ()) -> FoundBall:
    """The ball at a known place in the first photograph."""
    circle = (*outline.centre_px, outline.semi_axes_px[0])
    shifts = register(photographs, [circle] * len(photographs))
    return FoundBall((outline,) * len(photographs), tuple(shifts), warnings=warnings)


def _moved_px(one: Outline, other: Outline) -> float:
    """How far the circles of two outlines lie apart at most."""
    apart = np.hypot(*np.subtract(one.centre_px, other.centre_px))
    return float(apart + abs(max(one.semi_axes_px) - max(other.semi_axes_px)))


def _merged(
    photographs: Sequence[Photograph],
    stated: Sequence[Exposure],
    found: FoundBall,
    camera: Camera,
    settings: ViewSettings,
) -> tuple[MergedBracket, Camera, tuple[int, int]]:
    """The bracket cut to the ball, aligned and merged; the camera of the part, and the part's corner."""
    outline = found.outlines[0]
    reach = max(outline.semi_axes_px) + _MARGIN_PX
    low = np.floor(np.subtract(outline.centre_px, reach)).astype(int)
    high = np.ceil(np.add(outline.centre_px, reach)).astype(int)
    parts, shifts = [], []
    for photograph, shift in zip(photographs, found.shifts_px, strict=True):
        part, corner = _cut(photograph, low + np.round(shift).astype(int), high + np.round(shift).astype(int))
        parts.append(part)
        shifts.append((corner, shift))
    first = shifts[0][0]
    aligned = align(parts, [shift - (corner - first) for corner, shift in shifts])
    height, width = parts[0].clipped.shape
    corner_px = (int(first[0]), int(first[1]))
    bracket = merge_bracket(
        aligned,
        stated,
        on_ball(outline, (height, width), corner_px),
        solve_exposures=settings.solve_exposures,
    )
    principal = (camera.principal_px[0] - corner_px[0], camera.principal_px[1] - corner_px[1])
    return bracket, replace(camera, principal_px=principal, size_px=(width, height)), corner_px


def _cut(photograph: Photograph, low: FloatArray, high: FloatArray) -> tuple[Photograph, FloatArray]:
    """The part of a photograph from `low` (x, y) to `high`, as far as it has one, and where that begins."""
    height, width = photograph.clipped.shape
    left, top = np.clip(low, 0, (width - 1, height - 1))
    right, bottom = np.clip(high, (left + 1, top + 1), (width, height))
    part = (slice(top, bottom), slice(left, right))
    cut = replace(photograph, pixels=photograph.pixels[part], clipped=photograph.clipped[part])
    return cut, np.array([left, top])

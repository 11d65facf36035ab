"""One view's radiance image onto the panorama, every direction read where the ball mirrors it.

The panorama is filled by going backwards: from the direction of a texel to the point on the ball that mirrors
it (`find_reflection`) to the place in the photograph that saw that point. Both ways the resampling is correct by area:
a photograph finer than the panorama is first averaged down to its resolution, and where the ball's picture is finer
along the rim than the texels there, several places along the rim are averaged.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import cv2
import numpy as np

from ..model import BallFit, BoolArray, Camera, FloatArray, RadianceImage
from ..parallel import in_parallel, row_blocks
from .ball import find_reflection, reflection_table
from .camera import project
from .frames import panorama_solid_angles
from .interpolate import bilinear
from .sampling import Sampling, sampling

WIDTHS = (64, 16384)
_WIDTH_STEP = 64
_TAPS = (2, 4, 8)
"""Texels that span more pixels than this along the rim are averaged over so many places there: samples between pixels that are
two pixels apart leave nothing out. The ball's picture is 1 / cos(angle / 2) times as fine there as at its centre."""

_EXACT_BELOW, _TEXELS_BETWEEN, _TURNING_RAD = 2048, 4, np.radians(140.0)
"""On panoramas as wide as this, places are found at every fourth texel and, further than this angle from the camera, at each."""

_COARSER = (1.25, 2.5)
"""Texels coarser than a pixel by more than these are averaged from 4 or 16 samples of the photograph."""

_RIM_COSINE = 0.02
"""Closer to the rim than this cosine of incidence a direction is not used: a pixel there spans degrees."""


@dataclass(frozen=True)
class ViewPanorama:
    """What one view saw, in the panorama's frame.

    `responses` (H, W, 3) linear camera RGB of the ball's image, `variance` (H, W, 3) of it, `cos_incidence` (H, W) on the
    ball, `facing_rad` (H, W) angle between the direction and the direction to the camera, `seen` (H, W) inside the
    view (not in its blind cone, not hidden), `valid` (H, W) seen and not clipped. `sampling` tells how densely and how
    exactly the view samples each direction.
    """

    responses: FloatArray
    variance: FloatArray
    cos_incidence: FloatArray
    facing_rad: FloatArray
    seen: BoolArray
    valid: BoolArray
    sampling: Sampling | None = None

    @property
    def footprint_sr(self) -> FloatArray:
        """Solid angle (H, W) float32 of the directions that one pixel of the photograph sees."""
        return self._sampled().footprint_sr

    @property
    def direction_error_rad(self) -> FloatArray:
        """Standard error (H, W) float32 of the direction, from the outline's uncertainty."""
        return self._sampled().direction_error_rad

    def _sampled(self) -> Sampling:
        if self.sampling is None:
            raise ValueError("This view's sampling was not computed.")
        return self.sampling.resized(*self.seen.shape)


def natural_width(samplings: Sequence[Sampling], step: int = _WIDTH_STEP) -> int:
    """Width in pixels of a panorama as fine as the densest footprint of any view, a multiple of `step`.

    A texel at the horizon, (2 pi / W)^2 steradians, is then no larger than the directions that one pixel sees.

    Examples
    --------
    From far away a pixel sees 4 / R^2 steradians of a ball of R pixels, so that W = pi R:

    >>> far = BallFit(np.array([0.0, 0.0, 100.0]), 0.1, np.arcsin(1e-3), 0.0)
    >>> camera = Camera((500000.0, 500000.0), (512.0, 512.0), (1024, 1024))
    >>> natural_width([sampling(camera, far, np.eye(3))])
    1600
    """
    densest = min(float(one.footprint_sr.min()) for one in samplings)
    width = step * int(np.ceil(2 * np.pi / np.sqrt(densest) / step))
    return int(np.clip(width, *WIDTHS))


def view_panorama(
    image: RadianceImage, camera: Camera, ball: BallFit, rotation: FloatArray, width: int
) -> ViewPanorama:
    """Resample a view's radiance image to an equirectangular panorama.

    Parameters
    ----------
    image
        Radiance of the photograph, (H, W, 3).
    camera, ball
        Its geometry.
    rotation
        (3, 3) camera to world (`frames.camera_to_world`).
    width
        Width of the panorama in pixels; its height is half of it.

    Returns
    -------
    ViewPanorama
        Arrays of shape (width / 2, width, ...).
    """
    unwrapping = Unwrapping.of(image, camera, ball, rotation, width)
    parts = in_parallel(unwrapping.rows, row_blocks(width))
    whole = {
        name: np.concatenate([getattr(part, name) for part in parts])
        for name in ("responses", "variance", "cos_incidence", "facing_rad", "seen", "valid")
    }
    return ViewPanorama(**whole, sampling=unwrapping.sampling)


@dataclass(frozen=True)
class Unwrapping:
    """A view ready to be unwrapped, some rows of the panorama at a time.

    `radiance` (H, W, 4) is the photograph and where it is valid, `variance` (H, W, 3) that of its values, both averaged
    down where the photograph is much finer than the panorama; `doublings` of the panorama's width are sampled and
    averaged then.
    """

    radiance: FloatArray
    variance: FloatArray
    finder: _PlaceFinder
    sampling: Sampling
    doublings: int

    @staticmethod
    def of(
        image: RadianceImage, camera: Camera, ball: BallFit, rotation: FloatArray, width: int
    ) -> Unwrapping:
        """Prepare a view for a panorama of a width."""
        density = sampling(camera, ball, rotation)
        finer = natural_width([density], step=1) / width
        doublings = sum(finer > limit for limit in _COARSER)
        # A sample between pixels reaches as far as two of them: texels averaged from several are not blurred by that.
        coarser = max(finer / 2**doublings, 1.0) if doublings else 1.0
        image, camera = _averaged(image, camera, coarser)
        # With where it is valid, so that both are read in one go.
        valid = image.valid.astype(np.float32)
        radiance = np.empty((*valid.shape, 4), np.float32)
        parts = [np.ascontiguousarray(image.radiance, np.float32), valid]
        cv2.mixChannels(parts, [radiance], [0, 0, 1, 1, 2, 2, 3, 3])
        variance = np.asarray(image.variance, np.float32)
        if not image.valid.all():  # it is infinite there, which `valid` tells
            variance = np.where(image.valid[..., None], variance, np.float32(0.0))
        finder = _PlaceFinder(camera, ball, rotation, width * 2**doublings, finer / coarser / 2**doublings)
        return Unwrapping(radiance, variance, finder, density, doublings)

    def rows(self, rows: slice) -> ViewPanorama:
        """Some rows of the panorama, without `sampling`."""
        scale = 2**self.doublings
        view = self._sampled(slice(rows.start * scale, rows.stop * scale))
        for doubling in range(self.doublings, 0, -1):
            view = self._halved(view, rows, 2 ** (doubling - 1))
        return view

    def _sampled(self, rows: slice) -> ViewPanorama:
        """Rows of the doubled panorama from one sample a texel, or several along the rim."""
        column, row, cosine, facing = self.finder.places(rows)
        seen = cosine > _RIM_COSINE
        for place, side in zip((column, row), self.finder.camera.size_px, strict=True):
            seen &= (place > -0.5) & (place < side - 0.5)
        values = bilinear(self.radiance, column, row)
        _average_along_rim(values, self.radiance, column, row, facing, self.finder)
        valid = seen & (values[..., 3] > 0.99)
        return ViewPanorama(
            values[..., :3], bilinear(self.variance, column, row), cosine, facing, seen, valid
        )

    def _halved(self, view: ViewPanorama, rows: slice, scale: int) -> ViewPanorama:
        """Rows averaged by area to half the size, which is `scale` times that of the panorama's own `rows`."""
        height, width = view.seen.shape[0] // 2, view.seen.shape[1] // 2

        def mean(values: FloatArray) -> FloatArray:
            small = cv2.resize(np.asarray(values, np.float32), (width, height), interpolation=cv2.INTER_AREA)
            return np.asarray(small)

        # Four samples are as many measurements as there are pixels in the texel, one at least.
        texel_sr = panorama_solid_angles(width // 2, width)[rows.start * scale : rows.stop * scale]
        camera, ball = self.finder.camera, self.finder.ball
        pixel_sr = 4.0 / (np.prod(camera.focal_px) * np.tan(ball.cone_angle_rad) ** 2)
        measurements = np.clip(texel_sr / pixel_sr, 1.0, 4.0).astype(np.float32)
        return ViewPanorama(
            responses=mean(view.responses),
            variance=mean(view.variance) / measurements[..., None],
            cos_incidence=mean(view.cos_incidence),
            facing_rad=mean(view.facing_rad),
            seen=mean(view.seen.astype(np.float32)) > 0.99,
            valid=mean(view.valid.astype(np.float32)) > 0.99,
        )


def _averaged(image: RadianceImage, camera: Camera, finer: float) -> tuple[RadianceImage, Camera]:
    """The photograph averaged down by area where it is `finer` than the panorama, and its camera."""
    if finer <= 1.0:
        return image, camera
    width, height = camera.size_px
    size = (max(8, round(width / finer)), max(8, round(height / finer)))
    scale = np.array(size) / camera.size_px

    def shrunk(values: FloatArray) -> FloatArray:
        return np.asarray(cv2.resize(np.asarray(values, np.float32), size, interpolation=cv2.INTER_AREA))

    known = np.where(np.isfinite(image.variance), image.variance, 0.0)
    smaller = RadianceImage(
        shrunk(image.radiance),
        shrunk(known) * np.float32(scale.prod()),  # of the mean of independent pixels
        shrunk(image.valid.astype(np.float32)) > 0.99,
    )
    focal, principal = scale * camera.focal_px, scale * camera.principal_px
    return smaller, replace(
        camera,
        focal_px=(float(focal[0]), float(focal[1])),
        principal_px=(float(principal[0]), float(principal[1])),
        size_px=size,
    )


@dataclass(frozen=True)
class _PlaceFinder:
    """Where in a photograph the directions of a panorama's texels are seen.

    Away from the rim the places change so evenly that on large panoramas every fourth texel is enough and the others lie between;
    near the rim, where they turn round the blind cone, each is found by itself.
    """

    camera: Camera
    ball: BallFit
    rotation: FloatArray
    width: int
    finer: float = 1.0
    """How many pixels of the photograph a texel spans where the ball faces the camera."""

    @cached_property
    def table(self) -> FloatArray:
        """The ball's `reflection_table`."""
        return reflection_table(self.ball)

    @cached_property
    def centre(self) -> FloatArray:
        """Place (x, y) of the ball's centre, counted from the centre of the first pixel."""
        return project(self.camera, self.ball.centre_m) - 0.5

    def places(self, rows: slice) -> list[FloatArray]:
        """Column and row in the photograph, cosine of incidence, angle from the camera: (h, W) float32 each."""
        columns = np.arange(self.width) + 0.5
        lines = np.arange(rows.start, rows.stop) + 0.5
        if self.width < _EXACT_BELOW:
            return self._exact(columns, lines[:, None])
        step = _TEXELS_BETWEEN
        coarse = [
            (np.arange(-1, -(-len(line) // step) + 1) + 0.5) * step + line[0] - 0.5
            for line in (columns, lines)
        ]
        nodes = cv2.merge(self._exact(coarse[0], coarse[1][:, None]))
        size = (nodes.shape[1] * step, nodes.shape[0] * step)
        between = cv2.resize(nodes, size, interpolation=cv2.INTER_LINEAR)
        inside = between[step : step + len(lines), step : step + self.width]
        found = [np.ascontiguousarray(inside[..., channel]) for channel in range(4)]
        near_rim = np.flatnonzero(found[3] > _TURNING_RAD)
        exact = self._exact(columns[near_rim % self.width], lines[near_rim // self.width])
        for values, better in zip(found, exact, strict=True):
            values.reshape(-1)[near_rim] = better
        return found

    def _exact(self, columns: FloatArray, rows: FloatArray) -> list[FloatArray]:
        """The same at panorama coordinates that broadcast to (...)."""
        longitude = ((0.5 - columns / self.width) * 2 * np.pi).astype(np.float32)
        latitude = ((0.5 - 2 * rows / self.width) * np.pi).astype(np.float32)
        cosine, sine, east, north = np.cos(latitude), np.sin(latitude), np.cos(longitude), np.sin(longitude)
        turn = self.rotation.astype(np.float32)
        directions = np.stack(
            [cosine * (turn[0, k] * east + turn[1, k] * north) + sine * turn[2, k] for k in range(3)]
        )
        directions = np.moveaxis(
            directions, 0, -1
        )  # by component in memory: numpy is slow along an axis of 3
        points, incidence = find_reflection(self.ball, directions, self.table)
        places = project(self.camera, points)
        towards_camera = (-self.ball.centre_m / self.ball.distance_m).astype(np.float32)
        facing = np.arccos(np.clip(directions @ towards_camera, -1.0, 1.0))
        half = np.float32(0.5)
        return [places[..., 0] - half, places[..., 1] - half, incidence, facing]


def _average_along_rim(
    values: FloatArray,
    image: FloatArray,
    column: FloatArray,
    row: FloatArray,
    facing_rad: FloatArray,
    finder: _PlaceFinder,
) -> None:
    """Replace texels (h, W, C) near the rim by the average of the image over a texel's width along it."""
    flat = values.reshape(-1, values.shape[-1])
    limits = [2 * np.arccos(min(finder.finer / taps, 1.0)) for taps in _TAPS]
    for taps, start, end in zip(_TAPS, limits, [*limits[1:], np.pi], strict=True):
        chosen = np.flatnonzero((facing_rad > start) & (facing_rad <= end))
        x, y = column.reshape(-1)[chosen], row.reshape(-1)[chosen]
        arc = np.float32(2 * np.pi / finder.width) / np.sin(facing_rad.reshape(-1)[chosen])
        across, down = (x - np.float32(finder.centre[0])) * arc, (y - np.float32(finder.centre[1])) * arc
        total = np.zeros((len(chosen), flat.shape[-1]), np.float32)
        for share in ((np.arange(taps) + 0.5) / taps - 0.5).astype(np.float32):
            total += bilinear(image, x - share * down, y + share * across)
        flat[chosen] = total / np.float32(taps)

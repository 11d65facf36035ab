"""The data that travels down the pipeline: small frozen dataclasses, arrays with shapes by letter.

Axis letters: H, W image; C = 3 camera channels; L wavelengths; K basis weights; B bases; P passes.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from .light_settings import CalibrationSettings, RegionLight
from .light_settings import Region as Region  # noqa: PLC0414  (part of the capture: imported from here)

if TYPE_CHECKING:  # Blender imports this module at its start, and would wait for numpy
    import numpy as np
    import numpy.typing as npt

    from .work import Work

type FloatArray = npt.NDArray[np.floating[Any]]
type IntArray = npt.NDArray[np.integer[Any]]
type BoolArray = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Progress:
    """How far a long job has come: `fraction` in 0..1 and what it is doing now.

    `work` is what has to be done before the job goes on, where that is not the job's own next step (`work.Work`).
    """

    fraction: float
    message: str
    work: Work[Any] | None = None


type Job[Result] = Generator[Progress, None, Result]
"""A long job: it yields `Progress` and returns its result. `finish` drives it; operators and the CLI have their own drivers."""


def finish[Result](job: Job[Result]) -> Result:
    """Run a job to its end without showing progress, and return its result.

    Examples
    --------
    >>> def job():
    ...     yield Progress(0.5, "half way")
    ...     return 42
    >>> finish(job())
    42
    """
    while True:
        try:
            next(job)
        except StopIteration as stop:
            return stop.value  # type: ignore[no-any-return]  # StopIteration carries its value untyped


def part[Result](job: Job[Result], start: float, end: float) -> Job[Result]:
    """A job as a part of a longer one: its progress runs from `start` to `end` of the whole.

    Examples
    --------
    >>> def job():
    ...     yield Progress(0.5, "half way")
    >>> next(part(job(), 0.2, 0.4)).fraction
    0.30000000000000004
    """
    try:
        while True:
            try:
                progress = next(job)
            except StopIteration as stop:
                return stop.value  # type: ignore[no-any-return]  # StopIteration carries its value untyped
            yield replace(progress, fraction=start + (end - start) * progress.fraction)
    finally:
        job.close()


# ---------------------------------------------------------------- the capture, as the user describes it


@dataclass(frozen=True)
class CameraSettings:
    """`[camera]` of a capture file. Lengths that are None come from EXIF or their default."""

    model: str | None = None
    sensitivities: Path | None = None
    focal_px: tuple[float, float] | None = None
    focal_mm: float | None = None
    sensor_width_mm: float | None = None
    calibration: Path | None = None
    principal_px: tuple[float, float] | None = None
    distortion: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0)
    half_size: bool = False
    """Camera raw at half the size, one pixel for each 2 x 2 sensels; pixel lengths here are then of the half size."""


@dataclass(frozen=True)
class BallSettings:
    """`[ball]` of a capture file: radius in metres, material as a name or as fractions of metals (eq. 11)."""

    radius_m: float = 0.05
    material: str | Mapping[str, float] = "SUS304"


@dataclass(frozen=True)
class ViewSettings:
    """`[[view]]` of a capture file: where the camera looked and what it took.

    `azimuth_deg` is the compass bearing of the viewing direction (0 = world +Y, clockwise from above),
    `elevation_deg` > 0 means the camera is above the ball, `roll_deg` turns the camera clockwise about its axis.
    `refine` lets registration correct these angles. `outline` is (centre x, centre y, radius) in pixels of the first
    photograph, or an ellipse (centre x, centre y, semi-axis, semi-axis, angle_deg of the first), or None to detect it;
    `snap_outline` says that the rim next to it is meant, and not it itself. `ball_at` is a point on the ball, where more
    than one is in the picture.
    `solve_exposures` takes what the pixels say of the exposures where the stated ones contradict them. `filter` is the
    transmittance (CSV), or the name of a glass, of a filter these photographs were taken through: they belong to the view
    without a filter that has the same three angles.
    """

    photos: tuple[Path, ...]
    azimuth_deg: float = 0.0
    elevation_deg: float = 0.0
    roll_deg: float = 0.0
    refine: bool = True
    exposures_s: tuple[float, ...] | None = None
    iso: tuple[float, ...] | None = None
    f_number: tuple[float, ...] | None = None
    outline: tuple[float, ...] | None = None
    ball_at: tuple[float, float] | None = None
    solve_exposures: bool = True
    filter: str | Path | None = None
    snap_outline: bool = False


COMPOSITIONS = ("blend", "cut")
"""How views become one panorama: every direction from where it is sampled best, blended; or the paper's plain cut, each view
to 60 degrees on both sides of the direction from the ball to its camera."""


@dataclass(frozen=True)
class Capture:
    """A whole capture: camera, ball, views and their composition, and what is known of the light.

    `families` are the lamp families that may be present, `spectra` files of the user's own lights beside them, `regions` have
    lights of their own, and `calibration` is a light that is known.
    """

    views: tuple[ViewSettings, ...]
    camera: CameraSettings = field(default_factory=CameraSettings)
    ball: BallSettings = field(default_factory=BallSettings)
    families: tuple[str, ...] = ("incandescent", "daylight")
    method: str = "family"
    composition: str = "blend"
    spectra: tuple[Path, ...] = ()
    regions: tuple[RegionLight, ...] = ()
    calibration: CalibrationSettings | None = None


# ---------------------------------------------------------------- photographs


@dataclass(frozen=True)
class Exposure:
    """Exposure time in seconds, ISO speed and f-number of one photograph."""

    time_s: float
    iso: float = 100.0
    f_number: float = 1.0

    @property
    def relative(self) -> float:
        """Relative exposure t ISO / (100 N^2), in seconds at ISO 100 and f/1.

        Examples
        --------
        >>> Exposure(0.01, iso=200, f_number=2).relative
        0.005
        """
        return self.time_s * self.iso / (100.0 * self.f_number**2)


@dataclass(frozen=True)
class Photograph:
    """One photograph in linear camera RGB.

    `pixels` (H, W, 3) float32, 1 = the sensor's (or the file's) saturation level, black at 0, no white balance;
    `clipped` (H, W) True where any channel is saturated. `exposure` is None where the file says nothing.
    `focal_mm`, `focal_35mm` and `sensor_width_mm` (the longer side) come from EXIF (None without).
    `display_referred` marks JPEG and other pictures that passed through a tone curve, here undone as sRGB.
    `scene_referred_float` marks EXR and HDR, whose values are radiance already and never clip. `camera_raw` marks what
    LibRaw developed. `remarks` are sentences on pixels that were left out.
    """

    path: Path
    pixels: FloatArray
    clipped: BoolArray
    exposure: Exposure | None = None
    focal_mm: float | None = None
    focal_35mm: float | None = None
    display_referred: bool = False
    scene_referred_float: bool = False
    camera_raw: bool = False
    sensor_width_mm: float | None = None
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True)
class RadianceImage:
    """A bracket merged: `radiance` (H, W, 3) in relative linear camera RGB per unit of relative exposure.

    `variance` (H, W, 3) is the variance of `radiance`. `valid` (H, W) is False where every photograph is clipped
    (there `radiance` is a lower bound) or nothing was recorded.
    """

    radiance: FloatArray
    variance: FloatArray
    valid: BoolArray


# ---------------------------------------------------------------- geometry


@dataclass(frozen=True)
class Camera:
    """A pinhole camera: focal lengths and principal point in pixels (pixel centres at integer + 0.5).

    `distortion` in OpenCV's order k1 k2 p1 p2 k3; `size_px` is (width, height); `source` says where the
    focal length came from ("capture file", "calibration", "EXIF").
    """

    focal_px: tuple[float, float]
    principal_px: tuple[float, float]
    size_px: tuple[int, int]
    distortion: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0)
    source: str = "capture file"


@dataclass(frozen=True)
class Outline:
    """The ball's outline in an image: an ellipse, and the sub-pixel edge points (N, 2) it was fitted to.

    `centre_px` (x, y); `semi_axes_px` (major, minor); `angle_rad` of the major axis from +x towards +y;
    `rms_px` distance of the points from the ellipse. All in pixels, pixel centres at integer + 0.5.
    `error_px` (2,) are the standard errors of the centre (the larger of both directions) and of the radius.
    """

    centre_px: tuple[float, float]
    semi_axes_px: tuple[float, float]
    angle_rad: float
    points_px: FloatArray
    rms_px: float
    error_px: tuple[float, float] = (0.0, 0.0)


def _zeros(*shape: int, kind: type = float) -> Callable[[], Any]:
    def make() -> Any:
        import numpy as np

        return np.zeros(shape, kind)

    return make


@dataclass(frozen=True)
class BallFit:
    """The ball in the camera's frame: centre M (3,) in metres, radius r, half angle xi of the outline's cone.

    `rms_rad` is the distance of the outline's rays from the cone. The distance |M| is d = r / sin(xi).
    `covariance_rad2` (3, 3) is that of the cone's axis along two directions across it (`axis_tangents`) and of xi.
    `points_px` (N, 2) are the outline's points, `residuals_px` (N,) their distances from the fitted cone's outline, positive
    outside, and `used` (N,) is False for those that the fit rejected.
    """

    centre_m: FloatArray
    radius_m: float
    cone_angle_rad: float
    rms_rad: float
    covariance_rad2: FloatArray = field(default_factory=_zeros(3, 3))
    points_px: FloatArray = field(default_factory=_zeros(0, 2))
    residuals_px: FloatArray = field(default_factory=_zeros(0))
    used: BoolArray = field(default_factory=_zeros(0, kind=bool))

    @property
    def distance_m(self) -> float:
        """Distance from the camera's centre of projection to the ball's centre, in metres."""
        import numpy as np

        return float(np.linalg.norm(self.centre_m))

    @property
    def axis_tangents(self) -> FloatArray:
        """Two unit vectors (2, 3) across the direction to the ball's centre: to the right, and down, in the image.

        Examples
        --------
        >>> import numpy as np
        >>> BallFit(np.array([0.0, 0.0, 1.0]), 0.1, np.arcsin(0.1), 0.0).axis_tangents.tolist()
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
        """
        import numpy as np

        axis = self.centre_m / self.distance_m
        right = np.cross([0.0, 1.0, 0.0], axis)
        right /= np.linalg.norm(right)
        return np.stack([right, np.cross(axis, right)])


# ---------------------------------------------------------------- the probe


type Texels = tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]
"""Rows (N,) and columns (N,) of some texels of a panorama: of a few out of millions, quicker than a mask."""

type Keeps = Literal["luminance", "power", "surfaces"]
"""What of the light stays under another lamp."""


@dataclass(frozen=True)
class Edit:
    """A change of the light in a region of a panorama that can be taken back.

    A `glass` multiplies spectra by `spectrum` (L,), its transmittance. A `lamp` replaces them by that of another lamp,
    `spectrum` (L,) in any unit, and keeps each direction's luminance or radiant power; one that keeps surfaces multiplies by
    `spectrum`, the new lamp over the old one. `name` and `region` say in words what and where.
    """

    kind: Literal["glass", "lamp"]
    name: str
    region: str
    spectrum: FloatArray
    keeps: Keeps = "luminance"


@dataclass(frozen=True)
class SpectralPanorama:
    """The spectrum of the light from every direction, in Blender's equirectangular frame (row 0 is up).

    The spectral radiance at a pixel is ``weights @ bases[basis_index]``, per nm, relative units.

    Parameters
    ----------
    weights
        (H, W, K) float32 weights epsilon of eq. 8; K is fixed within a panorama, unused weights are 0.
    bases
        (B, K, L) basis spectra.
    basis_index
        (H, W) uint8, which basis a pixel uses.
    wavelengths_nm
        (L,).
    valid
        (H, W) bool, False where no view saw the direction unclipped.
    confidence
        (H, W) float32 in 0..1.
    direction_error_rad
        (H, W) float32, standard error of the direction that a texel stands for, from the outline's uncertainty; pi where
        nothing was seen. None where it is not known.
    provenance
        What it was made from and how, as text for the file's header.
    edits
        Changes of the light in regions, in the order in which they were made.
    derived_bases
        How the last bases came from the recovered ones, which are the first: for each the number of the recovered basis and then
        the numbers of the edits done to it, all counted from 0.
    further
        Further entries of the file's header, kept as they are (what JSON can hold).
    """

    weights: FloatArray
    bases: FloatArray
    basis_index: npt.NDArray[np.uint8]
    wavelengths_nm: FloatArray
    valid: BoolArray
    confidence: FloatArray
    provenance: Mapping[str, str] = field(default_factory=dict)
    direction_error_rad: FloatArray | None = None
    edits: tuple[Edit, ...] = ()
    derived_bases: tuple[tuple[int, ...], ...] = ()
    further: Mapping[str, Any] = field(default_factory=dict)

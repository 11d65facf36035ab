"""The bright thing at a point of a panorama, such as a window or a lamp: grown from a seed by luminance and spectrum.

The work is done in a panorama turned so that the seed lies in the middle: a degree is then the same number of pixels in
every direction near it, and neither the seam at the edges nor the poles come near the thing.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from ..errors import SpectralDataError
from ..geometry.frames import (
    bearing_to_direction,
    direction_to_equirectangular,
    equirectangular_to_direction,
    panorama_solid_angles,
)
from ..geometry.sphere import padded
from ..model import BoolArray, FloatArray, IntArray, SpectralPanorama
from .colorimetry import spectra_to_xyz
from .grid import resample

_REACH_DEG = 0.75
"""The brightest direction this near the seed stands for the thing: the seed may lie on a glazing bar."""

_LIKE_COS = float(np.cos(np.radians(20.0)))
"""Spectra that differ by less than this angle are alike. Skies of 5000 to 10000 K differ by up to 21 degrees from end to
end, so by half of that from their mean; a filament lamp from daylight by 26 to 36."""

_HALF = 0.5
"""The edge of a blurred bright thing lies where half of its luminance is reached."""

_STEPS = 12
"""Thresholds tried from the peak down to half of it."""

_STABLE_GROWTH = 0.1
_STABLE_STEPS = 3
_LEAK_GROWTH = 3.0
"""An outline is a step in luminance: the area hardly grows (by less than a tenth a threshold, three times) while the threshold
falls over it. If it then grows threefold at one or two further thresholds, the region has leaked into what lies round it."""

_BAR_DEG = 0.7
"""Dark bars up to this width (6 cm at 5 m) do not divide a window."""

_LARGEST_HOLE = 0.25
"""Enclosed dark parts up to this share of the region belong to it (a tree behind a window); larger ones (the ceiling inside
a ring lamp) do not."""

_SOFT_EDGE_DEG = 0.6
_FOOT = 0.03
_SLOPE = 1.15
"""A blurred outline goes on falling beyond its half: texels up to this far out are taken along while they fall by this factor
to the next one, down to 3 %. Otherwise a stained window would keep a white rim."""

_FINEST_WIDTH = 2048
"""Finer panoramas are grown in at this width; only the outline is then drawn at their own."""


def grown_region(
    panorama: SpectralPanorama, seen: BoolArray, azimuth_deg: float, elevation_deg: float
) -> BoolArray:
    """Texels (H, W) of the bright thing that holds a direction.

    Parameters
    ----------
    panorama
        The light.
    seen
        (H, W) which texels a view saw; the others are filled in, and not grown into.
    azimuth_deg, elevation_deg
        The seed, a compass bearing and an elevation.

    Returns
    -------
    ndarray
        (H, W) bool: what is connected with the seed, of at least half the luminance of its brightest surroundings and
        of like spectrum. Brighter parts belong to it, and dark ones that it encloses. Where half the luminance would leak into a
        bright wall, the threshold is raised to the window's outline.

    Raises
    ------
    SpectralDataError
        If no view saw the seed, or there is no light.
    """
    height, width = seen.shape
    name = f"{azimuth_deg:g},{elevation_deg:g}"
    luminance = np.where(seen, panorama_luminance(panorama), np.float32(0.0))
    turn = _Turn(_to_seed(bearing_to_direction(azimuth_deg, elevation_deg)), height, width)
    near = turn.near_seed(_REACH_DEG)
    if not seen[near].any():
        raise SpectralDataError(f"No view saw the direction {name}. Choose another seed.")
    rows, columns = near
    brightest = int(np.argmax(luminance[near]))
    anchor = int(rows[brightest]), int(columns[brightest])
    peak = float(luminance[anchor])
    if peak <= 1e-6 * float(luminance.max()):
        raise SpectralDataError(f"There is no light at {name}. Choose a seed in a window or a lamp.")
    like = _alike(panorama, anchor)
    # What is unlike is as good as black.
    grown = _grown(turn.there(np.where(like, luminance, -luminance)), turn.pixel_of(anchor), peak)
    mask = _with_sharp_edge(turn.back(grown.inside), like & (luminance >= grown.threshold))
    return _with_soft_edge(mask, luminance, peak) & seen


def panorama_luminance(panorama: SpectralPanorama) -> FloatArray:
    """Luminance (radiance times CIE y-bar summed over nm) of every direction, (H, W) float32."""
    bases = resample(panorama.wavelengths_nm, panorama.bases, name="the panorama")
    of_bases = spectra_to_xyz(bases)[..., 1].astype(np.float32)
    if len(of_bases) == 1:
        return np.asarray(panorama.weights @ of_bases[0])
    luminance = np.empty(panorama.valid.shape, np.float32)
    for index, of_basis in enumerate(of_bases):
        uses = panorama.basis_index == index
        luminance[uses] = panorama.weights[uses] @ of_basis
    return luminance


# ---------------------------------------------------------------- the turned panorama


class _Turn:
    """A panorama turned so that the direction +X of the turned one is the seed; nearest texels both ways."""

    def __init__(self, rotation: FloatArray, height: int, width: int) -> None:
        self.rotation, self.height, self.width = rotation, height, width
        self.elevation = float(np.arcsin(np.clip(rotation[2, 0], -1.0, 1.0)))
        self.turned_width = min(width, _FINEST_WIDTH)
        self.turned_height = self.turned_width // 2

    def there(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Values (H, W, ...) in the turned panorama."""
        turned = np.empty((self.turned_height, self.turned_width, *values.shape[2:]), values.dtype)
        for row in range(self.turned_height):
            directions = _row_directions(row, self.turned_height, self.turned_width) @ self.rotation.T
            turned[row] = values[_texels(directions, self.height, self.width)]
        return turned

    def back(self, mask: BoolArray) -> BoolArray:
        """A turned mask in the panorama (H, W); only rows as near to the seed as the mask are looked at."""
        own = np.zeros((self.height, self.width), bool)
        inside = equirectangular_to_direction(np.argwhere(mask)[:, ::-1] + 0.5, *mask.shape)
        reach = np.arccos(np.clip(inside[:, 0].min(), -1.0, 1.0)) + 2 * np.pi / self.turned_height
        from_seed = abs((0.5 - (np.arange(self.height) + 0.5) / self.height) * np.pi - self.elevation)
        for row in np.flatnonzero(from_seed <= reach).tolist():
            directions = _row_directions(row, self.height, self.width) @ self.rotation
            own[row] = mask[_texels(directions, self.turned_height, self.turned_width)]
        return own

    def near_seed(self, radius_deg: float) -> tuple[IntArray, IntArray]:
        """Texels of the panorama within an angle of the seed, the seed's own and its neighbours at least."""
        step = np.pi / self.height
        reach = max(np.radians(radius_deg), 1.5 * step)
        count = int(np.ceil(reach / step)) * 2
        offsets = np.linspace(-reach, reach, 2 * count + 1)
        across, up = np.meshgrid(offsets, offsets)
        inside = np.hypot(across, up) <= reach
        across, up = across[inside], up[inside]
        directions = np.stack([np.ones_like(across), across, up], -1) @ self.rotation.T
        return _texels(directions, self.height, self.width)

    def pixel_of(self, texel: tuple[int, int]) -> tuple[int, int]:
        """The turned pixel of a texel."""
        point = np.array([texel[1] + 0.5, texel[0] + 0.5])
        direction = equirectangular_to_direction(point, self.height, self.width) @ self.rotation
        rows, columns = _texels(direction[None], self.turned_height, self.turned_width)
        return int(rows[0]), int(columns[0])


def _to_seed(seed: FloatArray) -> FloatArray:
    """Rotation (3, 3) whose columns are the seed, a horizontal direction across it, and what is up there."""
    horizontal = float(np.hypot(seed[0], seed[1]))
    left = np.array([-seed[1], seed[0], 0.0]) / horizontal if horizontal > 0 else np.array([0.0, 1.0, 0.0])
    return np.stack([seed, left, np.cross(seed, left)], axis=-1)


def _row_directions(row: int, height: int, width: int) -> FloatArray:
    points = np.stack([np.arange(width) + 0.5, np.full(width, row + 0.5)], axis=-1)
    return equirectangular_to_direction(points, height, width)


def _texels(directions: FloatArray, height: int, width: int) -> tuple[IntArray, IntArray]:
    points = direction_to_equirectangular(directions, height, width)
    rows = np.clip(points[..., 1].astype(np.intp), 0, height - 1)
    return rows, points[..., 0].astype(np.intp) % width


# ---------------------------------------------------------------- growing


@dataclass(frozen=True)
class _Grown:
    inside: BoolArray
    threshold: float


def _alike(panorama: SpectralPanorama, anchor: tuple[int, int]) -> BoolArray:
    """Texels (H, W) whose spectrum is like that of the anchor, by the angle between them.

    By products of the bases with each other: no texel's spectrum is ever formed.
    """
    spectrum = panorama.weights[anchor].astype(float) @ panorama.bases[panorama.basis_index[anchor]]
    spectrum /= np.linalg.norm(spectrum)
    like = np.zeros(panorama.valid.shape, bool)
    for index, basis in enumerate(panorama.bases):
        uses = panorama.basis_index == index
        weights = panorama.weights[uses]
        along = weights @ (basis @ spectrum).astype(np.float32)
        gram = (basis @ basis.T).astype(np.float32)
        length = np.sqrt(np.maximum(((weights @ gram) * weights).sum(-1), 0.0))
        like[uses] = (along >= _LIKE_COS * length) & (length > 0)
    return like


def _grown(light: FloatArray, anchor: tuple[int, int], peak: float) -> _Grown:
    """The region round an anchor in the luminance `light` (H, W), negative where the spectrum is another."""
    thresholds = peak * np.geomspace(0.95, _HALF, _STEPS)
    whole = _connected(light >= thresholds[-1], anchor)
    crop = _box(whole)  # whatever is connected at a higher threshold lies in this
    light, start, largest = light[crop], (anchor[0] - crop[0].start, anchor[1] - crop[1].start), whole[crop]
    solid_angles = panorama_solid_angles(*whole.shape)[crop[0]]
    parts: list[BoolArray] = []
    areas: list[float] = []
    before, chosen = None, largest
    for threshold in thresholds:
        part = _connected((light >= threshold) & largest, start)
        parts, areas = [*parts[-2:], part], [*areas, float((part * solid_angles).sum())]
        before = _leaked(areas)
        if before is not None:
            chosen = parts[-1 - before]
            break
    inside = np.zeros(whole.shape, bool)
    threshold = float(thresholds[-1] if before is None else thresholds[len(areas) - 1 - before])
    inside[crop] = _filled(chosen, light, threshold)
    return _Grown(inside, threshold)


def _box(mask: BoolArray) -> tuple[slice, slice]:
    """The rows and columns that a mask occupies."""
    rows, columns = (np.flatnonzero(mask.any(axis)) for axis in (1, 0))
    return slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)


def _leaked(areas: list[float]) -> int | None:
    """How many thresholds ago the region still ended at an outline that it has left since, None where it has not.

    Examples
    --------
    >>> _leaked([1.0, 1.05, 1.1, 1.12, 1.13, 4.0])
    1
    >>> _leaked([1.0, 1.5, 2.0, 2.6, 3.0])  # never stable: a thing that gets darker bit by bit
    """
    for ago in (1, 2):
        if len(areas) < ago + _STABLE_STEPS + 1:
            continue
        steady = areas[-1 - ago - _STABLE_STEPS : len(areas) - ago]
        stable = all(later <= earlier * (1 + _STABLE_GROWTH) for earlier, later in pairwise(steady))
        if stable and areas[-1] > _LEAK_GROWTH * steady[-1]:
            return ago
    return None


def _connected(bright: BoolArray, anchor: tuple[int, int]) -> BoolArray:
    """What of a mask is connected with the anchor, over dark bars."""
    size = round(_BAR_DEG * bright.shape[1] / 360) + 1
    kernel = np.ones((size, size), np.uint8)
    # A closing by an even number of pixels: the anchors of its two halves mirror each other, so that nothing shifts.
    tall = cv2.copyMakeBorder(bright.astype(np.uint8), *(size,) * 4, cv2.BORDER_CONSTANT, value=0)
    closed = cv2.erode(cv2.dilate(tall, kernel, anchor=(0, 0)), kernel, anchor=(size - 1, size - 1))
    _, labels = cv2.connectedComponents(closed[size:-size, size:-size])
    return np.asarray(labels == labels[anchor])


def _filled(part: BoolArray, light: FloatArray, threshold: float) -> BoolArray:
    """A region with the small holes in it, save lamps of another kind that hang before it."""
    outside = cv2.copyMakeBorder((~part).astype(np.uint8), 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=1)
    count, labels, statistics, _ = cv2.connectedComponentsWithStats(outside)
    holes = np.zeros(count, bool)
    holes[1:] = statistics[1:, cv2.CC_STAT_AREA] <= _LARGEST_HOLE * part.sum()
    holes[labels[0, 0]] = False
    return np.asarray(part | (holes[labels[1:-1, 1:-1]] & (light > -threshold)))


# ---------------------------------------------------------------- edges, in the panorama itself


def _neighbourhood(values: FloatArray | BoolArray, *, largest: bool) -> FloatArray:
    """Largest or smallest value of a texel and its eight neighbours, round the sphere."""
    tall = padded(values.astype(np.float32), 1, 1)
    filtered = (cv2.dilate if largest else cv2.erode)(tall, np.ones((3, 3), np.uint8))
    return np.asarray(filtered[1:-1, 1:-1])


def _with_sharp_edge(mask: BoolArray, bright: BoolArray) -> BoolArray:
    """A mask whose outermost texels, rough from turning, are decided by the panorama's own."""
    core, reach = _neighbourhood(mask, largest=False) > 0.5, _neighbourhood(mask, largest=True) > 0.5
    return np.asarray(core | (reach & bright))


def _with_soft_edge(mask: BoolArray, luminance: FloatArray, peak: float) -> BoolArray:
    """A mask with the blurred rim round it: outwards while the luminance falls, and still falls further out."""
    foot = (luminance >= _FOOT * peak) & (luminance >= _SLOPE * _neighbourhood(luminance, largest=False))
    for _ in range(max(round(_SOFT_EDGE_DEG * luminance.shape[1] / 360), 1)):
        inner = _neighbourhood(np.where(mask, luminance, 0.0), largest=True)
        rim = ~mask & foot & (inner >= _SLOPE * luminance)
        if not rim.any():
            break
        mask = mask | rim
    return mask

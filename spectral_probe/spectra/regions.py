"""Regions of a panorama: a polygon of great circles, a painted mask, or one bright thing grown from a point in it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from ..errors import FileFormatError, PhotographError, SpectralDataError
from ..geometry.frames import bearing_to_direction, panorama_solid_angles
from ..model import BoolArray, FloatArray, Region, SpectralPanorama, Texels
from .growing import grown_region, panorama_luminance

_OPPOSITE = 1e-9
"""Corners whose directions sum to a vector shorter than this lie opposite each other."""

_SAME_SIZE = 1e-9
"""Share of the sphere by which the two sides of a polygon may differ and still count as halves."""


def region_mask(region: Region, panorama: SpectralPanorama) -> BoolArray:
    """The texels of a panorama that belong to a region.

    Parameters
    ----------
    region
        A polygon (see `polygon_mask` for which side of it is inside), a mask, or a seed.
    panorama
        Its size is that of the result; a seed grows by its light.

    Returns
    -------
    ndarray
        (H, W) bool, True where the texel's centre lies inside.

    Raises
    ------
    SpectralDataError
        If the region is not properly described, or selects no texel, only what no view saw, or only black.
    FileFormatError
        If its mask cannot be used.
    """
    check_region(region)
    height, width = panorama.valid.shape
    if region.polygon_deg is not None:
        mask = polygon_mask(region.polygon_deg, height, width)
    elif region.mask is not None:
        mask = read_mask(region.mask, height, width)
    else:
        mask = grown_region(panorama, seen_texels(panorama), *_seed(region))
    return checked_mask(mask, panorama, describe(region))


def checked_mask(mask: BoolArray, panorama: SpectralPanorama, where: str) -> BoolArray:
    """A mask (H, W), refused where there is nothing in it to be changed; `where` says it in words.

    Raises
    ------
    SpectralDataError
        If no texel is selected, or only such that no view saw, or only black ones.
    """
    if not mask.any():
        raise SpectralDataError(f"The region ({where}) selects nothing. Make it larger.")
    if not (mask & seen_texels(panorama)).any():
        raise SpectralDataError(
            f"The region ({where}) holds only directions that no view saw. Choose another."
        )
    if not (panorama_luminance(panorama)[mask] > 0).any():
        raise SpectralDataError(f"The region ({where}) is black: there is no light in it to change.")
    return mask


def mean_spectrum(panorama: SpectralPanorama, chosen: BoolArray | Texels) -> FloatArray:
    """Mean spectrum (L,) of some texels of a panorama, by solid angle; no texel's spectrum is ever formed.

    Examples
    --------
    >>> one, first = np.ones((1, 2), np.float32), np.zeros((1, 2), np.uint8)
    >>> panorama = SpectralPanorama(one[..., None], np.full((1, 1, 3), 2.0), first, np.arange(3.0), one > 0, one)
    >>> mean_spectrum(panorama, one > 0).tolist()
    [2.0, 2.0, 2.0]
    """
    rows, columns = texels_of(chosen)
    solid_angles = panorama_solid_angles(*panorama.valid.shape)[rows, 0]
    weights, used = panorama.weights[rows, columns], panorama.basis_index[rows, columns]
    total = np.zeros(len(panorama.wavelengths_nm))
    for index, basis in enumerate(panorama.bases):
        uses = used == index
        total += (solid_angles[uses] @ weights[uses]) @ basis
    return np.asarray(total / solid_angles.sum())


def texels_of(chosen: BoolArray | Texels) -> Texels:
    """Rows and columns of the texels of a mask (H, W).

    Examples
    --------
    >>> [places.tolist() for places in texels_of(np.array([[False, True]]))]
    [[0], [1]]
    """
    if isinstance(chosen, tuple):
        return chosen
    rows, columns = np.nonzero(chosen)
    return rows, columns


def check_region(region: Region) -> None:
    """Refuse a region that is not described by exactly one of its three ways, or by numbers that are no directions.

    Raises
    ------
    SpectralDataError
        With what is wrong.
    """
    ways = (region.polygon_deg, region.mask, region.seed_deg)
    if sum(way is not None for way in ways) != 1:
        raise SpectralDataError("A region is a polygon, a mask or a seed: give exactly one of them.")
    corners = region.polygon_deg if region.seed_deg is None else (region.seed_deg,)
    for azimuth, elevation in corners or ():
        if not (math.isfinite(azimuth) and math.isfinite(elevation)):
            raise SpectralDataError("A bearing or an elevation of the region is not a number.")
        if abs(elevation) > 90:
            raise SpectralDataError(
                f"The region's elevation {elevation:g} is not between -90 and 90 degrees. Give bearing, then elevation."
            )
    if region.polygon_deg is not None and len(region.polygon_deg) < 3:
        raise SpectralDataError("A polygon needs three corners or more.")


def describe(region: Region) -> str:
    """A region in a few words, for lists and messages.

    Examples
    --------
    >>> describe(Region(seed_deg=(30.0, 12.5)))
    'grown from 30,12.5'
    >>> describe(Region(polygon_deg=((0, 0), (10, 0), (10, 20))))
    'polygon of 3 corners about 6.6,6.7'
    """
    if region.polygon_deg is not None:
        middle = bearing_to_direction(*np.array(region.polygon_deg, float).T).sum(0)
        azimuth = math.degrees(math.atan2(middle[0], middle[1])) % 360
        elevation = math.degrees(math.atan2(middle[2], math.hypot(middle[0], middle[1])))
        return f"polygon of {len(region.polygon_deg)} corners about {azimuth:.1f},{elevation:.1f}"
    if region.mask is not None:
        return f"mask {Path(region.mask).name}"
    return "grown from {:g},{:g}".format(*_seed(region))


def _seed(region: Region) -> tuple[float, float]:
    azimuth, elevation = region.seed_deg or (math.nan, math.nan)
    return azimuth, elevation


def seen_texels(panorama: SpectralPanorama) -> BoolArray:
    """Texels (H, W) that a view saw, clipped ones included where the panorama tells them from unseen ones."""
    if panorama.direction_error_rad is None:
        return panorama.valid
    return panorama.valid | (panorama.direction_error_rad < np.pi)


# ---------------------------------------------------------------- polygons


def polygon_mask(corners_deg: tuple[tuple[float, float], ...], height: int, width: int) -> BoolArray:
    """Texels whose centre lies inside a polygon on the sphere.

    Edges are the shorter arcs of great circles. Inside is the smaller of the two sides, of two equal halves that with the
    zenith. Where a polygon crosses itself, what is enclosed an even number of
    times belongs to the outside (even-odd rule).

    Parameters
    ----------
    corners_deg
        Three or more (compass bearing, elevation) in degrees, in order, either way round; bearings may run over 360.
    height, width
        Of the panorama in pixels.

    Returns
    -------
    ndarray
        (H, W) bool.

    Raises
    ------
    SpectralDataError
        If neighbouring corners lie opposite each other, so that no arc between them is the shortest.

    Notes
    -----
    A meridian meets an edge at most once, so every column is a scan line from one pole to the other: the crossings along it
    switch inside and outside. Nothing is special about bearing 0 or a pole inside the polygon.

    Examples
    --------
    >>> octant = polygon_mask(((0, 0), (90, 0), (0, 90)), 64, 128)
    >>> float((octant * panorama_solid_angles(64, 128)).sum() / np.pi).__round__(3)  # an eighth of the sphere
    0.5
    """
    corners = bearing_to_direction(*np.array(corners_deg, float).T)
    following = np.roll(corners, -1, axis=0)
    opposite = np.linalg.norm(corners + following, axis=1) < _OPPOSITE
    if opposite.any():
        number = int(np.argmax(opposite)) + 1
        raise SpectralDataError(
            f"Corners {number} and {number % len(corners) + 1} of the polygon lie opposite each other: put a corner "
            "between them."
        )
    longitudes = (0.5 - (np.arange(width) + 0.5) / width) * 2 * np.pi
    latitudes = (0.5 - (np.arange(height) + 0.5) / height) * np.pi
    corner_longitudes = np.arctan2(corners[:, 1], corners[:, 0])
    # Whether a meridian lies within half a turn east of a corner: the one comparison that both edges at the corner share,
    # so that a meridian through a corner is counted by exactly one of them.
    east = (longitudes - corner_longitudes[:, None]) % (2 * np.pi) < np.pi

    switches = np.zeros((height + 1, width), bool)
    columns = np.arange(width)
    for index, (start, end) in enumerate(zip(corners, following, strict=True)):
        after = (index + 1) % len(corners)
        span = _half_turn(corner_longitudes[after] - corner_longitudes[index])
        if span > 0:
            crossed = east[index] & ~east[after]
        elif span < 0:
            crossed = ~east[index] & east[after]
        else:
            continue
        normal = np.cross(start, end)
        rise = -(normal[0] * np.cos(longitudes) + normal[1] * np.sin(longitudes)) * np.sign(span)
        crossing = np.arctan2(rise[crossed], abs(normal[2]))
        rows_above = np.searchsorted(-latitudes, -crossing, side="right")
        switches[rows_above, columns[crossed]] ^= True
    odd = np.logical_xor.accumulate(switches[:height], axis=0)
    solid_angles = np.broadcast_to(panorama_solid_angles(height, width), odd.shape)
    share = float(solid_angles[odd].sum() / (4 * np.pi))
    return ~odd if share > 0.5 - _SAME_SIZE else odd


def _half_turn(angle_rad: float) -> float:
    """An angle brought into -pi..pi."""
    return (angle_rad + np.pi) % (2 * np.pi) - np.pi


# ---------------------------------------------------------------- painted masks


def read_mask(path: Path, height: int, width: int) -> BoolArray:
    """Texels that are white in an equirectangular picture of any size, row 0 up.

    Parameters
    ----------
    path
        Any picture that OpenCV reads, of 8 or 16 bits: inside where it is brighter than half, and not transparent. A larger
        one is averaged down, of a smaller one the nearest pixel counts.
    height, width
        Of the panorama in pixels.

    Returns
    -------
    ndarray
        (H, W) bool.

    Raises
    ------
    FileFormatError
        If there is no such picture, or it is not twice as wide as high.
    """
    from ..photo.file_kind import check_picture_size, mapped
    from ..photo.read import opencv_silent

    path = Path(path)
    if not path.is_file():
        raise FileFormatError(f"There is no mask {path}. Check the path.")
    unreadable = FileFormatError(f"{path.name} cannot be read as a picture. Save the mask as PNG.")
    try:
        check_picture_size(path)  # the decoder allocates what the file claims
        with opencv_silent():
            pixels = cv2.imdecode(mapped(path), cv2.IMREAD_UNCHANGED)
    except (PhotographError, cv2.error):
        raise unreadable from None
    if pixels is None:
        raise unreadable
    return mask_from_pixels(pixels, height, width, path.name)


def mask_from_pixels(pixels: npt.NDArray[Any], height: int, width: int, name: str) -> BoolArray:
    """Texels (height, width) that are white in an equirectangular picture.

    Parameters
    ----------
    pixels
        (H, W) or (H, W, 1..4), integers, or floats in 0..1; a second or a fourth channel is opacity.
    height, width
        Of the panorama in pixels.
    name
        What the picture is called in an error message.

    Raises
    ------
    FileFormatError
        If the pixels are not twice as wide as high.

    Examples
    --------
    >>> mask_from_pixels(np.array([[0, 255], [0, 0]], np.uint8).repeat(2, 1), 2, 4, "mask").astype(int).tolist()
    [[0, 0, 1, 1], [0, 0, 0, 0]]
    """
    rows, columns = pixels.shape[:2]
    if columns != 2 * rows:
        raise FileFormatError(
            f"The mask {name} is {columns} x {rows} pixels; a mask of the whole panorama is twice as wide as high."
        )
    full = float(np.iinfo(pixels.dtype).max) if np.issubdtype(pixels.dtype, np.integer) else 1.0
    planes = np.atleast_3d(pixels).astype(np.float32) / full
    colours = planes.shape[2] if planes.shape[2] % 2 else planes.shape[2] - 1
    white = planes[..., :colours].mean(-1)
    if colours < planes.shape[2]:
        white *= planes[..., -1]
    shrinks = columns > width
    resized = cv2.resize(
        white, (width, height), interpolation=cv2.INTER_AREA if shrinks else cv2.INTER_NEAREST_EXACT
    )
    return np.asarray(resized > 0.5)

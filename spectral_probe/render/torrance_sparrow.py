"""Reflection by rough surfaces, eq. 12 (Torrance & Sparrow 1967), integrated over a spectral panorama without a renderer.

The reference against which the Cycles node group (`operators/bridge/torrance_sparrow.py`) is compared. A surface of normal N,
seen from the direction V, sends back of the radiance E(L) that falls in from everywhere

    Y = alpha S int E (N.L) dL  +  beta int D(phi) G F(theta_Q) / cos(theta_r) E dL  +  beta' F(theta_r) E(R),

with Q halfway between V and L, phi its angle from N, theta_Q that between it and L, and R the mirror image of V. All terms hold
at every wavelength. References: Tominaga & Tanaka (2003); Torrance & Sparrow (1967), JOSA 57, 1105, doi:10.1364/JOSA.57.001105.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from ..errors import RenderError
from ..geometry.frames import (
    camera_to_world,
    direction_to_equirectangular,
    equirectangular_to_direction,
    panorama_solid_angles,
)
from ..model import BoolArray, FloatArray, SpectralPanorama
from ..spectra.grid import WAVELENGTHS_NM, resample
from ..spectra.metals import fresnel_reflectance, refractive_index

_DIFFUSE_ROWS = 64
"""Rows of the panorama over which the diffuse term is summed: a cosine is smooth."""

_STEPS_IN_GAMMA = 2.0
"""Texels in an angle gamma; the lobe is twice as wide in directions of the light as in normals of the facets."""

_NEGLIGIBLE = 1e-9
"""Facets whose share D is below this are left out."""

_ANGLES = 512
"""Bins of cos(theta_Q) in which light is collected before the Fresnel reflectance is applied."""

_MOST_NUMBERS = 4_000_000
"""Numbers of one intermediate array; points are taken in blocks so that it stays below."""


@dataclass(frozen=True)
class TorranceSparrowSurface:
    """A surface of eq. 12.

    Parameters
    ----------
    alpha
        Weight of diffuse reflection, per steradian; the diffuse albedo is ``pi * alpha * reflectance``.
    beta
        Weight of the specular lobe, per steradian.
    beta_mirror
        Weight beta' of perfect mirror reflection.
    gamma_rad
        Angle between facet and surface at which the lobe has half its height.
    reflectance
        (61,) diffuse reflectance S on the grid of `grid.WAVELENGTHS_NM`.
    n, k
        (61,) complex refractive index; k = 0 is a dielectric.
    denominator
        "reflection": the lobe is divided by cos(theta_r), which makes it reciprocal. "incidence": by cos(theta_i), as
        eq. 12 is printed.
    """

    alpha: float
    beta: float
    beta_mirror: float
    gamma_rad: float
    reflectance: FloatArray = field(default_factory=lambda: np.ones(len(WAVELENGTHS_NM)))
    n: FloatArray = field(default_factory=lambda: np.zeros(len(WAVELENGTHS_NM)))
    k: FloatArray = field(default_factory=lambda: np.ones(len(WAVELENGTHS_NM)))
    denominator: Literal["reflection", "incidence"] = "reflection"

    def __post_init__(self) -> None:
        """Refuse what is no surface."""
        if not 0 < self.gamma_rad < math.pi / 2:
            raise RenderError("The angle gamma must be above 0 and below 90 degrees.")
        if min(self.alpha, self.beta, self.beta_mirror) < 0:
            raise RenderError("alpha, beta and beta' must not be negative.")

    @classmethod
    def metal(
        cls, name: str, *, alpha: float = 0.0, beta: float = 0.0, beta_mirror: float = 0.0, gamma_rad: float
    ) -> TorranceSparrowSurface:
        """A surface of a metal by name (`metals.refractive_index`)."""
        n, k = refractive_index(name)
        return cls(alpha, beta, beta_mirror, gamma_rad, n=n, k=k)

    def fresnel(self, cos_incidence: FloatArray) -> FloatArray:
        """Fresnel reflectance (..., 61) at incidence angles (...)."""
        return fresnel_reflectance(self.n, self.k, np.asarray(cos_incidence, float)[..., None])


def facet_distribution(cos_facet: FloatArray, gamma_rad: float) -> FloatArray:
    """Share D of facets at an angle phi from the surface's normal, by cos(phi): 1 at 0, 1/2 at gamma.

    Examples
    --------
    >>> facet_distribution(np.cos([0.0, 0.1, 0.2]), 0.1).round(4).tolist()
    [1.0, 0.5, 0.0625]
    """
    phi = np.arccos(np.clip(cos_facet, -1.0, 1.0))
    return np.asarray(np.exp(-math.log(2.0) * (phi / gamma_rad) ** 2))


def groove_shadowing(
    cos_facet: FloatArray, cos_incidence: FloatArray, cos_reflection: FloatArray, cos_half: FloatArray
) -> FloatArray:
    """Share G of V-shaped grooves that is neither shadowed nor hidden, by the cosines N.Q, N.L, N.V and V.Q.

    Examples
    --------
    >>> float(groove_shadowing(np.array(1.0), np.array(1.0), np.array(1.0), np.array(1.0)))
    1.0
    """
    seen = 2.0 * cos_facet * np.minimum(cos_incidence, cos_reflection) / np.maximum(cos_half, 1e-12)
    return np.clip(seen, 0.0, 1.0)


def reflected_radiance(
    panorama: SpectralPanorama, surface: TorranceSparrowSurface, normals: FloatArray, views: FloatArray
) -> FloatArray:
    """Spectral radiance that a surface in the light of a panorama sends into directions: eq. 12.

    Parameters
    ----------
    panorama
        The light E, as far away as a panorama is.
    surface
        What reflects it.
    normals
        (..., 3) unit normals N of the surface, in world coordinates.
    views
        (..., 3) unit vectors V from the surface to who looks at it; they are broadcast against the normals.

    Returns
    -------
    ndarray
        (..., 61) radiance per nm, in the panorama's unit; 0 where the surface is seen from behind.

    Notes
    -----
    The integrals are sums over texels times their solid angles. Before, the panorama is averaged (or interpolated
    linearly, as Cycles does) to texels of half of gamma, so that neither its lamps nor the lobe fall between them.

    Examples
    --------
    A perfect mirror of facets in equal light: the lobe's own albedo, here near 4 pi beta times that of the facets.

    >>> light = SpectralPanorama(np.ones((32, 64, 1), np.float32), np.ones((1, 1, 61)), np.zeros((32, 64), np.uint8),
    ...     WAVELENGTHS_NM, np.ones((32, 64), bool), np.ones((32, 64), np.float32))
    >>> surface = TorranceSparrowSurface(0.0, 10.0, 0.0, np.radians(5.0))
    >>> up = np.array([0.0, 0.0, 1.0])
    >>> reflected = reflected_radiance(light, surface, up, up)
    >>> float((reflected[0] / (4 * np.pi * 10.0 * np.radians(5.0) ** 2 / np.log(2.0))).round(2))
    0.99
    """
    normals, views = np.broadcast_arrays(np.asarray(normals, float), np.asarray(views, float))
    shape = normals.shape[:-1]
    normals, views = normals.reshape(-1, 3), views.reshape(-1, 3)
    weights, bases = _joint_weights(panorama)
    cos_reflection = np.einsum("pi,pi->p", normals, views)
    facing = cos_reflection > 1e-6
    normals, views, cos_reflection = normals[facing], views[facing], cos_reflection[facing]

    radiance = np.zeros((len(normals), len(WAVELENGTHS_NM)))
    if surface.alpha:
        radiance += surface.alpha * surface.reflectance * (_irradiance(weights, normals) @ bases)
    if surface.beta:
        radiance += surface.beta * _lobe(weights, bases, surface, normals, views)
    if surface.beta_mirror:
        mirrored = 2.0 * cos_reflection[:, None] * normals - views
        light = _interpolated(weights, mirrored) @ bases
        radiance += surface.beta_mirror * surface.fresnel(cos_reflection) * light
    result = np.zeros((len(facing), len(WAVELENGTHS_NM)))
    result[facing] = radiance
    return result.reshape(*shape, -1)


@dataclass(frozen=True)
class BallImage:
    """A ball: `radiance` (H, W, 61) per nm, 0 beside the ball, and `coverage` (H, W) of each pixel by the ball in 0..1.

    Along the rim a pixel's radiance is that of its covered part times its coverage.
    """

    radiance: FloatArray
    coverage: FloatArray


def sphere_image(
    panorama: SpectralPanorama,
    surface: TorranceSparrowSurface,
    size_px: int,
    *,
    azimuth_deg: float = 0.0,
    elevation_deg: float = 0.0,
    supersampling: int = 2,
) -> BallImage:
    """A picture of a ball that fills a square image, seen by an orthographic camera.

    Parameters
    ----------
    panorama, surface
        Light and material.
    size_px
        Height and width; the ball's diameter.
    azimuth_deg, elevation_deg
        Where the camera looks, as in `frames.camera_to_world`.
    supersampling
        Rays per pixel along each axis.
    """
    count = size_px * supersampling
    at = 2.0 * (np.arange(count) + 0.5) / count - 1.0
    right, down = np.meshgrid(at, at)
    inside: BoolArray = right**2 + down**2 < 1.0
    towards_camera = -np.sqrt(np.maximum(1.0 - right**2 - down**2, 0.0))
    rotation = camera_to_world(azimuth_deg, elevation_deg)
    normals = np.stack([right, down, towards_camera], -1) @ rotation.T
    radiance = np.zeros((count, count, len(WAVELENGTHS_NM)))
    radiance[inside] = reflected_radiance(panorama, surface, normals[inside], -rotation[:, 2])
    pixels = (size_px, supersampling, size_px, supersampling)
    return BallImage(radiance.reshape(*pixels, -1).mean((1, 3)), inside.reshape(pixels).mean((1, 3)))


# ---------------------------------------------------------------- the three terms


def _joint_weights(panorama: SpectralPanorama) -> tuple[FloatArray, FloatArray]:
    """Weights (H, W, J) and spectra (J, 61) of all bases together: those of other bases are zero at a texel."""
    count, own = panorama.bases.shape[:2]
    bases = resample(panorama.wavelengths_nm, panorama.bases, name="the panorama's basis")
    weights = np.zeros((*panorama.basis_index.shape, count, own))
    np.put_along_axis(
        weights, panorama.basis_index[..., None, None].astype(int), panorama.weights[..., None, :], 2
    )
    weights = weights.reshape(*panorama.basis_index.shape, -1)
    used = weights.any((0, 1))
    return weights[..., used], bases.reshape(count * own, -1)[used]


def _irradiance(weights: FloatArray, normals: FloatArray) -> FloatArray:
    """Weights (P, J) of the irradiance on surfaces of normals (P, 3)."""
    directions, light = _texels(weights, _DIFFUSE_ROWS)
    block = max(1, _MOST_NUMBERS // len(directions))
    parts = [
        np.maximum(normals[start : start + block] @ directions.T, 0.0) @ light
        for start in range(0, len(normals), block)
    ]
    return np.concatenate(parts) if parts else np.zeros((0, light.shape[1]))


def _lobe(
    weights: FloatArray,
    bases: FloatArray,
    surface: TorranceSparrowSurface,
    normals: FloatArray,
    views: FloatArray,
) -> FloatArray:
    """Integral of D G F E / cos(theta_r) at points of normals and views (P, 3): (P, 61)."""
    rows = max(_DIFFUSE_ROWS, math.ceil(_STEPS_IN_GAMMA * math.pi / surface.gamma_rad))
    directions, light = _texels(weights, rows)
    fresnel = surface.fresnel((np.arange(_ANGLES) + 0.5) / _ANGLES)
    reach = surface.gamma_rad * math.sqrt(-math.log2(_NEGLIGIBLE))
    least = math.cos(min(reach, math.pi / 2))
    radiance = np.zeros((len(normals), bases.shape[1]))
    for number, (normal, view) in enumerate(zip(normals, views, strict=True)):
        incidence = directions @ normal
        half = np.sqrt(np.maximum(0.5 + 0.5 * (directions @ view), 1e-12))  # V.Q = L.Q
        facet = (incidence + normal @ view) / (2.0 * half)
        near = np.flatnonzero((facet > least) & (incidence > 0))
        incidence, half, facet, reflection = incidence[near], half[near], facet[near], float(normal @ view)
        share = facet_distribution(facet, surface.gamma_rad)
        share *= groove_shadowing(facet, incidence, np.asarray(reflection), half)
        share /= reflection if surface.denominator == "reflection" else incidence
        angle = np.minimum((half * _ANGLES).astype(int), _ANGLES - 1)
        collected = [np.bincount(angle, share * column, _ANGLES) for column in light[near].T]
        radiance[number] = np.einsum("ja,jl,al->l", np.array(collected), bases, fresnel, optimize=True)
    return radiance


# ---------------------------------------------------------------- the panorama as a sum of directions


def _texels(weights: FloatArray, rows: int) -> tuple[FloatArray, FloatArray]:
    """Directions (T, 3) and weights times solid angle (T, J) of a panorama at about a number of rows, not fewer.

    Texels averaged together stand in the direction of their weights' centroid, so that no lamp moves.
    """
    height, width = weights.shape[:2]
    if height < rows:
        fine = math.ceil(rows / height)
        height, width = height * fine, width * fine
        directions = _directions(height, width)
        light = _interpolated(weights, directions) * panorama_solid_angles(height, width)[..., None]
        return directions.reshape(-1, 3), light.reshape(-1, light.shape[-1])
    factor = max(f for f in range(1, height // rows + 1) if height % f == 0 and width % f == 0)
    light = weights * panorama_solid_angles(height, width)[..., None]
    share = np.abs(light).sum(-1, keepdims=True)
    share += 1e-9 * share.mean() + 1e-30  # where it is dark, the middle
    blocks = (height // factor, factor, width // factor, factor, -1)
    directions = (share * _directions(height, width)).reshape(blocks).sum((1, 3)).reshape(-1, 3)
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    return directions, light.reshape(blocks).sum((1, 3)).reshape(len(directions), -1)


def _directions(height: int, width: int) -> FloatArray:
    columns, rows = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    return equirectangular_to_direction(np.stack([columns, rows], -1), height, width)


def _interpolated(weights: FloatArray, directions: FloatArray) -> FloatArray:
    """Weights (..., J) in directions (..., 3), linear between the centres of texels."""
    height, width = weights.shape[:2]
    column, row = np.moveaxis(direction_to_equirectangular(directions, height, width) - 0.5, -1, 0)
    left, top = np.floor(column).astype(int), np.floor(row).astype(int)
    across, along = (column - left)[..., None], (row - top)[..., None]
    rows = [np.clip(top + step, 0, height - 1) for step in (0, 1)]
    columns = [(left + step) % width for step in (0, 1)]
    upper, lower = ((1 - across) * weights[r, columns[0]] + across * weights[r, columns[1]] for r in rows)
    return np.asarray((1 - along) * upper + along * lower)

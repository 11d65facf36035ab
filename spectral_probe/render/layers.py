"""A panorama as three non-negative light layers: what the world's R, G and B hold in the light-basis passes.

The panorama's spectra are first reduced to the three-dimensional space that holds most of their energy, then written in
the corners of a tight triangular cone round them. Only the weights must be non-negative, because Cycles
samples light by them; a corner's spectrum may be signed.
"""

from __future__ import annotations

import cv2
import numpy as np

from ..errors import RenderError
from ..model import FloatArray, SpectralPanorama
from ..render_model import LightLayers
from ..spectra.colorimetry import colour_matching_functions, delta_e_2000, white_xyz
from ..spectra.grid import STEP_NM, WAVELENGTHS_NM, resample
from ..spectra.library import surface_reflectances

_NEGLIGIBLE = 1e-5
"""Share of the luminous energy that may fall outside the cone, darkest first: noise in the dark must not widen it."""

_MARGIN = 1e-3
"""The triangle is widened by this share: OpenCV computes it in single precision."""

_COLOUR_WEIGHT = 1e4
"""How much more a difference counts that changes tristimulus values than one that does not. So large that three layers give
every direction its own colour, dim ones beside bright windows too."""

_TRACE = 1e-9
"""Share of smooth spectra added to the panorama's energy, see `light_layers`."""
_COMPARED_WIDTH = 256
"""Width in texels at which the layers' colours are compared with the panorama's."""

_SMALLEST_EXTENT = 0.02
"""Extent of the triangle where all light has (nearly) one colour, in units of the chromaticity plane."""


def light_layers(panorama: SpectralPanorama, components: FloatArray | None = None) -> LightLayers:
    """Three light layers of a panorama.

    Parameters
    ----------
    panorama
        Any number of bases and of weights. With one basis of three weights the layers are exact.
    components
        (L, 3) the space of spectra that the layers hold, as `strongest_components` gives it; None takes that of the panorama's
        own energy.

    Returns
    -------
    LightLayers
        `weights` (H, W, 3) >= 0, zero where the panorama is black; `spectra` (3, 61), each of luminance (radiance times
        y-bar summed over nm) equal to the panorama's mean luminance, so that weights are near 1 whatever the panorama's unit;
        `residual` the share of spectral energy lost to the reduction to rank 3 and to clipping.

    Raises
    ------
    RenderError
        If the panorama holds no light.

    Notes
    -----
    Energy is weighted by solid angle, and by what of it the eye sees, since three layers of a panorama with more kinds of
    light must forget something and should forget what is not seen: every direction keeps its tristimulus values, and what is
    lost shows only in surfaces' colours.
    """
    bases = resample(panorama.wavelengths_nm, panorama.bases, name="the panorama's basis")
    solid_angle = _solid_angles(panorama.weights.shape[0])
    root = visual_root()
    moment = _second_moment(panorama, bases, solid_angle)
    total = float(np.trace(moment))
    if not total > 0:
        raise RenderError("The panorama holds no light at all. Build the probe again.")
    matching = colour_matching_functions()
    strongest = strongest_components(moment) if components is None else components
    space = np.linalg.solve(
        root, strongest
    ).T  # (3, L) spectra, and (L, 3) what projects a spectrum onto them
    coordinates = _coordinates(panorama, bases @ (root @ strongest))

    to_luminance = space @ matching[:, 1] * STEP_NM
    luminance = coordinates @ to_luminance
    level = _mean(np.maximum(luminance, 0.0), solid_angle)
    if not level > 0:
        raise RenderError("The panorama's light is negative throughout. Build the probe again.")
    corners = _cone(coordinates, luminance, to_luminance, solid_angle)
    weights = np.maximum(coordinates @ np.linalg.inv(corners), 0.0)
    if components is None:
        lost = _lost_energy(panorama, bases, weights, corners @ space, solid_angle)
    else:  # without what clipping takes, which is quicker
        outside = np.eye(len(moment)) - root @ strongest @ space
        lost = float(np.trace(outside.T @ moment @ outside))
    return LightLayers(
        weights=(weights / level).astype(np.float32),
        spectra=corners @ space * level,
        wavelengths_nm=WAVELENGTHS_NM.copy(),
        residual=lost / total,
    )


def strongest_components(moment: FloatArray) -> FloatArray:
    """The three strongest components (L, 3), orthonormal in the metric of `visual_root`, of spectra of a second moment (L, L)."""
    root, matching = visual_root(), colour_matching_functions()
    smooth = matching @ matching.T  # takes the places that light of one or two kinds leaves empty
    trace = _TRACE * np.trace(moment) / np.trace(smooth)
    _, vectors = np.linalg.eigh(root @ (moment + trace * smooth) @ root)
    return np.asarray(vectors[:, ::-1][:, :3])


def colour_error(panorama: SpectralPanorama, layers: LightLayers) -> float:
    """How wrong the layers make the colour of surfaces in the light where they do worst: dE2000.

    Light seen directly keeps its colour; some surfaces of the library stand for what it falls on. The error is the mean over the
    worst twentieth of the panorama's luminous energy, every direction at one luminance with the white of D65. Kinds of light
    beyond three (lamps, windows, what they light, stained glasses) cannot all be held.
    """
    step = max(1, panorama.valid.shape[1] // _COMPARED_WIDTH)
    index = panorama.basis_index[::step, ::step]
    bases = resample(panorama.wavelengths_nm, panorama.bases)[index.ravel()]
    true = np.einsum("nk,nkl->nl", panorama.weights[::step, ::step].reshape(index.size, -1), bases)
    held = layers.weights[::step, ::step].reshape(-1, 3) @ layers.spectra
    matching = colour_matching_functions() * STEP_NM
    luminance = true @ matching[:, 1]
    energy = np.maximum(luminance, 0) * np.broadcast_to(_solid_angles(index.shape[0]), index.shape).ravel()
    lit = luminance > 0
    if not lit.any():
        return 0.0
    surfaces = surface_reflectances()[::4]
    seen = np.einsum("sl,lc->lsc", surfaces, matching).reshape(len(matching), -1)
    true, held = (
        0.6 * np.maximum(spectra[lit] @ seen, 0).reshape(-1, len(surfaces), 3) / luminance[lit, None, None]
        for spectra in (true, held)
    )
    difference = delta_e_2000(true, held, white_xyz()).mean(1)
    order = np.argsort(difference)[::-1]
    shares = energy[lit][order]
    worst = np.searchsorted(np.cumsum(shares), 0.05 * shares.sum()) + 1
    return float(np.average(difference[order][:worst], weights=shares[:worst]))


def _solid_angles(height: int) -> FloatArray:
    """Relative solid angle of the texels of each row of an equirectangular panorama, (H, 1), mean 1."""
    edges = np.cos(np.linspace(0.0, np.pi, height + 1))
    rows = edges[:-1] - edges[1:]
    return np.asarray(rows / rows.mean())[:, None]


def visual_root() -> FloatArray:
    """Root M^1/2 (L, L) of the metric M in which spectra are told apart: how much of a difference is seen.

    A difference counts by the eye's sensitivity at its wavelengths, not below a tenth of the highest, so that light at the
    ends of the spectrum, where reflectances of copper and gold rise, counts too; and `_COLOUR_WEIGHT` times as much where it
    changes the tristimulus values: light seen directly, or in a mirror, keeps its colour.
    """
    matching = colour_matching_functions()
    matching = matching / matching.sum(0)
    weight = np.sqrt((matching**2).sum(1))
    weight = np.maximum(weight / weight.max(), 0.1)
    seen = np.linalg.qr(matching / weight[:, None])[0]  # orthonormal, once the weight is divided out
    within = np.eye(len(weight)) + (_COLOUR_WEIGHT - 1) * seen @ seen.T
    values, vectors = np.linalg.eigh(weight[:, None] * within * weight)
    return np.asarray((vectors * np.sqrt(values)) @ vectors.T)


def _mean(values: FloatArray, solid_angle: FloatArray) -> float:
    return float((values * solid_angle).mean())


def _of_basis(panorama: SpectralPanorama, index: int) -> tuple[FloatArray, FloatArray]:
    """Mask (H, W) of the texels of a basis, and their weights (N, K) in double precision."""
    mask = panorama.basis_index == index
    return mask, panorama.weights[mask].astype(float)


def _second_moment(panorama: SpectralPanorama, bases: FloatArray, solid_angle: FloatArray) -> FloatArray:
    """Sum over texels of solid angle times the outer product of the spectrum with itself, (L, L)."""
    moment = np.zeros((bases.shape[2],) * 2)
    for index, basis in enumerate(bases):
        mask, weights = _of_basis(panorama, index)
        share = np.broadcast_to(solid_angle, mask.shape)[mask]
        moment += basis.T @ ((weights * share[:, None]).T @ weights) @ basis
    return moment


def _coordinates(panorama: SpectralPanorama, projected_bases: FloatArray) -> FloatArray:
    """Coordinates (H, W, 3) of the texels' spectra, from the bases' own coordinates (B, K, 3)."""
    coordinates = np.zeros((*panorama.basis_index.shape, 3))
    for index, basis in enumerate(projected_bases):
        mask, weights = _of_basis(panorama, index)
        coordinates[mask] = weights @ basis
    return coordinates


def _cone(
    coordinates: FloatArray, luminance: FloatArray, to_luminance: FloatArray, solid_angle: FloatArray
) -> FloatArray:
    """Corners (3, 3) of the tightest triangular cone round the coordinates that matter, each of luminance 1.

    A spectrum of luminance 1 lies in a plane; the cone's section with it is the smallest triangle round the convex hull.
    """
    energy = np.maximum(luminance, 0.0) * solid_angle
    order = np.sort(energy, axis=None)
    dark = order[np.searchsorted(np.cumsum(order), _NEGLIGIBLE * order.sum())]
    kept = (energy >= dark) & (energy > 0)
    section = coordinates[kept] / luminance[kept][:, None]

    normal = to_luminance / np.linalg.norm(to_luminance)
    plane = np.linalg.svd(normal[None])[2][1:]  # (2, 3) orthonormal directions of constant luminance
    points = section @ plane.T
    triangle = _enclosing_triangle(points)
    return triangle @ plane + to_luminance / (to_luminance @ to_luminance)


def _enclosing_triangle(points: FloatArray) -> FloatArray:
    """Corners (3, 2) of a small triangle that encloses points (N, 2) with a little room."""
    centre = (points.min(0) + points.max(0)) / 2
    extent = max(float(np.ptp(points, axis=0).max()), 1e-12)
    scale = max(extent, _SMALLEST_EXTENT * max(float(np.abs(centre).max()), 1e-3))
    unit = (points - centre) / scale
    square = np.array([[-1, -1], [-1, 1], [1, -1], [1, 1]]) * 0.003
    hull = cv2.convexHull(unit.astype(np.float32)).reshape(-1, 2)
    # A small square about every corner of the hull keeps thin hulls (two kinds of light) from a flat triangle.
    thick = (hull[:, None] + square).reshape(-1, 2).astype(np.float32)
    try:
        area, found = cv2.minEnclosingTriangle(thick[:, None])
    except cv2.error:  # it fails on some hulls that are nearly a square: light of one colour
        area, found = 0.0, None
    triangle = _widened(np.asarray(found, float).reshape(3, 2)) if found is not None and area > 0 else None
    if triangle is None or not _encloses(triangle, hull):
        (x, y), half = (thick.min(0) + thick.max(0)) / 2, float(np.ptp(thick, axis=0).max())
        triangle = np.array([[x, y + 2 * half], [x - 2 * half, y - half], [x + 2 * half, y - half]])
    return np.asarray(triangle * scale + centre)


def _widened(triangle: FloatArray) -> FloatArray:
    centre = triangle.mean(0)
    return centre + (1 + _MARGIN) * (triangle - centre)


def _encloses(triangle: FloatArray, points: FloatArray) -> bool:
    system = np.vstack([triangle.T, np.ones(3)])
    if abs(np.linalg.det(system)) < 1e-9:
        return False
    barycentric = np.linalg.solve(system, np.vstack([points.T, np.ones(len(points))]))
    return bool(barycentric.min() >= 0)


def _lost_energy(
    panorama: SpectralPanorama,
    bases: FloatArray,
    weights: FloatArray,
    spectra: FloatArray,
    solid_angle: FloatArray,
) -> float:
    """Solid angle times squared difference between the panorama's spectra and the layers' sum, over all texels.

    By Gram matrices: no texel's 61 samples are ever formed.
    """
    lost = 0.0
    for index, basis in enumerate(bases):
        mask, own = _of_basis(panorama, index)
        joint = np.concatenate([own, -weights[mask]], axis=1)
        stacked = np.concatenate([basis, spectra])
        share = np.broadcast_to(solid_angle, mask.shape)[mask]
        lost += float((share * ((joint @ (stacked @ stacked.T)) * joint).sum(1)).sum())
    return max(lost, 0.0)

"""A panorama as three non-negative light layers: what the world's R, G and B hold in the light-basis passes.

The panorama's spectra are first reduced to the three-dimensional space that holds most of their energy, then written in
the corners of a tight triangular cone round them. Only the weights must be non-negative, because Cycles
samples light by them; a corner's spectrum may be signed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from ..errors import RenderError
from ..large import let_go, strips
from ..model import BoolArray, FloatArray, SpectralPanorama
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
    root = visual_root()
    moment = np.zeros((bases.shape[2],) * 2)
    for part in _parts(panorama):
        moment += _second_moment(part, bases)
    total = float(np.trace(moment))
    if not total > 0:
        raise RenderError("The panorama holds no light at all. Build the probe again.")
    matching = colour_matching_functions()
    strongest = strongest_components(moment) if components is None else components
    space = np.linalg.solve(
        root, strongest
    ).T  # (3, L) spectra, and (L, 3) what projects a spectrum onto them
    projected = bases @ (root @ strongest)
    to_luminance = space @ matching[:, 1] * STEP_NM
    level = sum(
        float((np.maximum(_coordinates(part, projected) @ to_luminance, 0.0) * part.solid_angle).sum())
        for part in _parts(panorama)
    )
    level /= panorama.valid.size
    if not level > 0:
        raise RenderError("The panorama's light is negative throughout. Build the probe again.")
    corners = _cone(panorama, projected, to_luminance)
    to_weights = np.linalg.inv(corners)
    weights = np.empty((*panorama.valid.shape, 3), np.float32)
    lost = 0.0
    for part in _parts(panorama):
        own = np.maximum(_coordinates(part, projected) @ to_weights, 0.0)
        weights[part.rows] = own / level
        if components is None:
            lost += _lost_energy(part, bases, own, corners @ space)
    if components is not None:  # without what clipping takes, which is quicker
        outside = np.eye(len(moment)) - root @ strongest @ space
        lost = float(np.trace(outside.T @ moment @ outside))
    return LightLayers(
        weights=weights,
        spectra=corners @ space * level,
        wavelengths_nm=WAVELENGTHS_NM.copy(),
        residual=max(lost, 0.0) / total,
    )


@dataclass(frozen=True)
class _Part:
    """Some rows of a panorama: weights (h, W, K), numbers of the bases (h, W), relative solid angles (h, 1)."""

    rows: slice
    weights: FloatArray
    basis_index: npt.NDArray[np.uint8]
    solid_angle: FloatArray

    def of_basis(self, index: int) -> tuple[BoolArray, FloatArray]:
        """Mask (h, W) of the texels of a basis, and their weights (N, K) in double precision."""
        mask = self.basis_index == index
        return mask, self.weights[mask].astype(float)


def _parts(panorama: SpectralPanorama) -> Iterator[_Part]:
    """The panorama strip by strip: what is worked out in double precision must not be as large as all of it."""
    solid_angle = _solid_angles(panorama.valid.shape[0])
    for rows in strips(*panorama.valid.shape):
        yield _Part(rows, panorama.weights[rows], panorama.basis_index[rows], solid_angle[rows])
        let_go(panorama.weights)


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


def _second_moment(part: _Part, bases: FloatArray) -> FloatArray:
    """Sum over texels of solid angle times the outer product of the spectrum with itself, (L, L)."""
    moment = np.zeros((bases.shape[2],) * 2)
    for index, basis in enumerate(bases):
        mask, weights = part.of_basis(index)
        share = np.broadcast_to(part.solid_angle, mask.shape)[mask]
        moment += basis.T @ ((weights * share[:, None]).T @ weights) @ basis
    return moment


def _coordinates(part: _Part, projected_bases: FloatArray) -> FloatArray:
    """Coordinates (h, W, 3) of the texels' spectra, from the bases' own coordinates (B, K, 3)."""
    coordinates = np.zeros((*part.basis_index.shape, 3))
    for index, basis in enumerate(projected_bases):
        mask, weights = part.of_basis(index)
        coordinates[mask] = weights @ basis
    return coordinates


def _cone(panorama: SpectralPanorama, projected: FloatArray, to_luminance: FloatArray) -> FloatArray:
    """Corners (3, 3) of the tightest triangular cone round the coordinates that matter, each of luminance 1.

    A spectrum of luminance 1 lies in a plane; the cone's section with it is the smallest triangle round the convex hull.
    """
    energies = np.empty(panorama.valid.size)
    width = panorama.valid.shape[1]
    for part in _parts(panorama):
        luminance = _coordinates(part, projected) @ to_luminance
        energy = np.maximum(luminance, 0.0) * part.solid_angle
        energies[part.rows.start * width : part.rows.stop * width] = energy.ravel()
    energies.sort()
    summed = np.cumsum(energies)
    dark = energies[np.searchsorted(summed, _NEGLIGIBLE * energies.sum())]
    del energies, summed
    normal = to_luminance / np.linalg.norm(to_luminance)
    plane = np.linalg.svd(normal[None])[2][1:]  # (2, 3) orthonormal directions of constant luminance

    def points() -> Iterator[FloatArray]:
        for part in _parts(panorama):
            coordinates = _coordinates(part, projected)
            luminance = coordinates @ to_luminance
            energy = np.maximum(luminance, 0.0) * part.solid_angle
            kept = (energy >= dark) & (energy > 0)
            if kept.any():
                yield (coordinates[kept] / luminance[kept][:, None]) @ plane.T

    triangle = _enclosing_triangle(points)
    return triangle @ plane + to_luminance / (to_luminance @ to_luminance)


def _enclosing_triangle(points: Callable[[], Iterable[FloatArray]]) -> FloatArray:
    """Corners (3, 2) of a small triangle that encloses points with a little room; they come in parts (N, 2), twice."""
    ends = [(part.min(0), part.max(0)) for part in points()]
    low, high = np.min([low for low, _ in ends], axis=0), np.max([high for _, high in ends], axis=0)
    centre = (low + high) / 2
    extent = max(float((high - low).max()), 1e-12)
    scale = max(extent, _SMALLEST_EXTENT * max(float(np.abs(centre).max()), 1e-3))
    square = np.array([[-1, -1], [-1, 1], [1, -1], [1, 1]]) * 0.003
    hulls = [cv2.convexHull(((part - centre) / scale).astype(np.float32)) for part in points()]
    hull = np.asarray(hulls[0] if len(hulls) == 1 else cv2.convexHull(np.concatenate(hulls))).reshape(-1, 2)
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


def _lost_energy(part: _Part, bases: FloatArray, weights: FloatArray, spectra: FloatArray) -> float:
    """Solid angle times squared difference between the panorama's spectra and the layers' sum, over all texels.

    By Gram matrices: no texel's 61 samples are ever formed.
    """
    lost = 0.0
    for index, basis in enumerate(bases):
        mask, own = part.of_basis(index)
        joint = np.concatenate([own, -weights[mask]], axis=1)
        stacked = np.concatenate([basis, spectra])
        share = np.broadcast_to(part.solid_angle, mask.shape)[mask]
        lost += float((share * ((joint @ (stacked @ stacked.T)) * joint).sum(1)).sum())
    return lost

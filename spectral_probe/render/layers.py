"""A panorama as three non-negative light layers: what the world's R, G and B hold in the light-basis passes.

The panorama's spectra are first reduced to the three-dimensional space that holds most of their energy, then written in
the corners of a tight triangular cone round them. Only the weights must be non-negative, because Cycles
samples light by them; a corner's spectrum may be signed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from ..errors import RenderError
from ..large import let_go
from ..model import FloatArray, IntArray, SpectralPanorama
from ..parallel import in_order, product, row_blocks, summed_product
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
    moment = sum(_over(panorama, lambda part: _second_moment(part, bases)), np.zeros((bases.shape[2],) * 2))
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
    energies = _energies(panorama, projected, to_luminance)
    level = float(energies.sum()) / energies.size
    if not level > 0:
        raise RenderError("The panorama's light is negative throughout. Build the probe again.")
    corners = _cone(panorama, projected, to_luminance, _darkest(energies))
    del energies
    to_weights = np.linalg.inv(corners)
    spectra = corners @ space
    weights = np.empty((*panorama.valid.shape, 3), np.float32)

    def weigh(part: _Part) -> float:
        own = np.maximum(product(to_weights.T, _coordinates(part, projected)), 0.0)
        weights[part.rows] = (own / level).T.reshape(*part.basis_index.shape, 3)
        return _lost_energy(part, bases, own, spectra) if components is None else 0.0

    lost = sum(_over(panorama, weigh))
    if components is not None:  # without what clipping takes, which is quicker
        outside = np.eye(len(moment)) - root @ strongest @ space
        lost = float(np.trace(outside.T @ moment @ outside))
    return LightLayers(
        weights=weights,
        spectra=spectra * level,
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

    @property
    def solid_angles(self) -> FloatArray:
        """Of each texel, (P,)."""
        return np.broadcast_to(self.solid_angle, self.basis_index.shape).ravel()

    def by_basis(self) -> Iterator[tuple[int, IntArray, FloatArray]]:
        """Number of a basis, numbers (N,) of its texels, and their weights (K, N) in double precision."""
        weights = self.weights.reshape(self.basis_index.size, -1)
        for basis in np.unique(self.basis_index):
            chosen = np.flatnonzero(self.basis_index == basis)
            yield int(basis), chosen, weights[chosen].T.astype(float, order="C")


def _over[Result](panorama: SpectralPanorama, work: Callable[[_Part], Result]) -> Iterator[Result]:
    """Results of work on a panorama, from the top: in double precision no more of it than fits the processors' caches."""
    height, width = panorama.valid.shape
    solid_angle = _solid_angles(height)

    def of_rows(rows: slice) -> Result:
        part = _Part(rows, panorama.weights[rows], panorama.basis_index[rows], solid_angle[rows])
        result = work(part)
        let_go(panorama.weights)
        return result

    return in_order(of_rows, row_blocks(width, height))


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
    solid_angles = part.solid_angles
    for basis, chosen, weights in part.by_basis():
        moment += bases[basis].T @ summed_product(weights * solid_angles[chosen], weights) @ bases[basis]
    return moment


def _coordinates(part: _Part, projected: FloatArray) -> FloatArray:
    """Coordinates (3, P) of the texels' spectra, from the bases' own coordinates (B, K, 3)."""
    coordinates = np.empty((3, part.basis_index.size))
    for basis, chosen, weights in part.by_basis():
        coordinates[:, chosen] = product(projected[basis].T, weights)
    return coordinates


def _energies(panorama: SpectralPanorama, projected: FloatArray, to_luminance: FloatArray) -> FloatArray:
    """Luminance times relative solid angle of every texel, (P,)."""
    energies = np.empty(panorama.valid.size)
    width = panorama.valid.shape[1]

    def find(part: _Part) -> None:
        luminance = product(to_luminance[None], _coordinates(part, projected))[0]
        energies[part.rows.start * width : part.rows.stop * width] = _energy(part, luminance)

    for _ in _over(panorama, find):
        pass
    return energies


def _energy(part: _Part, luminance: FloatArray) -> FloatArray:
    return np.maximum(luminance, 0.0) * part.solid_angles


def _darkest(energies: FloatArray) -> float:
    """The least energy that counts: what is darker has a negligible share of all. The energies come back sorted."""
    energies.sort()
    summed = np.cumsum(energies)
    return float(energies[np.searchsorted(summed, _NEGLIGIBLE * summed[-1])])


def _cone(
    panorama: SpectralPanorama, projected: FloatArray, to_luminance: FloatArray, darkest: float
) -> FloatArray:
    """Corners (3, 3) of the tightest triangular cone round the coordinates that matter, each of luminance 1.

    A spectrum of luminance 1 lies in a plane; the cone's section with it is the smallest triangle round the convex hull.
    """
    normal = to_luminance / np.linalg.norm(to_luminance)
    plane = np.linalg.svd(normal[None])[2][1:]  # (2, 3) orthonormal directions of constant luminance

    def hull(part: _Part) -> FloatArray:
        coordinates = _coordinates(part, projected)
        luminance = product(to_luminance[None], coordinates)[0]
        energy = _energy(part, luminance)
        kept = (energy >= darkest) & (energy > 0)
        return _hull((product(plane, coordinates[:, kept]) / luminance[kept]).T)

    triangle = _enclosing_triangle(np.concatenate(list(_over(panorama, hull))))
    return triangle @ plane + to_luminance / (to_luminance @ to_luminance)


def _hull(points: FloatArray) -> FloatArray:
    """Those of the points (N, 2) that are corners of their convex hull."""
    if len(points) < 3:
        return points
    low, high = points.min(0), points.max(0)
    scaled = (points - (low + high) / 2) / max(float((high - low).max()), 1e-12)
    corners = cv2.convexHull(scaled.astype(np.float32), returnPoints=False).ravel()
    return np.asarray(points[corners])


def _enclosing_triangle(points: FloatArray) -> FloatArray:
    """Corners (3, 2) of a small triangle that encloses points (N, 2) with a little room."""
    low, high = points.min(0), points.max(0)
    centre = (low + high) / 2
    extent = max(float((high - low).max()), 1e-12)
    scale = max(extent, _SMALLEST_EXTENT * max(float(np.abs(centre).max()), 1e-3))
    square = np.array([[-1, -1], [-1, 1], [1, -1], [1, 1]]) * 0.003
    hull = cv2.convexHull(((points - centre) / scale).astype(np.float32)).reshape(-1, 2)
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


def _lost_energy(part: _Part, bases: FloatArray, held: FloatArray, spectra: FloatArray) -> float:
    """Solid angle times squared difference between the panorama's spectra and the layers' sum, over all texels.

    By Gram matrices: no texel's 61 samples are ever formed. `held` (3, P) are the layers' weights, `spectra` (3, L) theirs.
    """
    lost = 0.0
    solid_angles = part.solid_angles
    for basis, chosen, weights in part.by_basis():
        joint = np.concatenate([weights, -held[:, chosen]])
        stacked = np.concatenate([bases[basis], spectra])
        lost += float(((product(stacked @ stacked.T, joint) * joint).sum(0) * solid_angles[chosen]).sum())
    return lost

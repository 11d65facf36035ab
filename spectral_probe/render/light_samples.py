"""A picture of random pixels, by which the errors of a plan are predicted before anything is rendered.

A pixel sees light of one or two paths: each a product of one to three of the scene's reflectances, under the light of one
direction of the panorama (a mirror's) or the mean of several (a rough surface's), or of a lamp. What is exact about it, and
what light layers and few wavelengths make of it, are both known. The picture is exposed as `compare` exposes one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..errors import RenderError
from ..geometry.frames import panorama_solid_angles
from ..model import BoolArray, FloatArray, SpectralPanorama
from ..render_model import EmissionGroup, LightSet
from ..spectra.colorimetry import (
    colour_matching_functions,
    delta_e_2000,
    panorama_xyz,
    spectra_to_xyz,
    white_xyz,
)
from ..spectra.edits import stacks_of
from ..spectra.grid import STEP_NM, resample
from .interpolation import path_shares, random_products

PIXELS = 2000
"""Pixels of the picture."""

_DIRECTIONS_MIXED = (1, 1, 4, 16, 64)
"""How many directions' light meets on a surface; each equally often."""

_DARKEST = 1e-3
"""Directions darker than this share of the mean luminance are not drawn by their size: what is recovered there is noise."""

_EMISSION_SHARE = 1.0 / 3.0
"""Share of the paths that come from lamps and emitting materials, where there are any."""

_WHITE_PERCENTILE = 95.0


@dataclass(frozen=True)
class LightSamples:
    """Random lights of a scene, each of luminance 1.

    Parameters
    ----------
    spectra
        (N, L) the true light.
    held
        (N, G, 3) what the channels of each light set, and then of each emission group, hold of it.
    """

    spectra: FloatArray
    held: FloatArray


def light_samples(
    panorama: SpectralPanorama,
    sets: Sequence[LightSet],
    count: int,
    seed: int,
    emission: Sequence[EmissionGroup] = (),
    within: BoolArray | None = None,
) -> LightSamples:
    """Lights of directions of a panorama and of mixtures of them, and of lamps.

    A third of the directions are drawn by the luminous energy that comes from them, a third by their size, and a third so that
    each glass and lamp that was put into the panorama (its edits) is drawn as often as another, and as all other light: somebody
    wants to see them. `within` (H, W) leaves out the other directions.

    Raises
    ------
    RenderError
        If the panorama holds no light there.
    """
    generator = np.random.default_rng(seed + 500)
    texels, starts = drawn_texels(panorama, count, seed, within)
    spectra = np.add.reduceat(spectra_of_texels(panorama, texels), starts)
    held = np.zeros((count, len(sets) + len(emission), 3))
    for number, light in enumerate(sets):
        weights = light.layers.weights.reshape(-1, 3)[texels].astype(float)
        held[:, number] = np.add.reduceat(weights, starts)
    shining = [group for group in emission if np.any(group.spectra)]
    if shining:
        lamps = np.flatnonzero(generator.random(count) < _EMISSION_SHARE)
        held[lamps], spectra[lamps] = 0.0, 0.0
        for lamp in lamps.tolist():
            number = int(generator.integers(len(emission)))
            held[lamp, len(sets) + number] = generator.dirichlet(np.ones(3))
            spectra[lamp] = held[lamp, len(sets) + number] @ emission[number].spectra
    luminance = spectra @ colour_matching_functions()[:, 1] * STEP_NM
    seen = luminance > 1e-9 * luminance.max()  # no eye sees the others
    if not seen.any():
        raise RenderError("The panorama holds no light that is seen. Build the probe again.")
    kept = np.flatnonzero(seen)[np.arange(count) % seen.sum()]
    return LightSamples(spectra[kept] / luminance[kept, None], held[kept] / luminance[kept, None, None])


def spectra_of_texels(panorama: SpectralPanorama, texels: npt.NDArray[np.intp]) -> FloatArray:
    """Spectra (N, 61) of some texels, by their flat index."""
    bases = resample(panorama.wavelengths_nm, panorama.bases, name="the panorama's basis")
    index = panorama.basis_index.ravel()[texels]
    weights = panorama.weights.reshape(-1, panorama.weights.shape[-1])[texels].astype(float)
    spectra = np.empty((len(texels), bases.shape[-1]))
    for number in np.unique(index).tolist():
        uses = index == number
        spectra[uses] = weights[uses] @ bases[number]
    return spectra


def drawn_texels(
    panorama: SpectralPanorama, count: int, seed: int, within: BoolArray | None = None
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Flat indices (M,) of random texels, and where among them those of each of (count,) lights start.

    Raises
    ------
    RenderError
        If the panorama holds no light there.
    """
    mixed = np.array(_DIRECTIONS_MIXED)[np.arange(count) % len(_DIRECTIONS_MIXED)]
    texels = _drawn_directions(panorama, int(mixed.sum()), np.random.default_rng(seed), within)
    return texels, np.concatenate([[0], np.cumsum(mixed)[:-1]])


def _drawn_directions(
    panorama: SpectralPanorama, count: int, generator: np.random.Generator, within: BoolArray | None
) -> npt.NDArray[np.intp]:
    luminance = np.maximum(panorama_xyz(panorama)[..., 1].astype(float), 0.0)
    if within is not None:
        luminance = luminance * within
    size = np.broadcast_to(panorama_solid_angles(*luminance.shape), luminance.shape)
    energy = luminance * size
    if not energy.sum() > 0:
        raise RenderError("The panorama holds no light that is seen. Build the probe again.")
    lit = luminance > _DARKEST * energy.sum() / size[luminance > 0].sum()
    stacks = [stack[1:] for stack in stacks_of(panorama)]
    edit = np.array([stacks.index(stack) for stack in stacks])[panorama.basis_index]
    of_edit = np.bincount(edit.ravel(), energy.ravel())
    edits = energy / np.where(of_edit > 0, of_edit, 1.0)[edit]
    drawn = []
    for way, share in enumerate((energy, size * lit, edits)):
        number = len(range(way, count, 3))
        cumulative = np.cumsum(share.ravel())
        found = np.searchsorted(cumulative, generator.random(number) * cumulative[-1], side="right")
        drawn.append(np.minimum(found, len(cumulative) - 1))
    return generator.permutation(np.concatenate(drawn))


@dataclass(frozen=True)
class Picture:
    """Random pixels of a scene.

    Parameters
    ----------
    transports
        (J, N, L) products of reflectances along each of J paths, times its share.
    lights
        The light at the end of each path.
    """

    transports: FloatArray
    lights: tuple[LightSamples, ...]

    @property
    def spectra(self) -> FloatArray:
        """True spectral radiance of the pixels, (N, L)."""
        return np.asarray(
            sum(
                transport * light.spectra
                for transport, light in zip(self.transports, self.lights, strict=True)
            )
        )

    def layer_transports(self, group: int) -> FloatArray:
        """Transport (N, 3, L) of the channels of a light set, or of an emission group: what a render of them shows."""
        return np.asarray(
            sum(
                transport[:, None] * light.held[:, group, :, None]
                for transport, light in zip(self.transports, self.lights, strict=True)
            )
        )

    def held_spectra(self, spectra: Sequence[FloatArray]) -> FloatArray:
        """Radiance (N, L) of the pixels with groups of the given spectra (3, L): at all wavelengths, but in layers."""
        return np.asarray(
            sum(
                transport * np.einsum("ngc,gcl->nl", light.held, np.stack(spectra))
                for transport, light in zip(self.transports, self.lights, strict=True)
            )
        )

    def layers_errors(self, sets: Sequence[LightSet]) -> FloatArray:
        """DE2000 (N,) of the pixels with the light in the layers of these sets, rendered at all wavelengths."""
        return self.errors(spectra_to_xyz(self.held_spectra([light.layers.spectra for light in sets])))

    def errors(self, estimate_xyz: FloatArray) -> FloatArray:
        """DE2000 (N,) of tristimulus values (N, 3) from those of the pixels.

        The white is D65 with the luminance of the 95th percentile of the pixels, as in `compare`.
        """
        return exposed_errors(spectra_to_xyz(self.spectra), estimate_xyz)


def exposed_errors(exact_xyz: FloatArray, estimate_xyz: FloatArray) -> FloatArray:
    """DE2000 (N,) of tristimulus values (N, 3) of random pixels, exposed as `compare` exposes a picture."""
    white = white_xyz() * np.percentile(exact_xyz[:, 1], _WHITE_PERCENTILE)
    return delta_e_2000(np.maximum(exact_xyz, 0.0), np.maximum(estimate_xyz, 0.0), white)


def largest_error(errors: FloatArray) -> float:
    """What is meant by the largest error of random pixels: 99 of 100 are within it.

    The very largest of a sample grows with the sample's size, and with the noise of single texels; this does not.

    Examples
    --------
    >>> largest_error(np.arange(101.0))
    99.0
    """
    return float(np.percentile(errors, 99.0))


def random_picture(
    panorama: SpectralPanorama,
    sets: Sequence[LightSet],
    reflectances: FloatArray,
    seed: int,
    emission: Sequence[EmissionGroup] = (),
    within: BoolArray | None = None,
    count: int = PIXELS,
) -> Picture:
    """A picture of `count` random pixels; see `light_samples` for the light, and `with_white` for the reflectances."""
    surfaces = with_white(reflectances)
    shares = path_shares(count, seed)
    products = [random_products(surfaces, count, seed + 1 + path) for path in range(len(shares))]
    lights = tuple(
        light_samples(panorama, sets, count, seed + 101 + path, emission, within)
        for path in range(len(shares))
    )
    return Picture(np.stack(products) * shares[..., None], lights)


def with_white(reflectances: FloatArray) -> FloatArray:
    """Reflectances (N, 61) and a constant: light seen directly, and white surfaces."""
    size = len(colour_matching_functions())
    return np.concatenate([np.ones((1, size)), np.asarray(reflectances, float).reshape(-1, size)])

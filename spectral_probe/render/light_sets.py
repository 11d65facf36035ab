"""Light sets: the panorama split by direction, so that three layers hold the light of each part.

Three layers hold every direction's tristimulus values, but surfaces show more of a spectrum than those. Where what three layers
forget would be seen in the scene's own surfaces, the directions are split into groups, each close to a three-dimensional space
of spectra of its own (k-subspaces clustering: Bradley and Mangasarian, k-Plane Clustering, J. Global Optimization 16, 2000,
doi:10.1023/A:1008324625522). Regions whose lamp or glass is to be exchanged after rendering have layers of their own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ..errors import RenderError
from ..model import BoolArray, FloatArray, SpectralPanorama
from ..render_model import LightLayers, LightSet
from ..spectra.colorimetry import colour_matching_functions, panorama_xyz, spectra_to_xyz
from ..spectra.grid import WAVELENGTHS_NM, resample
from .interpolation import path_shares, random_products
from .layers import light_layers, strongest_components, visual_root
from .light_samples import (
    PIXELS,
    drawn_texels,
    exposed_errors,
    largest_error,
    light_samples,
    spectra_of_texels,
    with_white,
)
from .region_layers import Region, region_sets

MOST_SETS = 4
"""More sets would leave each too few samples."""

LAYERS_SHARE = 0.8
"""Share of the error bound that the light's layers may take. Both errors add about in squares, and leave 0.6 for the wavelengths:
one of those costs a sixteenth of a render, a further set ten times as much."""

_REPRESENTATIVES = 4000
_ROUNDS = 12
_STARTS = 8
_SEED = 11

_RANK_TOLERANCE = 1e-3
"""Share of the light's amplitude below which a further kind of light counts as none."""


def light_sets(
    panorama: SpectralPanorama,
    *,
    swappable: Mapping[str, BoolArray] | None = None,
    reflectances: FloatArray,
    max_de2000: float,
) -> tuple[LightSet, ...]:
    """The light sets of a panorama: as few as hold its light within an error bound, four at most, and those of regions.

    Parameters
    ----------
    panorama
        Any number of bases and of weights.
    swappable
        Regions (H, W) whose light is to be exchanged after rendering, by name. Where two overlap the first has the light.
    reflectances
        (N, 61) of the scene's materials: errors are judged by the colours of these surfaces.
    max_de2000
        The error bound of the whole render; `LAYERS_SHARE` of it is for the layers.

    Returns
    -------
    tuple of LightSet
        First one or more sets of light that stays, then those of the regions, up to three layers a set. There is always a set 0,
        which is black where the regions hold all light.

    Raises
    ------
    RenderError
        If the panorama, or a region, holds no light.

    Examples
    --------
    >>> weights, index = np.ones((4, 8, 1), np.float32), np.zeros((4, 8), np.uint8)
    >>> basis, sure = np.ones((1, 1, 61)), np.ones((4, 8), np.float32)
    >>> panorama = SpectralPanorama(weights, basis, index, WAVELENGTHS_NM, sure > 0, sure)
    >>> sets = light_sets(panorama, reflectances=np.full((1, 61), 0.5), max_de2000=0.5)
    >>> len(sets), sets[0].layers.weights.shape
    (1, (4, 8, 3))
    """
    bound = LAYERS_SHARE * max_de2000
    rest = np.ones(panorama.valid.shape, bool)
    regions = []
    for name, mask in (swappable or {}).items():
        own = mask & rest
        if not (panorama_xyz(panorama)[..., 1][own] > 0).any():
            raise RenderError(
                f'The swappable region "{name}" holds no light, or lies within another. Choose another region.'
            )
        rest &= ~own
        regions.append(Region(name, own))
    return (
        *_fixed_sets(panorama, rest, reflectances, bound),
        *region_sets(panorama, regions, reflectances, bound),
    )


def light_rank(panorama: SpectralPanorama, most: int = 12) -> int:
    """How many kinds of light the panorama holds: the rank of its spectra, to a thousandth of their amplitude.

    Examples
    --------
    >>> weights, index = np.ones((4, 8, 1), np.float32), np.zeros((4, 8), np.uint8)
    >>> sure = np.ones((4, 8), np.float32)
    >>> light_rank(SpectralPanorama(weights, np.ones((1, 1, 61)), index, WAVELENGTHS_NM, sure > 0, sure))
    1
    """
    spectra = light_samples(panorama, (), _REPRESENTATIVES, _SEED).spectra
    values = np.linalg.svd(spectra, compute_uv=False)
    return int(min(most, (values > _RANK_TOLERANCE * values[0]).sum()))


def of_directions(panorama: SpectralPanorama, mask: BoolArray) -> SpectralPanorama:
    """The panorama, black outside a mask (H, W)."""
    return replace(panorama, weights=np.where(mask[..., None], panorama.weights, np.float32(0.0)))


def _fixed_sets(
    panorama: SpectralPanorama, mask: BoolArray, reflectances: FloatArray, bound: float
) -> tuple[LightSet, ...]:
    """As few sets of the masked directions as keep the layers' error within the bound."""
    if not ((panorama_xyz(panorama)[..., 1] > 0) & mask).any():
        return (_black(panorama),)
    own = panorama if mask.all() else of_directions(panorama, mask)
    trial = _Trial(own, reflectances)
    components = [strongest_components(trial.unit.T @ trial.unit)]
    best, best_error = components, trial.error(components)
    while best_error > bound and len(components) < MOST_SETS:
        components = trial.one_more(components)
        error = trial.error(components)
        if error < best_error:
            best, best_error = components, error
    if len(best) == 1:
        return (LightSet(light_layers(own, best[0])),)
    groups = _groups(own, best)
    return tuple(
        LightSet(light_layers(of_directions(own, groups == number), component))
        for number, component in enumerate(best)
        if (own.weights[groups == number] != 0).any()
    )


def _black(panorama: SpectralPanorama) -> LightSet:
    """A set without light."""
    weights = np.zeros((*panorama.valid.shape, 3), np.float32)
    spectra = np.ones((3, len(WAVELENGTHS_NM)))
    return LightSet(LightLayers(weights, spectra, WAVELENGTHS_NM.copy(), 0.0))


# ---------------------------------------------------------------- groups of directions


class _Trial:
    """The light of random pixels direction by direction, for trying groups without making layers of them.

    `spectra` (M, L) are those of the directions, `seen` (M, L) the same with luminance 1 in the metric of `visual_root`.
    """

    def __init__(self, panorama: SpectralPanorama, reflectances: FloatArray) -> None:
        self.root = visual_root()
        self.back = np.linalg.inv(self.root)
        shares = path_shares(PIXELS, _SEED)
        surfaces = with_white(reflectances)
        self.transports = [
            share[:, None] * random_products(surfaces, PIXELS, _SEED + 1 + path)
            for path, share in enumerate(shares)
        ]
        drawn = [drawn_texels(panorama, PIXELS, _SEED + 101 + path) for path in range(len(shares))]
        self.starts = [starts for _, starts in drawn]
        self.lengths = [len(texels) for texels, _ in drawn]
        self.spectra = spectra_of_texels(panorama, np.concatenate([texels for texels, _ in drawn]))
        luminance = np.maximum(self.spectra @ colour_matching_functions()[:, 1], 1e-30)
        self.unit = self.spectra / luminance[:, None]
        self.seen = self.unit @ self.root
        self.exact_xyz = self._xyz(self.spectra)

    def _xyz(self, spectra: FloatArray) -> FloatArray:
        """Tristimulus values (N, 3) of the pixels, each light of luminance 1, with these spectra of the directions."""
        total = np.zeros((PIXELS, 3))
        first = 0
        for transport, starts, length in zip(self.transports, self.starts, self.lengths, strict=True):
            rows = slice(first, first + length)
            true, light = (np.add.reduceat(values[rows], starts) for values in (self.spectra, spectra))
            luminance = np.maximum(true @ colour_matching_functions()[:, 1:2], 1e-30)
            total += spectra_to_xyz(transport * light / luminance)
            first += length
        return total

    def error(self, components: Sequence[FloatArray]) -> float:
        """The largest error of the pixels where each direction's light is held by the group that holds it best."""
        group = _lost(self.seen, components).argmin(-1)
        held = np.zeros_like(self.spectra)
        for number, component in enumerate(components):
            own = group == number
            held[own] = self.spectra[own] @ (self.root @ component @ component.T @ self.back)
        return largest_error(exposed_errors(self.exact_xyz, self._xyz(held)))

    def one_more(self, components: Sequence[FloatArray]) -> list[FloatArray]:
        """Components of one more group, the best of some starts from badly held directions and those like them."""
        generator = np.random.default_rng(_SEED)
        few = slice(None, None, max(1, len(self.seen) // _REPRESENTATIVES))
        seen, unit = self.seen[few], self.unit[few]
        lost = _lost(seen, components).min(-1)
        normal = seen / np.linalg.norm(seen, axis=-1, keepdims=True)
        found, found_loss = list(components), np.inf
        for start in generator.choice(len(seen), size=_STARTS, p=lost / lost.sum()).tolist():
            nearest = np.argsort(normal @ normal[start])[-max(1, len(seen) // 20) :]
            tried = [*components, strongest_components(unit[nearest].T @ unit[nearest])]
            tried = _settled(seen, unit, tried)
            loss = float(_lost(seen, tried).min(-1).sum())
            if loss < found_loss:
                found, found_loss = tried, loss
        return found


def _settled(seen: FloatArray, unit: FloatArray, components: list[FloatArray]) -> list[FloatArray]:
    """The groups' components after some rounds of assigning directions and fitting."""
    before = np.full(len(seen), -1)
    for _ in range(_ROUNDS):
        group = _lost(seen, components).argmin(-1)
        if np.array_equal(group, before):
            break
        before = group
        components = [
            strongest_components(unit[group == number].T @ unit[group == number])
            if (group == number).any()
            else component
            for number, component in enumerate(components)
        ]
    return components


def _lost(seen: FloatArray, components: Sequence[FloatArray]) -> FloatArray:
    """Energy (N, G) of spectra in the metric that each group's three components do not hold."""
    total = (seen**2).sum(-1)
    return np.stack([total - ((seen @ component) ** 2).sum(-1) for component in components], axis=-1)


def _groups(panorama: SpectralPanorama, components: Sequence[FloatArray]) -> npt.NDArray[np.intp]:
    """Group (H, W) that holds each texel's spectrum best; no texel's 61 samples are ever formed."""
    bases = resample(panorama.wavelengths_nm, panorama.bases) @ visual_root()
    group = np.zeros(panorama.basis_index.shape, np.intp)
    for index, basis in enumerate(bases):
        mask = panorama.basis_index == index
        weights = panorama.weights[mask].astype(float)
        held = [((weights @ (basis @ component)) ** 2).sum(-1) for component in components]
        group[mask] = np.argmax(held, axis=0)
    return group

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
from ..spectra.colorimetry import panorama_xyz, spectra_to_xyz
from ..spectra.grid import WAVELENGTHS_NM, resample
from .layers import light_layers, visual_root
from .light_samples import Picture, light_samples, random_picture
from .region_layers import Region, region_sets

MOST_SETS = 4
"""More sets would leave each too few samples."""

LAYERS_SHARE = 0.5
"""Share of the error bound that the light's layers may take; the rest is for the wavelengths."""

_REPRESENTATIVES = 4000
_ROUNDS = 12
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
    values = np.linalg.svd(_representatives(panorama, None), compute_uv=False)
    return int(min(most, (values > _RANK_TOLERANCE * values[0]).sum()))


def of_directions(panorama: SpectralPanorama, mask: BoolArray) -> SpectralPanorama:
    """The panorama, black outside a mask (H, W)."""
    return replace(panorama, weights=np.where(mask[..., None], panorama.weights, np.float32(0.0)))


def layers_error(sets: Sequence[LightSet], picture: Picture) -> FloatArray:
    """DE2000 (N,) of a picture's pixels with the light in layers, rendered at all wavelengths."""
    return picture.errors(spectra_to_xyz(picture.held_spectra([light.layers.spectra for light in sets])))


def _fixed_sets(
    panorama: SpectralPanorama, mask: BoolArray, reflectances: FloatArray, bound: float
) -> tuple[LightSet, ...]:
    """As few sets of the masked directions as keep the layers' error within the bound."""
    if not ((panorama_xyz(panorama)[..., 1] > 0) & mask).any():
        return (_black(panorama),)
    own = of_directions(panorama, mask)
    found: tuple[LightSet, ...] = (LightSet(light_layers(own)),)
    error = _error(own, found, reflectances)
    if error <= bound or light_rank(own) <= len("RGB"):
        return found
    spectra = _representatives(own, mask) @ visual_root()
    projectors = [_complement(spectra)]
    for _ in range(1, MOST_SETS):
        projectors = _one_more(spectra, projectors)
        groups = _groups(own, projectors)
        tried = tuple(
            LightSet(light_layers(of_directions(own, groups == number)))
            for number in range(len(projectors))
            if (own.weights[groups == number] != 0).any()
        )
        tried_error = _error(own, tried, reflectances)
        if tried_error < error:
            found, error = tried, tried_error
        if error <= bound:
            break
    return found


def _error(panorama: SpectralPanorama, sets: Sequence[LightSet], reflectances: FloatArray) -> float:
    return float(layers_error(sets, random_picture(panorama, sets, reflectances, _SEED)).max())


def _black(panorama: SpectralPanorama) -> LightSet:
    """A set without light."""
    weights = np.zeros((*panorama.valid.shape, 3), np.float32)
    spectra = np.ones((3, len(WAVELENGTHS_NM)))
    return LightSet(LightLayers(weights, spectra, WAVELENGTHS_NM.copy(), 0.0))


# ---------------------------------------------------------------- groups of directions


def _representatives(panorama: SpectralPanorama, within: BoolArray | None) -> FloatArray:
    """Spectra (N, 61) of random directions, each of luminance 1."""
    samples = light_samples(panorama, (), _REPRESENTATIVES, _SEED, within=within)
    return samples.spectra


def _complement(spectra: FloatArray) -> FloatArray:
    """Projector (L, L) onto what the three strongest components of some spectra do not hold."""
    _, vectors = np.linalg.eigh(spectra.T @ spectra)
    strongest = vectors[:, -3:]
    return np.asarray(np.eye(len(vectors)) - strongest @ strongest.T)


def _lost(spectra: FloatArray, projectors: Sequence[FloatArray]) -> FloatArray:
    """Energy (N, G) of the spectra that each group's three components do not hold."""
    return np.stack([((spectra @ projector) ** 2).sum(-1) for projector in projectors], axis=-1)


def _one_more(spectra: FloatArray, projectors: Sequence[FloatArray]) -> list[FloatArray]:
    """Projectors of one more group, started from the worst held spectra, after some rounds of assigning and fitting."""
    lost = _lost(spectra, projectors).min(-1)
    worst = spectra[lost >= np.quantile(lost, 0.9)]
    found = [*projectors, _complement(worst)]
    before = np.full(len(spectra), -1)
    for _ in range(_ROUNDS):
        group = _lost(spectra, found).argmin(-1)
        if np.array_equal(group, before):
            break
        before = group
        found = [
            _complement(spectra[group == number]) if (group == number).any() else projector
            for number, projector in enumerate(found)
        ]
    return found


def _groups(panorama: SpectralPanorama, projectors: Sequence[FloatArray]) -> npt.NDArray[np.intp]:
    """Group (H, W) that holds each texel's spectrum best; no texel's 61 samples are ever formed."""
    bases = resample(panorama.wavelengths_nm, panorama.bases) @ visual_root()
    lost = np.zeros((len(projectors), *panorama.basis_index.shape))
    for index, basis in enumerate(bases):
        mask = panorama.basis_index == index
        weights = panorama.weights[mask].astype(float)
        for number, projector in enumerate(projectors):
            lost[number][mask] = ((weights @ (basis @ projector @ basis.T)) * weights).sum(-1)
    return lost.argmin(0)

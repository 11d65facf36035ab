"""Light layers of regions whose lamp or glass is exchanged after rendering: one to three a region, packed into sets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..model import BoolArray, FloatArray, SpectralPanorama
from ..render_model import LightLayers, LightSet
from ..spectra.colorimetry import colour_matching_functions
from ..spectra.edits import remove_edit, stacks_of
from ..spectra.grid import STEP_NM, WAVELENGTHS_NM, resample
from .layers import light_layers
from .light_samples import largest_error, random_picture

CHANNELS = 3
_SEED = 12


@dataclass(frozen=True)
class Region:
    """A swappable region: its name, and its texels (H, W)."""

    name: str
    mask: BoolArray


@dataclass(frozen=True)
class RegionLayers:
    """Layers of a region: `weights` (H, W, R), `spectra` (R, L) as it shines now, and `recovered` (R, L) without its glasses."""

    name: str
    weights: FloatArray
    spectra: FloatArray
    recovered: FloatArray


def region_sets(
    panorama: SpectralPanorama, regions: Sequence[Region], reflectances: FloatArray, bound: float
) -> tuple[LightSet, ...]:
    """Sets of the regions' layers: channels of a set belong to one region or to several, whose texels are disjoint."""
    packed: list[list[RegionLayers]] = []
    layers = [region_layers(panorama, region, reflectances, bound) for region in regions]
    for layer in sorted(layers, key=lambda one: -len(one.spectra)):
        room = (
            held for held in packed if sum(len(one.spectra) for one in held) + len(layer.spectra) <= CHANNELS
        )
        held = next(room, None)
        if held is None:
            packed.append([layer])
        else:
            held.append(layer)
    return tuple(_packed(held) for held in packed)


def _packed(held: Sequence[RegionLayers]) -> LightSet:
    """One set of up to three layers of some regions; channels left over are black."""
    height, width, _ = held[0].weights.shape
    weights = np.zeros((height, width, CHANNELS), np.float32)
    spectra, recovered = np.zeros((2, CHANNELS, len(WAVELENGTHS_NM)))
    names = [""] * CHANNELS
    channel = 0
    for layer in held:
        own = slice(channel, channel + len(layer.spectra))
        weights[..., own] = layer.weights
        spectra[own], recovered[own] = layer.spectra, layer.recovered
        names[own] = [layer.name] * len(layer.spectra)
        channel = own.stop
    layers = LightLayers(weights, spectra, WAVELENGTHS_NM.copy(), 0.0)
    first, second, third = names
    return LightSet(layers, (first, second, third), recovered)


def region_layers(
    panorama: SpectralPanorama, region: Region, reflectances: FloatArray, bound: float
) -> RegionLayers:
    """As few layers, one to three, as hold a region's light within the bound.

    Where the same glasses stand before all of the region, the layers are those of the light behind them.
    """
    masked = replace(panorama, weights=np.where(region.mask[..., None], panorama.weights, np.float32(0.0)))
    behind, transmittance = _without_glass(masked, region.mask)
    for count in range(1, CHANNELS + 1):
        weights, recovered = _layers_of(behind, count)
        layers = LightLayers(_padded(weights), _padded(recovered.T).T, WAVELENGTHS_NM.copy(), 0.0)
        if count == CHANNELS or _largest_error(behind, LightSet(layers), reflectances) <= bound:
            break
    spectra = recovered * transmittance
    return RegionLayers(region.name, weights, spectra, recovered)


def _largest_error(panorama: SpectralPanorama, light: LightSet, reflectances: FloatArray) -> float:
    picture = random_picture(panorama, (light,), reflectances, _SEED)
    return largest_error(picture.layers_errors((light,)))


def _without_glass(panorama: SpectralPanorama, mask: BoolArray) -> tuple[SpectralPanorama, FloatArray]:
    """The region's light behind the glasses that were put before it last, and their transmittance (61,).

    Where its parts have different edits the light stays as it is.
    """
    through = np.ones(len(panorama.wavelengths_nm))
    lit = mask & (panorama.weights != 0).any(-1)
    stacks = stacks_of(panorama)
    above = {stacks[index][1:] for index in np.unique(panorama.basis_index[lit]).tolist()}
    if len(above) != 1:
        return panorama, np.ones(len(WAVELENGTHS_NM))
    for number in sorted(_last_glasses(panorama, above.pop()), reverse=True):
        through = through * panorama.edits[number].spectrum
        panorama = remove_edit(panorama, number)
    return panorama, resample(panorama.wavelengths_nm, through)


def _last_glasses(panorama: SpectralPanorama, edits: Sequence[int]) -> list[int]:
    """Those of a region's edits that are glasses with no other lamp after them."""
    glasses: list[int] = []
    for number in reversed(edits):
        if panorama.edits[number].kind != "glass":
            break
        glasses.append(number)
    return glasses


def _layers_of(panorama: SpectralPanorama, count: int) -> tuple[FloatArray, FloatArray]:
    """Weights (H, W, R) >= 0 and spectra (R, 61) of this many layers; every direction keeps its luminance at least."""
    layers = light_layers(panorama)
    if count == CHANNELS:
        return layers.weights, layers.spectra
    weights = layers.weights.astype(float)
    y_bar = colour_matching_functions()[:, 1] * STEP_NM
    luminance = layers.spectra @ y_bar
    brightness = weights @ luminance
    share = weights * luminance / np.maximum(brightness, 1e-30)[..., None]  # (H, W, 3), sums to one where lit
    energy = (
        np.maximum(brightness, 0.0) * np.sin(np.pi * (np.arange(len(weights)) + 0.5) / len(weights))[:, None]
    )
    mean = (share * energy[..., None]).sum((0, 1)) / energy.sum()
    level = luminance.mean()
    unit = layers.spectra / luminance[:, None]  # of luminance 1
    if count == 1:
        return (brightness / level)[..., None].astype(np.float32), (mean @ unit)[None] * level
    offset = share - mean
    moment = np.einsum("hw,hwc,hwd->cd", energy, offset, offset)
    line = np.linalg.eigh(moment)[1][:, -1]
    along = np.where(energy > 0, offset @ line, 0.0)
    low, high = along.min(), max(along.max(), along.min() + 1e-6)
    second = np.clip((along - low) / (high - low), 0.0, 1.0)
    spectra = np.stack([(mean + end * line) @ unit for end in (low, high)]) * level
    pair = brightness[..., None] / level * np.stack([1.0 - second, second], axis=-1)
    return pair.astype(np.float32), spectra


def _padded(values: FloatArray) -> FloatArray:
    """Three channels of which the last are black."""
    missing = CHANNELS - values.shape[-1]
    return np.concatenate([values, np.zeros((*values.shape[:-1], missing), values.dtype)], axis=-1)

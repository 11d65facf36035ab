"""The data of a spectral render: light layers, the plan of its passes, and what a pass leaves.

Axis letters as in `model`: H, W image; L wavelengths; P passes; C = 3 channels of a Cycles light group.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from .model import FloatArray

WORLD = "world"
"""Name of the light group of the world, or of all light together where there is no other group."""


@dataclass(frozen=True)
class LightLayers:
    """A panorama as three non-negative light layers for the light-basis passes.

    The spectral radiance at a pixel is ``weights @ spectra``; `weights` (H, W, 3) float32 >= 0, `spectra` (3, L) may be
    signed. `residual` is the share of the panorama's spectral energy that the three layers do not hold.
    """

    weights: FloatArray
    spectra: FloatArray
    wavelengths_nm: FloatArray
    residual: float


@dataclass(frozen=True)
class LightSet:
    """What the world holds during one set of light-basis passes; the sets of a plan add up to the whole light.

    Parameters
    ----------
    layers
        The three layers; zero where another set holds the direction's light.
    swappable
        Name by which each layer's light can be exchanged after rendering, "" where it cannot.
    recovered_spectra
        (3, L) spectra of the layers without the glasses now in front of them: what a swapped glass filters. None where
        they are those of the layers.
    """

    layers: LightLayers
    swappable: tuple[str, str, str] = ("", "", "")
    recovered_spectra: FloatArray | None = None


@dataclass(frozen=True)
class EmissionGroup:
    """A Cycles light group of lamps and emitting materials: what its three channels hold.

    Parameters
    ----------
    name
        The light group's name in Cycles: "emission" for RGB colours, "lamps 1", ... for measured lamps.
    spectra
        (3, L) spectral radiance per nm of one unit of each channel.
    swappable
        Name of the measured lamp in each channel, by which it can be exchanged after rendering; "" where there is none.
    """

    name: str
    spectra: FloatArray
    swappable: tuple[str, str, str] = ("", "", "")


@dataclass(frozen=True)
class PassPlan:
    """Which Cycles passes to render and how they become spectra.

    In pass p the world's R, G, B hold either three light layers (`kind` "light-basis": the texture of a light set, the same
    for all passes of the set) or the light at three wavelengths ("wavelength"), and channel c of every material is set to
    ``wavelengths_nm[p, c]``. With the transports ``T`` (P, H, W, 3) of the world, the spectral radiance is
    ``einsum("phwc,pcl->hwl", T, reconstruction)``; both kinds are put together by this one sum. Lamps and emitting materials
    ride along in light groups of their own (light-basis) or in the same channels (wavelength).

    Parameters
    ----------
    kind
        "light-basis" or "wavelength".
    wavelengths_nm
        (P, 3) wavelength of the materials in each channel; in a light-basis pass all three are the same.
    reconstruction
        (P, 3, L) contribution of each channel of each pass's world to the spectrum, per nm.
    grid_nm
        (L,) wavelengths of the spectrum.
    sample_shares
        (P,) share of the full sample count that each pass gets, in 0..1.
    references
        For each pass, the pass it is a ratio of: itself where it is rendered in full. The transport of another pass is
        estimated from its few samples over the reference's first as many, times the reference (`render.ratio`).
    light_sets
        For each pass, which light set the world holds; 0 in a wavelength plan.
    interpolation
        (P, L) weights by which transport at the passes' wavelengths predicts that at every wavelength, zero for passes of
        other sets; None in a wavelength plan. ``reconstruction[p, c]`` is ``interpolation[p]`` times a layer's spectrum.
    emission
        Light groups beside the world. Their light shines in the passes of set 0 only, where channel c contributes
        ``interpolation[p] * spectra[c]``. Empty in a wavelength plan.
    predicted_de2000
        Predicted mean and largest dE2000 against the 61-wavelength reference (99 of 100 pixels are within the largest); None
        where nothing was predicted.
    predicted_cost
        Samples of all passes over those of one RGB render of as many.
    swappable
        Layers of the world's light that can be exchanged after rendering.
    consecutive
        The passes take consecutive samples of one sequence of as many as a full pass has, so that all of them together are
        one render's worth, each path seen at three of the wavelengths; else each pass starts at the first sample.
    notes
        Sentences on how the plan was chosen, for people.
    level
        What the light of a wavelength plan's passes was divided by; `reconstruction` is already multiplied by it. 1 where
        nothing has been rendered by the plan yet.
    """

    kind: Literal["light-basis", "wavelength"]
    wavelengths_nm: FloatArray
    reconstruction: FloatArray
    grid_nm: FloatArray
    sample_shares: FloatArray
    references: tuple[int, ...]
    light_sets: tuple[int, ...]
    interpolation: FloatArray | None = None
    emission: tuple[EmissionGroup, ...] = ()
    predicted_de2000: tuple[float, float] | None = None
    predicted_cost: float | None = None
    swappable: tuple[SwappableLayer, ...] = ()
    notes: tuple[str, ...] = ()
    consecutive: bool = False
    level: float = 1.0

    @property
    def passes(self) -> int:
        """Number of passes P."""
        return len(self.wavelengths_nm)


@dataclass(frozen=True)
class SwappableLayer:
    """A layer of the world's light that can be exchanged after rendering.

    `channel` of the passes of `light_set` holds it; `recovered` (L,) is its spectrum without the glass now in front of it.
    """

    name: str
    light_set: int
    channel: int
    recovered: FloatArray


@dataclass(frozen=True)
class RenderStep:
    """One Cycles render: samples ``first_sample`` to ``first_sample + samples`` (of those of a full pass) of a pass.

    `name` is that of its file without suffix, such as "pass_00_head". `guide` asks for the feature passes, too.
    """

    name: str
    pass_number: int
    first_sample: int
    samples: int
    guide: bool = False


@dataclass(frozen=True)
class PassImage:
    """What one Cycles render of a pass left, of one view layer.

    Parameters
    ----------
    groups
        Radiance (H, W, 3) by light group: `WORLD` and those of `PassPlan.emission`.
    alpha
        (H, W), None with an opaque film.
    guide
        (H, W, F) features by which edges are told from noise: albedo, normal, object index; None where not asked for.
    """

    groups: Mapping[str, FloatArray] = field(default_factory=dict)
    alpha: FloatArray | None = None
    guide: FloatArray | None = None

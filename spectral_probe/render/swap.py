"""Another lamp, or another stained glass, in a finished render: a sum over stored transports, without a new render.

The render's folder holds `swappable.exr`: channels `fixed.X`, `fixed.Y`, `fixed.Z` of the light that stays, and for each
swappable layer k and pass p of its set `layer<k>.pass<p>`, what the pass shows of the layer. A layer's part of the tristimulus
values is the sum over its passes of that image times the tristimulus values of (interpolation times the layer's spectrum).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from ..errors import FileFormatError, RenderError
from ..files.image_exr import read_channels
from ..model import FloatArray
from ..render_model import PassPlan
from ..spectra.colorimetry import colour_matching_functions, spectra_to_xyz
from .plan_file import load_plan

type SwapKind = Literal["lamp", "glass"]
type SwapKeeps = Literal["luminance", "power"]

SWAPPABLE_STEM = "swappable"
"""Name of the file without suffixes: those of further view layers have the layer's name after an underscore."""

_CHANNEL = re.compile(r"layer(\d+)\.pass(\d+)")


@dataclass(frozen=True)
class Layer:
    """A layer that can be exchanged.

    Parameters
    ----------
    name
        Of the light; a light may have several layers.
    light_set
        The set whose passes show it.
    spectrum, recovered
        (L,) as rendered, and without the glass that was in front of it.
    """

    name: str
    light_set: int
    spectrum: FloatArray
    recovered: FloatArray


@dataclass(frozen=True)
class Swap:
    """What takes the place of a light.

    `spectrum` (L,) of a lamp in any unit, of which the light's luminance or radiant power is kept; or the transmittance of a
    glass, which filters the light as it is without the glass it was rendered with. `label` names it.
    """

    kind: SwapKind
    label: str
    spectrum: FloatArray
    keeps: SwapKeeps = "luminance"


def swappable_layers(plan: PassPlan) -> tuple[Layer, ...]:
    """The layers that can be exchanged, in the order in which they are stored: the world's, then those of measured lamps."""
    layers = []
    for own in plan.swappable:
        passes = [row for row, light_set in enumerate(plan.light_sets) if light_set == own.light_set]
        spectrum = plan.reconstruction[passes, own.channel].sum(0)  # the interpolation's columns sum to one
        layers.append(Layer(own.name, own.light_set, spectrum, own.recovered))
    for group in plan.emission:
        layers += [
            Layer(name, 0, spectrum, spectrum)
            for name, spectrum in zip(group.swappable, group.spectra, strict=True)
            if name
        ]
    return tuple(layers)


def light_names(plan: PassPlan) -> tuple[str, ...]:
    """Names of the lights that can be exchanged, each once."""
    return tuple(dict.fromkeys(layer.name for layer in swappable_layers(plan)))


def checked_name(plan: PassPlan, name: str) -> str:
    """The name of a light, refused where the render has none of it; capitals do not matter.

    Raises
    ------
    RenderError
        With the names that there are.
    """
    names = light_names(plan)
    if not names:
        raise RenderError(
            "Nothing in this render can be exchanged. Make a region swappable (--swappable), or measured lamps "
            "(--swappable-lamps), and render again."
        )
    for known in names:
        if known.lower() == name.lower():
            return known
    raise RenderError(f'There is no swappable light "{name}" in this render. It has {", ".join(names)}.')


def spectrum_after(layer: Layer, swap: Swap) -> FloatArray:
    """Spectrum (L,) of a layer after an exchange.

    Examples
    --------
    >>> dim = Layer("lamp", 0, np.full(61, 0.5), np.full(61, 1.0))
    >>> red = np.linspace(0.0, 1.0, 61)
    >>> spectrum_after(dim, Swap("glass", "red", red))[[0, 60]].tolist()
    [0.0, 1.0]
    >>> float(spectrum_after(dim, Swap("lamp", "flat", np.full(61, 7.0)))[0].round(9))
    0.5
    """
    if swap.kind == "glass":
        return layer.recovered * swap.spectrum
    kept = colour_matching_functions()[:, 1] if swap.keeps == "luminance" else np.ones(len(swap.spectrum))
    level = swap.spectrum @ kept
    if not level > 0:
        raise RenderError(f"The lamp {swap.label} gives no light that is seen. Choose another.")
    return np.asarray(swap.spectrum * (layer.spectrum @ kept) / level)


def swapped_xyz(
    render_dir: Path, plan: PassPlan, swaps: Mapping[str, Swap], layer_suffix: str = ""
) -> FloatArray:
    """Tristimulus values (H, W, 3) float32 of a render with some of its lights exchanged.

    Parameters
    ----------
    render_dir
        Folder of the render.
    plan
        Its plan.
    swaps
        By the light's name; lights that are not in it are as they were rendered.
    layer_suffix
        What the names of a further view layer's files end with.

    Raises
    ------
    FileFormatError
        If the stored transports are missing, or do not fit the plan.
    """
    path = Path(render_dir) / f"{SWAPPABLE_STEM}{layer_suffix}.exr"
    if not path.is_file():
        raise FileFormatError(
            f"{path} is missing: without it no light can be exchanged. Render again with a swappable region or a measured lamp."
        )
    layers = swappable_layers(plan)
    channels, _ = read_channels(path)
    wrong = FileFormatError(f"{path} does not fit the plan beside it. Render again.")
    if any(f"fixed.{axis}" not in channels for axis in "XYZ"):
        raise wrong
    planes: list[FloatArray] = []
    coefficients: list[FloatArray] = []
    for name, plane in channels.items():
        found = _CHANNEL.fullmatch(name)
        if found is None:
            continue
        number, row = int(found[1]), int(found[2])
        if number >= len(layers) or row >= plan.passes or plan.light_sets[row] != layers[number].light_set:
            raise wrong
        planes.append(plane)
        coefficients.append(_coefficient(plan, row, layers[number], swaps))
    if len(planes) != sum(plan.light_sets.count(layer.light_set) for layer in layers):
        raise wrong
    xyz = np.empty((*channels["fixed.X"].shape, 3), np.float32)
    for axis, name in enumerate("XYZ"):
        plane = np.array(channels[f"fixed.{name}"], np.float32)
        for image, coefficient in zip(planes, coefficients, strict=True):
            plane += np.float32(coefficient[axis]) * image
        xyz[..., axis] = plane
    return xyz


def _coefficient(plan: PassPlan, row: int, layer: Layer, swaps: Mapping[str, Swap]) -> FloatArray:
    """Tristimulus values (3,) that a unit of a layer's image in a pass stands for."""
    if plan.interpolation is None:
        raise RenderError(
            "A wavelength plan has no light layers to exchange. Render with a light-basis plan."
        )
    swap = swaps.get(layer.name)
    spectrum = layer.spectrum if swap is None else spectrum_after(layer, swap)
    return spectra_to_xyz(plan.interpolation[row] * spectrum)


def swap(
    render_dir: Path, name: str, spectrum: FloatArray, kind: SwapKind, keeps: SwapKeeps = "luminance"
) -> FloatArray:
    """Tristimulus values (H, W, 3) of a finished render with one light exchanged, all others as rendered.

    Parameters
    ----------
    render_dir
        Folder of the render, with plan.json and swappable.exr.
    name
        The light's.
    spectrum
        (61,) of the lamp, or the transmittance of the glass.
    kind
        "lamp" or "glass".
    keeps
        What of the light a lamp keeps.

    Raises
    ------
    SpectralProbeError
        If there is no such light, or the folder lacks what is needed.
    """
    plan = load_plan(Path(render_dir) / "plan.json")
    known = checked_name(plan, name)
    return swapped_xyz(render_dir, plan, {known: Swap(kind, kind, spectrum, keeps)})


def told(swaps: Mapping[str, Swap], names: Sequence[str]) -> dict[str, str]:
    """What each light is now, in words."""
    words = {}
    for name in names:
        own = swaps.get(name)
        words[name] = "as rendered" if own is None else f"{own.kind} {own.label}"
    return words

"""Plans of Cycles passes: which wavelengths to render, and how the passes become spectra.

Two kinds, both put together by one sum (`PassPlan`):

- **wavelength**: each channel holds light and materials at one wavelength; 21 passes are the 61-sample reference, and a
  quadrature fitted to the scene needs fewer (`quadrature`).
- **light-basis**: the world's channels hold three light layers (`light_sets`), each pass sets all materials to one
  wavelength. What the scene does with light between lamp and camera (its transport) is smooth in wavelength even where the
  light is not, so a few wavelengths and an interpolation hold it (`interpolation`), and the light enters at full resolution
  afterwards.

Errors are predicted for the whole chain, layers and wavelengths together, on a picture of random pixels that the plan was not
fitted to (`light_samples`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Literal

import numpy as np

from ..errors import RenderError
from ..geometry.frames import panorama_solid_angles
from ..model import FloatArray, SpectralPanorama
from ..render_model import EmissionGroup, LightSet, PassPlan, SwappableLayer
from ..spectra.colorimetry import colour_matching_functions, illuminant
from ..spectra.grid import STEP_NM, WAVELENGTHS_NM
from .interpolation import NodeChoice, lab_metric, second_moment
from .light_samples import PIXELS, Picture, largest_error, random_picture
from .light_sets import light_rank
from .pass_folder import FEWEST_SAMPLES
from .plan_file import describe, load_plan, save_plan
from .quadrature import fitted_quadrature

__all__ = ["describe", "load_plan", "make_plan", "reference_plan", "save_plan", "wavelength_plan"]

FEWEST_PASSES, MOST_PASSES = 3, 20
"""Wavelengths of a light set, where their number is not asked for."""

SECONDARY_SHARE = 1.0 / 16.0
"""Share of the full samples that a pass gets whose transport is estimated as a ratio of the reference's."""

LEAST_SET_SHARE = 0.25
"""Share of the full samples of a light set's reference pass at least."""

_TRAINING_SEED, _HELD_OUT_SEED = 1000, 2000
_TRAINING_PIXELS = 4000

_OTHER_LAMPS = ("A", "D65", "FL2", "FL11", "HP1", "LED-B3", "LED-RGB1")
"""What a swappable light may be exchanged for: its wavelengths must serve these, too."""


def reference_plan() -> PassPlan:
    """The 61-wavelength reference in 21 passes, wavelengths far apart sharing a pass.

    61 samples fill 63 channels: the last two repeat 700 nm and contribute nothing.

    Examples
    --------
    >>> plan = reference_plan()
    >>> plan.passes, float(plan.reconstruction.sum())
    (21, 61.0)
    """
    count = len(WAVELENGTHS_NM)
    passes = -(-count // 3)
    index = np.arange(passes)[:, None] + passes * np.arange(3)
    reconstruction = np.zeros((passes, 3, count))
    real = index < count
    reconstruction[(*np.nonzero(real), index[real])] = 1.0
    return PassPlan(
        kind="wavelength",
        wavelengths_nm=WAVELENGTHS_NM[np.minimum(index, count - 1)],
        reconstruction=reconstruction,
        grid_nm=WAVELENGTHS_NM.copy(),
        sample_shares=np.ones(passes),
        references=tuple(range(passes)),
        light_sets=(0,) * passes,
        predicted_cost=float(passes),
    )


def make_plan(
    sets: Sequence[LightSet],
    panorama: SpectralPanorama,
    reflectances: FloatArray,
    *,
    passes: int | Literal["all"] | None = None,
    max_de2000: float = 0.5,
    emission: Sequence[EmissionGroup] = (),
    full_samples: bool = False,
    samples: int = 128,
) -> PassPlan:
    """The light-basis plan for a scene and its light, with as few passes as keep an error bound.

    Parameters
    ----------
    sets
        The light's layers (`light_sets.light_sets`).
    panorama
        The true light, which the layers are compared with.
    reflectances
        (N, 61) reflectances of the scene's materials, metals at several incidence angles. A constant is always added (light
        seen directly, white surfaces).
    passes
        Number of wavelengths of every light set; "all" for the 61-wavelength reference; None for as few as keep the largest
        predicted error within the bound, of the kind that costs least.
    max_de2000
        The bound on the largest predicted error, which 99 of 100 random pixels are within (`light_samples.largest_error`): each
        light has luminance 1, and the picture is exposed as `compare` exposes one.
    emission
        Light groups beside the world.
    full_samples
        Give all passes of a set the same samples, as where ratios of passes are no good estimate (dispersion).
    samples
        Samples of a full pass, of which secondary passes need `FEWEST_SAMPLES`.

    Returns
    -------
    PassPlan
        With predicted error, predicted cost, and sentences on the choice; see `describe`.

    Raises
    ------
    RenderError
        If the number of passes is not in 1..61.

    Examples
    --------
    >>> from spectral_probe.render.light_sets import light_sets
    >>> weights, index = np.ones((4, 8, 1), np.float32), np.zeros((4, 8), np.uint8)
    >>> sure, white = np.ones((4, 8), np.float32), np.ones((1, 61))
    >>> panorama = SpectralPanorama(weights, white[None], index, WAVELENGTHS_NM, sure > 0, sure)
    >>> sets = light_sets(panorama, reflectances=white, max_de2000=0.5)
    >>> plan = make_plan(sets, panorama, white, passes=4, samples=64)
    >>> plan.passes, plan.predicted_cost
    (4, 1.1875)
    """
    if passes == "all":
        return reference_plan()
    count = len(WAVELENGTHS_NM)
    if passes is not None and not 1 <= passes <= count:
        raise RenderError(
            f"{passes} passes were asked for; choose a number from 1 to {count}, or all wavelengths."
        )
    chain = _Chain(sets, panorama, reflectances, emission)
    sizes = [passes] * len(sets) if passes else chain.smallest_sizes(max_de2000)
    plan = _light_basis(chain, sizes, full_samples, samples)
    notes = (*_light_notes(panorama, sets), *_swappable_notes(chain, sizes, plan, full_samples, samples))
    within = plan.predicted_de2000 is not None and plan.predicted_de2000[1] <= max_de2000
    if passes is None and not within:
        notes = (
            *notes,
            f"The error bound of dE2000 {max_de2000:g} is not reached with {MOST_PASSES} wavelengths a set.",
        )
    return replace(plan, notes=notes)


def wavelength_plan(
    panorama: SpectralPanorama,
    reflectances: FloatArray,
    *,
    max_de2000: float = 0.5,
    emission: Sequence[EmissionGroup] = (),
    full_samples: bool = False,
    dispersive: bool = False,
    samples: int = 128,
) -> PassPlan | None:
    """The fitted wavelength quadrature of a scene and its light (`quadrature`), or None where it keeps no error bound.

    It costs the samples of one RGB render and needs no light layers, but no light can be exchanged afterwards.

    Parameters
    ----------
    panorama, reflectances, max_de2000, emission, samples
        As for `make_plan`.
    full_samples
        Give each pass all samples, in place of its part of them.
    dispersive
        A glass refracts each wavelength its own way: no other wavelength can be predicted from those rendered, so all 61 are.

    Examples
    --------
    >>> weights, index = np.ones((4, 8, 1), np.float32), np.zeros((4, 8), np.uint8)
    >>> sure, white = np.ones((4, 8), np.float32), np.ones((1, 61))
    >>> panorama = SpectralPanorama(weights, white[None], index, WAVELENGTHS_NM, sure > 0, sure)
    >>> plan = wavelength_plan(panorama, white)
    >>> plan.kind, plan.passes, plan.predicted_cost
    ('wavelength', 1, 1.0)
    """
    most = min(MOST_PASSES, samples // FEWEST_SAMPLES)
    if dispersive:
        every = reference_plan()
        if full_samples or samples < every.passes:
            return every
        shares = np.full(every.passes, 1.0 / every.passes)
        return replace(every, sample_shares=shares, consecutive=True, predicted_cost=1.0)
    training, held_out = _pictures(panorama, (), reflectances, emission)
    plan = fitted_quadrature(training, held_out, max_de2000, most, full_samples=full_samples)
    rank = _kinds_of_spectrum(light_rank(panorama))
    return plan and replace(plan, notes=(f"The light is a mixture of {rank}.",))


def _pictures(
    panorama: SpectralPanorama,
    sets: Sequence[LightSet],
    reflectances: FloatArray,
    emission: Sequence[EmissionGroup],
) -> tuple[Picture, Picture]:
    """Random pixels that a plan is fitted to, and others by which its error is predicted."""
    return (
        random_picture(panorama, sets, reflectances, _TRAINING_SEED, emission, count=_TRAINING_PIXELS),
        random_picture(panorama, sets, reflectances, _HELD_OUT_SEED, emission, count=PIXELS),
    )


class _Chain:
    """What happens to the light of random pixels: layers, few wavelengths, interpolation; with the parts that are used twice."""

    def __init__(
        self,
        sets: Sequence[LightSet],
        panorama: SpectralPanorama,
        reflectances: FloatArray,
        emission: Sequence[EmissionGroup],
    ) -> None:
        self.sets, self.emission = tuple(sets), tuple(emission)
        self.spectra = [light.layers.spectra for light in sets] + [group.spectra for group in emission]
        self.set_of = [*range(len(sets)), *(0 for _ in emission)]
        self.training, self.held_out = _pictures(panorama, sets, reflectances, emission)
        self._xyz: dict[tuple[int, int], FloatArray] = {}

    @cached_property
    def choices(self) -> list[NodeChoice]:
        """For each set which wavelengths serve its light."""
        moment = second_moment(np.asarray(self.training.transports.sum(0)))
        return [NodeChoice(moment, lab_metric(self._lights(number))) for number in range(len(self.sets))]

    def _lights(self, number: int) -> FloatArray:
        """What a set holds of the training lights (M, L), and what it may be exchanged for."""
        groups = [group for group, owner in enumerate(self.set_of) if owner == number]
        lights = sum(
            light.held[:, group] @ self.spectra[group] for light in self.training.lights for group in groups
        )
        lights = np.asarray(lights)
        names = list(self.sets[number].swappable)
        names += [name for group in self.emission if number == 0 for name in group.swappable]
        if any(names):
            lamps = np.stack([illuminant(name) for name in _OTHER_LAMPS])
            lamps = lamps / (lamps @ colour_matching_functions()[:, 1:2] * STEP_NM)
            lights = np.concatenate([lights, np.repeat(lamps, max(1, len(lights) // len(lamps)), axis=0)])
        return lights

    @cached_property
    def _transports(self) -> list[FloatArray]:
        return [self.held_out.layer_transports(group) for group in range(len(self.spectra))]

    def _set_xyz(self, number: int, size: int) -> FloatArray:
        """Tristimulus values (N, 3) of a set's light, and of the emission that shines with it, by so many wavelengths."""
        if (number, size) not in self._xyz:
            nodes, weights = self.interpolation(number, size)
            cmf = colour_matching_functions() * STEP_NM
            total = np.zeros((len(self._transports[0]), 3))
            for group, owner in enumerate(self.set_of):
                if owner == number:
                    matrix = np.einsum("pl,cl,lx->cpx", weights, self.spectra[group], cmf)
                    total += np.einsum("ncp,cpx->nx", self._transports[group][:, :, nodes], matrix)
            self._xyz[number, size] = total
        return self._xyz[number, size]

    def interpolation(self, number: int, size: int) -> tuple[list[int], FloatArray]:
        """Indices of so many wavelengths for a set, and the weights (P, L) that go with them."""
        count = len(WAVELENGTHS_NM)
        if size == count:
            return list(range(count)), np.eye(count)
        return self.choices[number].nodes(size), self.choices[number].weights(size)

    def errors(self, sizes: Sequence[int]) -> FloatArray:
        """DE2000 of the held-out pixels with so many wavelengths of each set."""
        total = sum(self._set_xyz(number, size) for number, size in enumerate(sizes))
        return self.held_out.errors(np.asarray(total))

    def smallest_sizes(self, max_de2000: float) -> list[int]:
        """Numbers of wavelengths of the sets, as small as keep the largest error within the bound, or the best there are."""
        sizes = [FEWEST_PASSES] * len(self.sets)
        best, best_error = list(sizes), largest_error(self.errors(sizes))
        while best_error > max_de2000:
            # A set is judged with the others at all wavelengths, or the worst would hide what a better one gains.
            alone = [self._alone(number, size) for number, size in enumerate(sizes)]
            worst = int(
                np.argmax(
                    [error if sizes[number] < MOST_PASSES else -1 for number, error in enumerate(alone)]
                )
            )
            larger = range(sizes[worst] + 1, MOST_PASSES + 1)
            sizes[worst] = next(
                (size for size in larger if self._alone(worst, size) < alone[worst]), MOST_PASSES
            )
            error = largest_error(self.errors(sizes))
            if error < best_error:
                best, best_error = list(sizes), error
            if min(sizes) == MOST_PASSES:
                break
        return best

    def _alone(self, number: int, size: int) -> float:
        """The largest error with so many wavelengths of one set, and all of the others."""
        everywhere = len(WAVELENGTHS_NM)
        return largest_error(
            self.errors([size if other == number else everywhere for other in range(len(self.sets))])
        )


def _light_basis(chain: _Chain, sizes: Sequence[int], full_samples: bool, samples: int) -> PassPlan:
    """The light-basis plan with so many wavelengths of each set."""
    grid = len(WAVELENGTHS_NM)
    share_of_set = _set_shares(chain.sets, bool(chain.emission))
    secondary = _secondary_share(samples)
    rows: list[tuple[int, int, FloatArray]] = []
    references, shares, reconstruction = [], [], []
    for number, size in enumerate(sizes):
        nodes, weights = chain.interpolation(number, size)
        reference = len(rows) + int(np.argmax(weights @ _brightness(chain.sets[number])))
        for node, weight in zip(nodes, weights, strict=True):
            own = full_samples or len(rows) == reference
            references.append(len(rows) if full_samples else reference)
            shares.append(share_of_set[number] if own else min(secondary, share_of_set[number]))
            reconstruction.append(weight * chain.sets[number].layers.spectra)
            rows.append((number, node, weight))
    errors = chain.errors(sizes)
    return PassPlan(
        kind="light-basis",
        wavelengths_nm=np.repeat(WAVELENGTHS_NM[[node for _, node, _ in rows]][:, None], 3, axis=1),
        reconstruction=np.stack(reconstruction).reshape(-1, 3, grid),
        grid_nm=WAVELENGTHS_NM.copy(),
        sample_shares=np.array(shares),
        references=tuple(references),
        light_sets=tuple(number for number, _, _ in rows),
        interpolation=np.stack([weight for _, _, weight in rows]),
        emission=chain.emission,
        predicted_de2000=(float(errors.mean()), largest_error(errors)),
        predicted_cost=_cost(shares, samples),
        swappable=_swappable_layers(chain.sets),
    )


def _secondary_share(samples: int) -> float:
    return max(SECONDARY_SHARE, FEWEST_SAMPLES / samples)


def _cost(shares: Sequence[float], samples: int) -> float:
    """Samples of all passes over those of one full pass."""
    return float(np.maximum(np.round(np.array(shares) * samples), 1).sum() / samples)


def _brightness(light: LightSet) -> FloatArray:
    """How much luminance (L,) the mean light of a set has at each wavelength."""
    spectra = light.layers.weights.mean((0, 1)).astype(float) @ light.layers.spectra
    bright = np.maximum(spectra, 0.0) * colour_matching_functions()[:, 1]
    return np.asarray(bright if bright.any() else colour_matching_functions()[:, 1])


def _set_shares(sets: Sequence[LightSet], emission: bool) -> FloatArray:
    """Shares of the full samples of the sets' reference passes: by their light, at least `LEAST_SET_SHARE` each."""
    energy = np.array([_energy(light) for light in sets])
    if emission:  # shines with set 0, and how bright it is is not known
        energy[0] = max(energy[0], energy.sum() / 2)
    least = np.full(len(sets), LEAST_SET_SHARE)
    if not energy.any():
        energy = np.ones(len(sets))
    shares = energy / energy.sum()
    for _ in sets:  # what the dim ones get beyond their part the others give
        dim = shares <= least
        left = 1.0 - least[dim].sum()
        if dim.all() or left <= 0:
            break
        shares = np.where(dim, least, energy * left / energy[~dim].sum())
    return np.asarray(np.maximum(shares, least))


def _energy(light: LightSet) -> float:
    """Luminous energy of a set's light."""
    luminance = light.layers.spectra @ colour_matching_functions()[:, 1]
    height, width, _ = light.layers.weights.shape
    rows = light.layers.weights.sum(1, dtype=float) @ luminance
    return max(float((rows * panorama_solid_angles(height, width)[:, 0]).sum()), 0.0)


def _swappable_layers(sets: Sequence[LightSet]) -> tuple[SwappableLayer, ...]:
    layers = []
    for number, light in enumerate(sets):
        recovered = light.layers.spectra if light.recovered_spectra is None else light.recovered_spectra
        layers += [
            SwappableLayer(name, number, channel, recovered[channel])
            for channel, name in enumerate(light.swappable)
            if name
        ]
    return tuple(layers)


def _swappable_notes(
    chain: _Chain, sizes: Sequence[int], plan: PassPlan, full_samples: bool, samples: int
) -> tuple[str, ...]:
    """What it costs that lights of the world can be exchanged: against the passes of the other sets alone."""
    own = [number for number, light in enumerate(chain.sets) if any(light.swappable)]
    if not own:
        return ()
    others = [number for number in range(len(chain.sets)) if number not in own]
    shares: list[float] = []
    for number, share in zip(
        others, _set_shares([chain.sets[number] for number in others], bool(chain.emission)), strict=True
    ):
        secondary = share if full_samples else min(_secondary_share(samples), share)
        shares += [share, *[secondary] * (sizes[number] - 1)]
    passes = sum(sizes[number] for number in own)
    more = (plan.predicted_cost or 0.0) - _cost(shares, samples)
    return (
        f"That lights can be exchanged takes {passes} passes of their own, predicted to cost {more:.2f} RGB renders more.",
    )


def _light_notes(panorama: SpectralPanorama, sets: Sequence[LightSet]) -> tuple[str, ...]:
    rank = light_rank(panorama)
    fixed = sum(not any(light.swappable) for light in sets)
    if fixed > 1:
        held = f"three layers cannot hold them within the bound, so its directions are split into {fixed} sets of layers"
    else:
        held = (
            "three layers hold all of it" if rank <= len("RGB") else "three layers hold it within the bound"
        )
    return (f"The light is a mixture of {_kinds_of_spectrum(rank)}; {held}.",)


def _kinds_of_spectrum(rank: int) -> str:
    return "one kind of spectrum" if rank == 1 else f"{rank} kinds of spectrum"

"""The steps of a spectral render put together: images -> transports -> tristimulus values, spectra, swappable layers.

Both kinds of plan are one sum over passes and channels (see `PassPlan`). Steps are read one at a time, and a pass that was
rendered with few samples becomes a transport by the ratio to its reference (`render.ratio`), so a render of any number of
passes needs the memory of a few images.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..errors import RenderError
from ..model import FloatArray
from ..render_model import WORLD, PassImage, PassPlan, RenderStep
from ..spectra.colorimetry import spectra_to_xyz
from .ratio import RatioFilter

type ReadStep = Callable[[RenderStep], PassImage]


@dataclass(frozen=True)
class Transport:
    """Light that reaches the camera in a pass, (H, W, 3) by light group, as of the samples of a full pass."""

    pass_number: int
    groups: Mapping[str, FloatArray]
    alpha: FloatArray | None = None
    guide: FloatArray | None = None


@dataclass(frozen=True)
class AssembledRender:
    """A spectral render of one view layer.

    Parameters
    ----------
    xyz
        (H, W, 3) float32 radiance times colour-matching functions summed over nm; not normalised, and negative where noise
        or a light outside the layers makes it so.
    alpha
        (H, W) float32, None with an opaque film.
    guide
        (H, W, F) features of the first pass, None where there are none; where every pass has them, the albedo (the first
        three) is that of all wavelengths, in X, Y, Z relative to a perfect white in equal-energy light.
    bands_nm, bands
        (N,) wavelengths that were asked for and (N, H, W) float32 spectral radiance per nm at them.
    projected
        (M, H, W) float32 sums over the spectrum that were asked for, such as the channels of a camera.
    swappable
        (H, W) planes by channel name, `fixed.X`, ..., `layer0.pass3`: what `render.swap` needs to exchange a layer's
        spectrum. Empty where nothing is swappable.
    """

    xyz: FloatArray
    alpha: FloatArray | None = None
    guide: FloatArray | None = None
    bands_nm: FloatArray = field(default_factory=lambda: np.zeros(0))
    bands: FloatArray | None = None
    projected: FloatArray | None = None
    swappable: Mapping[str, FloatArray] = field(default_factory=dict)


def assemble(
    plan: PassPlan,
    steps: Sequence[RenderStep],
    read: ReadStep,
    *,
    bands_nm: FloatArray | None = None,
    projection: FloatArray | None = None,
) -> AssembledRender:
    """Put the steps of a spectral render together.

    Parameters
    ----------
    plan
        The plan that was rendered.
    steps
        Its steps (`render.pass_folder.render_steps`).
    read
        Reads what a step left, of one view layer; called once for each step and again for no step.
    bands_nm
        Wavelengths (N,) of the plan's grid at which spectral radiance is wanted, besides tristimulus values.
    projection
        (L, M) weights of the plan's grid by which the spectrum is summed, such as a camera's sensitivities times the step.

    Raises
    ------
    RenderError
        If steps are missing, or their images do not fit together.

    Examples
    --------
    >>> from spectral_probe.render.plan import reference_plan
    >>> steps = [RenderStep(f"pass_{p:02d}", p, 0, 4) for p in range(21)]
    >>> white = PassImage({WORLD: np.ones((1, 1, 3), np.float32)})
    >>> assembled = assemble(reference_plan(), steps, lambda step: white, bands_nm=np.array([550.0]))
    >>> assembled.xyz[0, 0].astype(float).round(1).tolist()  # equal energy: sums of the colour-matching functions
    [106.6, 106.8, 106.5]
    >>> assembled.bands.tolist()
    [[[1.0]]]
    """
    wanted_nm = np.zeros(0) if bands_nm is None else np.asarray(bands_nm, float)
    sums = np.zeros((len(plan.grid_nm), 0)) if projection is None else np.asarray(projection, float)
    rows = np.concatenate([_rows(plan.grid_nm, wanted_nm), sums.T])
    layers = _swappable_channels(plan)
    total: FloatArray | None = None
    moved: FloatArray | None = None
    swappable: dict[str, FloatArray] = {}
    first: Transport | None = None
    coverage = _Coverage(plan, steps)
    colours = _GuideColours(plan)
    for transport in transports(plan, steps, read):
        first = first or transport
        colours.add(transport)
        coverage.add(transport)
        for group, image in transport.groups.items():
            spectra = _spectra_of(plan, transport.pass_number, group)
            total = _added(total, image, _coefficients(spectra, rows))
            for number, channel in layers.get((_set_of(plan, transport.pass_number), group), ()):
                swappable[f"layer{number}.pass{transport.pass_number}"] = np.ascontiguousarray(
                    image[..., channel], np.float32
                )
                own = _coefficients(spectra[channel : channel + 1], rows[:0])
                moved = _added(moved, image[..., channel : channel + 1], own)
    if total is None or first is None:
        raise RenderError("The plan has no passes. Make a new one.")
    if moved is not None:
        fixed = total[:3] - moved
        swappable |= {f"fixed.{name}": fixed[index] for index, name in enumerate("XYZ")}
    return AssembledRender(
        xyz=np.ascontiguousarray(np.moveaxis(total[:3], 0, -1)),
        alpha=coverage.alpha,
        guide=colours.of(first.guide),
        bands_nm=wanted_nm,
        bands=total[3 : 3 + len(wanted_nm)] if len(wanted_nm) else None,
        projected=None if projection is None else total[3 + len(wanted_nm) :],
        swappable=swappable,
    )


def rendered_wavelengths_nm(plan: PassPlan) -> FloatArray:
    """Wavelengths at which a plan renders materials, ascending, each once."""
    return np.unique(plan.wavelengths_nm)


# ---------------------------------------------------------------- transports


def transports(plan: PassPlan, steps: Sequence[RenderStep], read: ReadStep) -> Iterator[Transport]:
    """Transports of all passes of a plan: references first, each followed by the passes that are ratios of it.

    Raises
    ------
    RenderError
        If steps are missing, or their images do not fit together.
    """
    by_pass = _by_pass(plan, steps)
    size: tuple[int, ...] | None = None
    for reference in dict.fromkeys(plan.references):
        images = [read(step) for step in by_pass[reference]]
        for image in images:
            size = _checked_size(image, size)
        full = _joined(reference, by_pass[reference], images)
        yield full
        others = [p for p, own in enumerate(plan.references) if own == reference and p != reference]
        if not others:
            continue
        head_step, head = by_pass[reference][0], images[0]
        del images
        filters = {
            group: RatioFilter(head.groups[group], full.groups[group], full.guide) for group in full.groups
        }
        for number in others:
            (step,) = by_pass[number]
            if (step.first_sample, step.samples) != (head_step.first_sample, head_step.samples):
                raise RenderError(
                    f"{step.name} has other samples than {head_step.name}, of which it is a ratio. Render it again."
                )
            low = read(step)
            _checked_size(low, size)
            if low.groups.keys() != full.groups.keys():
                raise RenderError(
                    f"{step.name} has other light groups than {head_step.name}. Render it again."
                )
            yield Transport(
                number,
                {
                    group: _nothing_behind(full, group, image, filters[group].transport(image, low.guide))
                    for group, image in low.groups.items()
                },
                guide=low.guide,
            )


def _nothing_behind(full: Transport, group: str, low: FloatArray, estimate: FloatArray) -> FloatArray:
    """The estimate, black where a transparent film is empty: what the filter's means bring there glows in a composite."""
    if full.alpha is None:
        return estimate
    empty = (full.alpha == 0) & ~full.groups[group].any(-1) & ~low.any(-1)
    return np.where(empty[..., None], np.float32(0.0), estimate)


def _by_pass(plan: PassPlan, steps: Sequence[RenderStep]) -> list[list[RenderStep]]:
    """The steps of each pass by their first sample; references may have several, other passes have one."""
    found = [
        sorted((step for step in steps if step.pass_number == number), key=lambda step: step.first_sample)
        for number in range(plan.passes)
    ]
    missing = [number for number, own in enumerate(found) if not own]
    if missing:
        raise RenderError(
            f"{len(missing)} of {plan.passes} passes have no steps. Render the missing ones first."
        )
    split = [p for p, own in enumerate(found) if plan.references[p] != p and len(own) > 1]
    if split:
        raise RenderError(
            f"Pass {split[0]} is a ratio of another and has more than one step. Render it again."
        )
    return found


def _checked_size(image: PassImage, size: tuple[int, ...] | None) -> tuple[int, ...]:
    for plane in image.groups.values():
        if size is not None and plane.shape[:2] != size:
            raise RenderError("The passes differ in size. Render them again in one resolution.")
        size = plane.shape[:2]
    if size is None:
        raise RenderError("A pass holds no image. Render it again.")
    return size


def _joined(number: int, steps: Sequence[RenderStep], images: Sequence[PassImage]) -> Transport:
    """A full pass of its steps' images: their mean, weighed by samples."""
    shares = np.array([step.samples for step in steps], np.float32)
    shares /= shares.sum()
    if any(image.groups.keys() != images[0].groups.keys() for image in images):
        raise RenderError(f"The steps of pass {number} differ in their light groups. Render them again.")

    def mean(planes: Sequence[FloatArray]) -> FloatArray:
        return np.asarray(sum(share * plane for share, plane in zip(shares, planes, strict=True)), np.float32)

    alphas = [image.alpha for image in images if image.alpha is not None]
    guides = [image.guide for image in images if image.guide is not None]
    return Transport(
        number,
        {group: mean([image.groups[group] for image in images]) for group in images[0].groups},
        alpha=mean(alphas) if len(alphas) == len(images) else None,
        guide=guides[0] if guides else None,
    )


# ---------------------------------------------------------------- sums


def _set_of(plan: PassPlan, number: int) -> int:
    return int(plan.light_sets[number])


def _spectra_of(plan: PassPlan, number: int, group: str) -> FloatArray:
    """(3, L) what a unit of each channel of a light group adds to the spectrum in one pass."""
    if group == WORLD:
        return np.asarray(plan.reconstruction[number])
    own = next((emission for emission in plan.emission if emission.name == group), None)
    if own is None or plan.interpolation is None:
        raise RenderError(f'The light group "{group}" of a pass is not in the plan. Render the passes again.')
    return np.asarray(plan.interpolation[number] * own.spectra)


def _rows(grid_nm: FloatArray, wanted_nm: FloatArray) -> FloatArray:
    """(N, L) weights that read a spectrum on the grid at the wanted wavelengths, linear between the grid's."""
    return np.stack([np.interp(wanted_nm, grid_nm, unit) for unit in np.eye(len(grid_nm))], axis=-1)


def _coefficients(spectra: FloatArray, rows: FloatArray) -> FloatArray:
    """(3 + N, C) what channels of these spectra (C, L) add to X, Y, Z and the bands."""
    return np.concatenate([spectra_to_xyz(spectra).T, rows @ spectra.T])


def _added(total: FloatArray | None, image: FloatArray, coefficients: FloatArray) -> FloatArray:
    """Add an image (H, W, C) times coefficients (N, C) to planes (N, H, W), in place, plane by plane."""
    if total is None:
        total = np.zeros((len(coefficients), *image.shape[:2]), np.float32)
    for row, weights in enumerate(coefficients.astype(np.float32)):
        for channel in np.flatnonzero(weights):
            total[row] += weights[channel] * image[..., channel]
    return total


class _Coverage:
    """Alpha of all full passes together, each as much as it has samples: each saw edges through samples of its own."""

    def __init__(self, plan: PassPlan, steps: Sequence[RenderStep]) -> None:
        self._samples = [
            sum(step.samples for step in steps if step.pass_number == p) for p in range(plan.passes)
        ]
        self._sum: FloatArray | None = None
        self._weight = 0

    def add(self, transport: Transport) -> None:
        """Take a pass's alpha into account, if it has one of its own."""
        if transport.alpha is None:
            return
        samples = self._samples[transport.pass_number]
        part = np.float32(samples) * transport.alpha
        self._sum = part if self._sum is None else self._sum + part
        self._weight += samples

    @property
    def alpha(self) -> FloatArray | None:
        """(H, W), None with an opaque film."""
        return None if self._sum is None else self._sum / np.float32(self._weight)


class _GuideColours:
    """The albedo of the features in colour: each light-basis pass shows it at one wavelength."""

    def __init__(self, plan: PassPlan) -> None:
        self._weights = plan.interpolation
        self._missing = {p for p in range(plan.passes) if plan.light_sets[p] == 0}
        self._albedo: FloatArray | None = None

    def add(self, transport: Transport) -> None:
        """Take a pass's albedo into account."""
        if transport.guide is None or self._weights is None or transport.pass_number not in self._missing:
            return
        self._missing.remove(transport.pass_number)
        weights = spectra_to_xyz(
            np.stack([self._weights[transport.pass_number], np.ones(len(self._weights[0]))])
        )
        grey = transport.guide[..., :3].mean(-1, keepdims=True)
        part = grey * (weights[0] / weights[1]).astype(np.float32)
        self._albedo = part if self._albedo is None else self._albedo + part

    def of(self, guide: FloatArray | None) -> FloatArray | None:
        """The features with their albedo in colour, if all passes had it."""
        if guide is None or self._albedo is None or self._missing:
            return guide
        return np.concatenate([np.clip(self._albedo, 0.0, 1.0), guide[..., 3:]], axis=-1)


def _swappable_channels(plan: PassPlan) -> dict[tuple[int, str], list[tuple[int, int]]]:
    """For each light set and group, (number of the swappable layer, channel): the world's layers, then the emission's."""
    channels: dict[tuple[int, str], list[tuple[int, int]]] = {}
    number = 0
    for layer in plan.swappable:
        channels.setdefault((layer.light_set, WORLD), []).append((number, layer.channel))
        number += 1
    for group in plan.emission:
        for channel, name in enumerate(group.swappable):
            if name:
                channels.setdefault((0, group.name), []).append((number, channel))
                number += 1
    return channels

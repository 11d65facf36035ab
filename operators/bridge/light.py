"""What the world's pixels hold in the passes of either kind of plan, and in the RGB twin."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import Any

import bpy
import numpy as np

from ...spectral_probe.errors import RenderError
from ...spectral_probe.model import Job, Progress, SpectralPanorama
from ...spectral_probe.render_model import EmissionGroup, LightSet, PassPlan
from ...spectral_probe.spectra.colorimetry import spectra_to_xyz, xyz_to_rec709
from ...spectral_probe.spectra.emission import radiance_of_unit_luminance
from ...spectral_probe.spectra.grid import resample
from ...spectral_probe.work import worked
from .own_world import OwnWorld
from .world import temporary_light

type Array = np.ndarray[Any, Any]
type Show = Callable[[Progress, PassPlan, int], Job[None]]


class LayerLight:
    """Light of a light-basis plan: three layers a set, the same in every pass of the set.

    `emission` are the light groups that shine beside it, `world` is the scene's own where that holds the layers.
    """

    def __init__(
        self,
        sets: Sequence[LightSet],
        emission: Sequence[EmissionGroup] = (),
        world: OwnWorld | None = None,
    ) -> None:
        self.sets, self.emission, self.world = tuple(sets), tuple(emission), world
        self.residual = max(light.layers.residual for light in sets)

    @property
    def size(self) -> tuple[int, int]:
        """Height and width of the layers in pixels."""
        height, width, _ = self.sets[0].layers.weights.shape
        return height, width

    def key(self, plan: PassPlan, number: int) -> int:
        """What tells the world's pixels in a pass from those in another."""
        return plan.light_sets[number]

    def pixels(self, plan: PassPlan, number: int) -> Array:
        """Weights (H, W, 3) of the layers in a pass."""
        return self.sets[plan.light_sets[number]].layers.weights

    def checked(self, plan: PassPlan) -> PassPlan:
        """The plan, if it was made for these sets and lamps: its interpolation of a constant must give their spectra."""
        owners = np.asarray(plan.light_sets)
        fits = set(plan.light_sets) == set(range(len(self.sets)))
        for number, light in enumerate(self.sets) if fits else ():
            fits &= _alike(plan.reconstruction[owners == number].sum(0), light.layers.spectra)
        if not fits:
            raise RenderError("The plan was made for another light. Make a new plan for this one.")
        names = [group.name for group in self.emission]
        if [group.name for group in plan.emission] != names or not all(
            _alike(planned.spectra, own.spectra)
            for planned, own in zip(plan.emission, self.emission, strict=True)
        ):
            raise RenderError("The plan was made for other lamps. Make a new plan for those of the scene.")
        return plan


class WavelengthLight:
    """Light of a wavelength plan: radiance at the three wavelengths of a pass over a level, about 1 in the mean.

    It is a panorama's, or, where `probe` is None, that of the scene's own `world`.
    """

    residual = 0.0

    def __init__(
        self,
        probe: SpectralPanorama | None,
        level: float,
        warnings: list[str],
        world: OwnWorld | None = None,
    ) -> None:
        self.probe, self.level, self.warnings, self.world = probe, level, warnings, world

    @property
    def size(self) -> tuple[int, int]:
        """Height and width of the panorama in pixels."""
        height, width = self._panorama.basis_index.shape
        return height, width

    @property
    def _panorama(self) -> SpectralPanorama:
        if self.probe is None:
            raise ValueError("the light is the scene's own world")
        return self.probe

    def key(self, _plan: PassPlan, number: int) -> int:
        """What tells the world's pixels in a pass from those in another."""
        return number

    def pixels(self, plan: PassPlan, number: int) -> Array:
        """Radiance (H, W, 3) at the pass's wavelengths over the level; negative light (which eq. 10 alone allows) is left out."""
        probe = self._panorama
        bases = resample(probe.wavelengths_nm, probe.bases, plan.wavelengths_nm[number])
        radiance = _per_texel(probe, bases) / self.level
        if radiance.min() < -1e-3:
            self.warnings.append("The panorama has negative spectra; they were set to zero.")
        return np.maximum(radiance, 0.0)

    def checked(self, plan: PassPlan) -> PassPlan:
        """The plan with the level, by which the light is divided, in its sum: once, however often it has been rendered."""
        return replace(plan, reconstruction=plan.reconstruction * (self.level / plan.level), level=self.level)


@contextmanager
def shown(scene: bpy.types.Scene, light: LayerLight | WavelengthLight) -> Iterator[Show]:
    """Light the scene while the block runs; yields the job that sets the light to a pass of a plan."""
    world = light.world
    if world is not None:

        def set_world(_progress: Progress, plan: PassPlan, number: int) -> Job[None]:
            world.set_wavelengths(plan.wavelengths_nm[number])
            yield from ()

        yield set_world
        return
    with temporary_light(scene, *light.size) as set_pixels:
        lit: list[int] = []

        def show(progress: Progress, plan: PassPlan, number: int) -> Job[None]:
            if lit != [light.key(plan, number)]:
                set_pixels((yield from worked(progress, partial(light.pixels, plan, number))))
                lit[:] = [light.key(plan, number)]

        yield show


def _alike(spectra: Array, others: Array) -> bool:
    tolerance = max(1e-3 * float(np.abs(others).max()), 1e-30)
    return spectra.shape == others.shape and np.allclose(spectra, others, rtol=1e-3, atol=tolerance)


def _per_texel(probe: SpectralPanorama, values: Array) -> Array:
    """(H, W, 3) of values (B, K, 3) of the bases."""
    texels = np.empty((*probe.basis_index.shape, 3), np.float32)
    for index, basis in enumerate(values):
        mask = probe.basis_index == index
        texels[mask] = probe.weights[mask] @ basis.astype(np.float32)
    return texels


def panorama_rec709(probe: SpectralPanorama) -> Array:
    """The panorama in linear Rec.709, (H, W, 3), in the unit of image.exr, colours out of gamut clipped at zero."""
    bases = resample(probe.wavelengths_nm, probe.bases)
    return np.maximum(_per_texel(probe, xyz_to_rec709(spectra_to_xyz(bases))), 0.0)


def light_level(probe: SpectralPanorama | None) -> float:
    """Mean radiance per nm of the light, by which it is divided before Cycles: some of its thresholds are absolute.

    Without a probe the scene's own world shines as bright as in RGB.
    """
    if probe is None:
        return radiance_of_unit_luminance()
    mean = probe.bases.mean(-1)[..., None].repeat(3, -1)
    level = float(np.maximum(_per_texel(probe, mean)[..., 0], 0.0).mean())
    if not level > 0:
        raise RenderError("The panorama holds no light at all. Build the probe again.")
    return level

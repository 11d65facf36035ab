"""What the world's pixels hold in the passes of either kind of plan, and in the RGB twin."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...spectral_probe.errors import RenderError
from ...spectral_probe.model import SpectralPanorama
from ...spectral_probe.render_model import LightSet, PassPlan
from ...spectral_probe.spectra.colorimetry import spectra_to_xyz, xyz_to_rec709
from ...spectral_probe.spectra.grid import resample

type Array = np.ndarray[Any, Any]


class LayerLight:
    """Light of a light-basis plan: three layers a set, the same in every pass of the set."""

    def __init__(self, sets: Sequence[LightSet]) -> None:
        self.sets = tuple(sets)
        self.residual = max(light.layers.residual for light in sets)

    def key(self, plan: PassPlan, number: int) -> int:
        """What tells the world's pixels in a pass from those in another."""
        return plan.light_sets[number]

    def pixels(self, plan: PassPlan, number: int) -> Array:
        """Weights (H, W, 3) of the layers in a pass."""
        return self.sets[plan.light_sets[number]].layers.weights

    def checked(self, plan: PassPlan) -> PassPlan:
        """The plan, if it was made for these sets: its interpolation of a constant must give their spectra."""
        owners = np.asarray(plan.light_sets)
        fits = set(plan.light_sets) == set(range(len(self.sets)))
        for number, light in enumerate(self.sets) if fits else ():
            spectra, tolerance = light.layers.spectra, 1e-3 * np.abs(light.layers.spectra).max()
            held = plan.reconstruction[owners == number].sum(0)
            fits &= np.allclose(held, spectra, rtol=1e-3, atol=max(tolerance, 1e-30))
        if not fits:
            raise RenderError("The plan was made for another panorama. Make a new plan for this one.")
        return plan


class WavelengthLight:
    """Light of a wavelength plan: the panorama's radiance at the three wavelengths of a pass, about 1 in the mean."""

    residual = 0.0

    def __init__(self, probe: SpectralPanorama, warnings: list[str]) -> None:
        self.probe = probe
        self.level = light_level(probe)
        self.warnings = warnings

    def key(self, _plan: PassPlan, number: int) -> int:
        """What tells the world's pixels in a pass from those in another."""
        return number

    def pixels(self, plan: PassPlan, number: int) -> Array:
        """Radiance (H, W, 3) at the pass's wavelengths over the level; negative light (which eq. 10 alone allows) is left out."""
        probe = self.probe
        bases = resample(probe.wavelengths_nm, probe.bases, plan.wavelengths_nm[number])
        radiance = _per_texel(probe, bases) / self.level
        if radiance.min() < -1e-3:
            self.warnings.append("The panorama has negative spectra; they were set to zero.")
        return np.maximum(radiance, 0.0)

    def checked(self, plan: PassPlan) -> PassPlan:
        """The plan with the panorama's level, by which the light is divided, put back into its sum."""
        return replace(plan, reconstruction=plan.reconstruction * self.level)


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


def light_level(probe: SpectralPanorama) -> float:
    """Mean radiance per nm of the panorama, by which light is divided before Cycles: some of its thresholds are absolute."""
    mean = probe.bases.mean(-1)[..., None].repeat(3, -1)
    level = float(np.maximum(_per_texel(probe, mean)[..., 0], 0.0).mean())
    if not level > 0:
        raise RenderError("The panorama holds no light at all. Build the probe again.")
    return level

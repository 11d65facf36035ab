"""What the world's pixels hold in the passes of either kind of plan, and in the RGB twin."""

from dataclasses import replace
from typing import Any

import numpy as np

from ...spectral_probe.errors import RenderError
from ...spectral_probe.model import SpectralPanorama
from ...spectral_probe.render.layers import colour_error, light_layers
from ...spectral_probe.render.plan import make_plan, reference_plan
from ...spectral_probe.render_model import LightSet, PassPlan
from ...spectral_probe.spectra.colorimetry import spectra_to_xyz, xyz_to_rec709
from ...spectral_probe.spectra.grid import resample

_NOTICEABLE_DE2000 = 2.0
"""Error of a light's colour that one sees side by side."""

type Array = np.ndarray[Any, Any]


class LayerLight:
    """Light of a light-basis plan: three layers, the same in every pass."""

    def __init__(self, probe: SpectralPanorama, warnings: list[str]) -> None:
        self.probe, self.layers = probe, light_layers(probe)
        self.residual = self.layers.residual
        error = colour_error(probe, self.layers)
        if error > _NOTICEABLE_DE2000:
            warnings.append(
                f"Three light layers cannot hold all of this light: surfaces in the worst of it are off by dE2000 {error:.1f}. "
                "Render all wavelengths where they matter."
            )

    def plan(self, reflectances: Array, passes: int | None) -> PassPlan:
        """A plan for these layers and the scene's reflectances (N, 61)."""
        return make_plan(
            (LightSet(self.layers),),
            self.probe,
            reflectances,
            passes=passes or None,
            full_samples=True,
            kind="light-basis",
        )

    def checked(self, plan: PassPlan) -> PassPlan:
        """The plan, if it was made for these layers: its interpolation of a constant must give their spectra."""
        if not np.allclose(
            plan.reconstruction.sum(0), self.layers.spectra, rtol=1e-3, atol=1e-3 * self.layers.spectra.max()
        ):
            raise RenderError("The plan was made for another panorama. Make a new plan for this one.")
        return plan

    def pixels(self, _wavelengths_nm: Array) -> Array:
        """Weights (H, W, 3) of the layers."""
        return self.layers.weights


class WavelengthLight:
    """Light of a wavelength plan: the panorama's radiance at the three wavelengths of a pass, about 1 in the mean."""

    residual = 0.0

    def __init__(self, probe: SpectralPanorama, warnings: list[str]) -> None:
        self.probe = probe
        self.level = _level(probe)
        self.warnings = warnings

    def plan(self, _reflectances: Array, _passes: object) -> PassPlan:
        """The reference plan, which depends on nothing."""
        return reference_plan()

    def checked(self, plan: PassPlan) -> PassPlan:
        """The plan with the panorama's level, by which the light is divided, put back into its sum."""
        return replace(plan, reconstruction=plan.reconstruction * self.level)

    def pixels(self, wavelengths_nm: Array) -> Array:
        """Radiance (H, W, 3) at the wavelengths over the level; negative light (which eq. 10 alone allows) is left out."""
        probe = self.probe
        bases = resample(probe.wavelengths_nm, probe.bases, wavelengths_nm)
        radiance = _per_texel(probe, bases) / self.level
        if radiance.min() < -1e-3:
            self.warnings.append("The panorama has negative spectra; they were set to zero.")
        return np.maximum(radiance, 0.0)


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


def _level(probe: SpectralPanorama) -> float:
    """Mean radiance per nm of the panorama, by which light is divided before Cycles: some of its thresholds are absolute."""
    mean = probe.bases.mean(-1)[..., None].repeat(3, -1)
    level = float(np.maximum(_per_texel(probe, mean)[..., 0], 0.0).mean())
    if not level > 0:
        raise RenderError("The panorama holds no light at all. Build the probe again.")
    return level

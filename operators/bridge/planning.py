"""The plan of a scene's spectral render: from its materials, its lamps and the panorama that lights it."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from ...spectral_probe.errors import RenderError
from ...spectral_probe.model import SpectralPanorama
from ...spectral_probe.render.light_sets import light_sets
from ...spectral_probe.render.plan import make_plan, wavelength_plan
from ...spectral_probe.render_model import LightSet, PassPlan
from .light import panorama_rec709
from .materials import SpectralMaterials
from .own_world import OwnWorld

type Array = np.ndarray[Any, Any]
type Passes = int | Literal["all"] | None

DEFAULT_MAX_DE2000 = 0.5


@dataclass(frozen=True)
class PlanRequest:
    """What a plan is asked to be.

    Parameters
    ----------
    passes
        The number of wavelengths, "all" for the 61-wavelength reference, or None for as few as keep the error bound.
    max_de2000
        The bound on the largest predicted colour error.
    full_samples
        All passes take the same samples; none is estimated as a ratio of another.
    swappable
        Masks (H, W) of the panorama's regions whose light is to be exchanged after rendering, by name.
    lamps_swappable
        The scene's measured lamps are to be exchanged after rendering, too.
    """

    passes: Passes = None
    max_de2000: float = DEFAULT_MAX_DE2000
    full_samples: bool = False
    swappable: Mapping[str, Array] = field(default_factory=dict)
    lamps_swappable: bool = False

    def __post_init__(self) -> None:
        """Refuse what contradicts itself."""
        if self.passes == "all" and (self.swappable or self.lamps_swappable):
            raise RenderError(
                "All 61 wavelengths have no light layers, so no light can be exchanged afterwards. Choose another number of "
                "passes, or make no light swappable."
            )

    @property
    def light_basis(self) -> bool:
        """Whether the light must be in layers: it is to be exchanged, or a number of wavelengths was asked for."""
        return bool(self.passes or self.swappable or self.lamps_swappable)

    def digest(self) -> str:
        """What tells this request from another."""
        words = repr(
            (
                self.passes or None,
                self.max_de2000,
                self.full_samples,
                self.lamps_swappable,
                sorted(self.swappable),
            )
        )
        masks = (np.packbits(self.swappable[name]).tobytes() for name in sorted(self.swappable))
        return _digest(words.encode(), *masks)


@dataclass
class Planner:
    """Makes plans for scenes in one light, and keeps each as long as materials and lamps stay as they are.

    Without a `probe` the light is the scene's own world. `given` is the plan where there is one already.
    """

    probe: SpectralPanorama | None
    request: PlanRequest
    samples: int
    given: PassPlan | None = None
    _plans: dict[str, PassPlan] = field(default_factory=dict)
    _sets: dict[str, tuple[LightSet, ...]] = field(default_factory=dict)
    _rec709_levels: list[float] = field(default_factory=list)

    def digest(self) -> str:
        """What tells the plans that are made from those of another planner in the same light."""
        if self.given is None:
            return self.request.digest()
        given = self.given
        return _digest(given.wavelengths_nm.tobytes(), given.sample_shares.tobytes(),
                       (given.reconstruction / given.level).tobytes())  # fmt: skip

    def rec709_level(self, probe: SpectralPanorama) -> float:
        """Mean of the panorama in Rec.709, by which the light of the RGB twin is divided."""
        if not self._rec709_levels:
            self._rec709_levels.append(float(panorama_rec709(probe).mean()) or 1.0)
        return self._rec709_levels[0]

    def sets(self, materials: SpectralMaterials, world: OwnWorld | None) -> tuple[LightSet, ...]:
        """The light sets for a scene's materials; `world` is the scene's own where there is no probe."""
        if self.probe is None:
            return (LightSet(_given(world).layers),)
        reflectances = _stacked(materials)
        key = _digest(reflectances.tobytes())
        if key not in self._sets:
            self._sets[key] = light_sets(
                self.probe,
                swappable=self.request.swappable,
                reflectances=reflectances,
                max_de2000=self.request.max_de2000,
            )
        return self._sets[key]

    def plan(self, materials: SpectralMaterials, world: OwnWorld | None) -> PassPlan:
        """The plan for a scene's materials and lamps, and for its own world where there is no probe."""
        reflectances = _stacked(materials)
        emission = materials.emission
        panorama = self.probe or _given(world).panorama
        key = _digest(reflectances.tobytes(), repr(materials.dispersive).encode(),
                      *(group.name.encode() + group.spectra.tobytes() for group in emission),
                      b"" if world is None else world.spectra.tobytes())  # fmt: skip
        if key not in self._plans:
            plan = None
            if not self.request.light_basis:
                plan = wavelength_plan(
                    panorama,
                    reflectances,
                    max_de2000=self.request.max_de2000,
                    emission=emission,
                    full_samples=self.request.full_samples,
                    dispersive=materials.dispersive,
                    samples=self.samples,
                )
            self._plans[key] = plan or make_plan(
                self.sets(materials, world),
                panorama,
                reflectances,
                passes=self.request.passes or None,
                max_de2000=self.request.max_de2000,
                emission=emission,
                full_samples=self.request.full_samples or materials.dispersive,
                samples=self.samples,
            )
        return self._plans[key]


def _given(world: OwnWorld | None) -> OwnWorld:
    if world is None:
        raise ValueError("without a probe the scene's own world must be given")
    return world


def _stacked(materials: SpectralMaterials) -> Array:
    return np.concatenate(materials.spectra) if materials.spectra else np.ones((1, 61))


def _digest(*parts: bytes) -> str:
    digest = hashlib.blake2b(digest_size=16)
    for content in parts:
        digest.update(content)
    return digest.hexdigest()

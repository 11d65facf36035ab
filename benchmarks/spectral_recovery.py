"""How well lights that the program has not seen come back from 3, 6 and 9 channels: the table of README and docs/spectra.md.

    python benchmarks/spectral_recovery.py [--camera "Nikon 5100 (NPL)"] [--noise 0.005] [--seed 1] [--every 1] [--json]

The 147 lights of the library are taken one after the other. What the recovery may know of is the rest without every light
whose goodness of fit to the one in hand is above 0.995 (twins such as FL11 and TL-84). The camera sees the light in a ball of
SUS304 at normal incidence with Gaussian noise of 0.5 % of the brightest channel of each shot, which is divided out again. All
figures are means over the lamp families of the families' means.

Columns: goodness of fit (GFC), mean and median; relative RMSE at the true level; difference of correlated colour temperature
in kelvin, mean of the families' medians; mean dE2000 of gold, silver and copper and of the 24 patches of a ColorChecker under the
recovered light, at its own level, seen with the true light's white; share of the wavelengths at which the true spectrum lies in
the stated 95 % band; the stated relative error over the actual one, both as root mean squares.

The filters are analytic: green passes 500-560 nm (peak 0.53 at 530 nm, as a Wratten 58 about does), red what is above 600 nm
(as a Wratten 25). The rows: `paper` with the first three principal components of all other lights; `family told`: only the
light's own family is told; `incandescent + daylight`: both are told, tried on these two; `automatic`: nothing is told.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from spectral_probe.model import FloatArray
from spectral_probe.spectra.camera import camera_sensitivities
from spectral_probe.spectra.colorimetry import delta_e_2000, spectra_to_xyz
from spectral_probe.spectra.grid import STEP_NM, WAVELENGTHS_NM
from spectral_probe.spectra.incidence import incidence_cosines
from spectral_probe.spectra.library import FAMILIES, surface_reflectances, training_lights
from spectral_probe.spectra.metals import ball_reflectance, metal_reflectance
from spectral_probe.spectra.metrics import colour_temperature, goodness_of_fit, relative_rmse
from spectral_probe.spectra.posterior import posterior
from spectral_probe.spectra.prior import ALIKE, classes_of, unit_norm
from spectral_probe.spectra.recovery import SpectralRecovery, recovery_for

GREEN = 0.53 * np.exp(-0.5 * (np.abs(WAVELENGTHS_NM - 530.0) / 30.0) ** 3)
RED = 0.88 / (1.0 + np.exp(-(WAVELENGTHS_NM - 600.0) / 5.0))
SMOOTH = ("incandescent", "daylight")


@dataclass(frozen=True)
class Row:
    """One row of the table: which filters, what is told, and on which families it is tried."""

    name: str
    filters: Sequence[FloatArray] = ()
    told: str = "nothing"
    method: str = "family"
    families: Sequence[str] = tuple(FAMILIES)


ROWS = (
    Row("paper (PCA-3 of all)", method="paper"),
    Row("family told", told="own"),
    Row("incandescent + daylight", told="smooth", families=SMOOTH),
    Row("automatic"),
    Row("automatic, 6 channels", (GREEN,)),
    Row("automatic, 9 channels", (RED, GREEN)),
)


@dataclass(frozen=True)
class Lights:
    """All lights, (N, 61) at 1 at 560 nm, and the family of each."""

    spectra: FloatArray
    family: tuple[str, ...]

    def others(self, index: int) -> dict[str, FloatArray]:
        """By family, the lights of unit norm that are not like that of `index`."""
        unit = unit_norm(self.spectra)
        unlike = unit @ unit[index] <= ALIKE
        known = {
            family: unit[unlike & np.array([own == family for own in self.family])] for family in FAMILIES
        }
        return {family: lights for family, lights in known.items() if len(lights)}


def all_lights() -> Lights:
    """Every light of the library."""
    spectra = {family: training_lights([family]) for family in FAMILIES}
    return Lights(
        np.concatenate(list(spectra.values())),
        tuple(family for family, lights in spectra.items() for _ in lights),
    )


def recovery_without(lights: Lights, index: int, row: Row, sensitivities: FloatArray) -> SpectralRecovery:
    """The recovery of a light that must not be known."""
    others = lights.others(index)
    told = {"own": (lights.family[index],), "smooth": SMOOTH}.get(row.told, tuple(others))
    known = {family: others[family] for family in told if family in others}
    return recovery_for(classes_of(known, others), sensitivities, row.method)


def measure(row: Row, camera: FloatArray, noise: float, seed: int, every: int = 1) -> dict[str, float]:
    """The numbers of one row."""
    lights = all_lights()
    rng = np.random.default_rng(seed)
    sensitivities = np.concatenate([camera * curve[:, None] for curve in (1.0 + 0 * GREEN, *row.filters)], 1)
    steel = ball_reflectance("SUS304", incidence_cosines())
    scores: dict[str, dict[str, list[float]]] = {}
    for index, (light, family) in enumerate(zip(lights.spectra, lights.family, strict=True)):
        shots = ((light * steel[-1]) @ sensitivities * STEP_NM).reshape(-1, 3)
        deviation = noise * shots.max(-1, keepdims=True) * np.ones_like(shots)
        shots = shots + deviation * rng.standard_normal(shots.shape)
        if family not in row.families or index % every:
            continue
        recovery = recovery_without(lights, index, row, sensitivities)
        responses = []
        for shot, own in enumerate(shots):
            correction = recovery.incidence_correction(steel, slice(3 * shot, 3 * shot + 3))
            responses.append(correction.light_responses(own, np.array(1.0)))
        found = recovery.recover(np.concatenate(responses))
        estimate = found.weights @ recovery.bases[found.basis_index]
        known = posterior(recovery, np.concatenate(responses))
        inside = np.abs(light - estimate) <= 1.96 * known.standard_error
        numbers = _numbers(np.asarray(estimate, float), light) | {
            "coverage": float(inside.mean()),
            "stated": known.relative_error,
        }
        for name, value in numbers.items():
            scores.setdefault(name, {}).setdefault(family, []).append(value)
    return _summary(scores)


def _numbers(estimate: FloatArray, light: FloatArray) -> dict[str, float]:
    found, true = colour_temperature(estimate), colour_temperature(light)
    metals = np.stack([metal_reflectance(metal, np.array(1.0)) for metal in ("Au", "Ag", "Cu")])
    return {
        "gfc": float(goodness_of_fit(estimate, light)),
        "relative_rmse": float(relative_rmse(estimate, light, same_energy=False)),
        "cct": abs(found[0] - true[0]) if found and true else np.nan,
        "metals": _surfaces(estimate, light, metals),
        "colorchecker": _surfaces(estimate, light, surface_reflectances()),
    }


def _surfaces(estimate: FloatArray, light: FloatArray, surfaces: FloatArray) -> float:
    """Mean dE2000 of surfaces under two lights as they are, seen with the true one's white."""
    xyz = [spectra_to_xyz(np.maximum(one, 0) * surfaces) for one in (estimate, light)]
    white = spectra_to_xyz(light)
    return float(delta_e_2000(xyz[0] / white[1], xyz[1] / white[1], white / white[1]).mean())


def _summary(scores: Mapping[str, Mapping[str, Sequence[float]]]) -> dict[str, float]:
    def over_families(name: str) -> float:
        return float(np.mean([np.mean(values) for values in scores[name].values()]))

    every_gfc = [value for values in scores["gfc"].values() for value in values]
    summary = {name: over_families(name) for name in scores if name not in {"cct", "stated"}}
    summary["gfc_median"] = float(np.median(every_gfc))
    medians = [np.nanmedian(values) for values in scores["cct"].values() if np.isfinite(values).any()]
    summary["cct"] = float(np.mean(medians))
    squares = [
        np.sqrt(np.mean(np.concatenate([np.square(v) for v in scores[name].values()])))
        for name in ("stated", "relative_rmse")
    ]
    summary["stated_over_actual"] = float(squares[0] / squares[1])
    return summary


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--camera", default="Nikon 5100 (NPL)", help="name of the library, or a file")
    parser.add_argument("--noise", type=float, default=0.005)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--every", type=int, default=1, help="take only every n-th light")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    file = Path(arguments.camera)
    camera = camera_sensitivities(
        None if file.is_file() else arguments.camera, file if file.is_file() else None
    )
    table = {}
    for row in ROWS:
        table[row.name] = measure(row, camera, arguments.noise, arguments.seed, arguments.every)
        if not arguments.json:
            numbers = table[row.name]
            sys.stdout.write(
                f"{row.name:26s} GFC {numbers['gfc']:.4f} median {numbers['gfc_median']:.4f}  rel. RMSE "
                f"{numbers['relative_rmse']:.3f}  dCCT {numbers['cct']:4.0f} K  dE2000 metals {numbers['metals']:.2f} "
                f"ColorChecker {numbers['colorchecker']:.2f}  in band {numbers['coverage']:.1%}  stated/actual "
                f"{numbers['stated_over_actual']:.2f}\n"
            )
            sys.stdout.flush()
    if arguments.json:
        sys.stdout.write(json.dumps(table, indent=1) + "\n")


if __name__ == "__main__":
    main()

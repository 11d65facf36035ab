"""What a probe remembers of its recovery, and what that says of its light: so probe.exr alone answers how sure it is."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import FileFormatError
from ..files.json_object import UNREADABLE
from ..geometry.frames import panorama_solid_angles
from ..large import let_go, strips
from ..model import BoolArray, FloatArray, SpectralPanorama, Texels
from .confidence import error_of_confidence
from .edits import is_edited, recovered_basis, recovered_index, stacks_of
from .emitters import direct_probability
from .estimates import ClassEstimate
from .grid import STEP_NM, WAVELENGTHS_NM, resample
from .posterior import Posterior, posterior
from .recovery import SpectralRecovery
from .regions import texels_of

ENTRY = "recovery"
"""Name of the entry in `SpectralPanorama.further`."""

_KEPT = 0.999
"""Share of the variance of an estimate's errors that is remembered by their principal components."""

REPLACED = "replaced"
"""The kind of light where an edit put another lamp."""

_AT_A_TIME = 65536  # texels

_DIGITS = 7

_LARGEST = 1e30
"""Numbers of a recovery are smaller than this."""


def record(lights: Sequence[tuple[int, SpectralRecovery]], surface: float) -> dict[str, Any]:
    """The recoveries of a panorama, for `SpectralPanorama.further`.

    Parameters
    ----------
    lights
        Each recovery with the number of its first basis.
    surface
        `emitters.surface_luminance` of the panorama.
    """
    return {
        "surface_luminance": float(surface),
        "lights": [
            {
                "bases": [first, len(recovery.bases)],
                "method": recovery.method,
                "sensitivities": _rounded(recovery.sensitivities),
                "estimates": [_estimate_entry(estimate) for estimate in recovery.estimates],
            }
            for first, recovery in lights
        ],
    }


def _estimate_entry(estimate: ClassEstimate) -> dict[str, Any]:
    values, vectors = np.linalg.eigh(estimate.error)
    values = np.asarray(np.maximum(values[::-1], 0))
    count = 1 + int(np.searchsorted(np.cumsum(values), _KEPT * values.sum()))
    whole = float(
        values.sum() / max(float(values[:count].sum()), 1e-30)
    )  # what is left out raises the others alike
    scaled = vectors[:, ::-1][:, :count] * np.sqrt(values[:count] * whole)
    return {
        "name": estimate.name,
        "share": estimate.share,
        "direct": estimate.direct,
        "operator": _rounded(estimate.operator),
        "precision": _rounded(estimate.precision),
        "error_components": _rounded(scaled.T),
    }


def _rounded(values: FloatArray) -> Any:
    return np.vectorize(lambda value: float(f"{value:.{_DIGITS}g}"))(values).tolist()


def light_posterior(panorama: SpectralPanorama, chosen: BoolArray | Texels) -> Posterior | None:
    """What is known of the mean spectrum of some texels of a panorama, before any edit, all seen.

    None where the probe does not tell how it was recovered, or where the texels' light was replaced by another lamp's. Where
    the texels were recovered in different ways the answer is that of most of them.

    Raises
    ------
    FileFormatError
        If the probe's header is damaged.
    """
    entry = panorama.further.get(ENTRY)
    replaced = [
        is_edited(panorama, number)
        for number, edit in enumerate(panorama.edits)
        if edit.kind == "lamp" and edit.keeps != "surfaces"
    ]
    parts = _texels_by_strips(panorama, chosen)
    used = np.unique(np.concatenate([np.unique(panorama.basis_index[texels]) for texels in parts()]))
    if entry is None or any(mask[used].any() for mask in replaced):
        return None
    try:
        return _light_posterior(panorama, parts, entry)
    except (*UNREADABLE, np.linalg.LinAlgError):
        raise FileFormatError(
            "The probe's header is damaged. Build the probe again from its capture."
        ) from None


def _texels_by_strips(
    panorama: SpectralPanorama, chosen: BoolArray | Texels
) -> Callable[[], Iterator[Texels]]:
    """The texels, those of a mask strip by strip: of millions, what is worked out for each takes much memory."""

    def parts() -> Iterator[Texels]:
        if isinstance(chosen, tuple):
            yield chosen
            return
        for rows in strips(*chosen.shape):
            own, columns = texels_of(chosen[rows])
            yield own + rows.start, columns
            let_go(panorama.weights)

    return parts


def _light_posterior(
    panorama: SpectralPanorama, parts: Callable[[], Iterator[Texels]], entry: Mapping[str, Any]
) -> Posterior | None:
    def solid_angles_and_ways(chosen: Texels) -> tuple[FloatArray, list[BoolArray]]:
        index = recovered_basis(panorama, panorama.basis_index[chosen])
        ways = [(index >= light["bases"][0]) & (index < sum(light["bases"])) for light in entry["lights"]]
        return panorama_solid_angles(*panorama.valid.shape)[chosen[0], 0], ways

    totals = np.zeros(len(entry["lights"]))
    for chosen in parts():
        solid_angles, ways = solid_angles_and_ways(chosen)
        totals += [solid_angles[way].sum() for way in ways]
    most = int(np.argmax(totals))
    light = entry["lights"][most]
    recovery = _recovery(panorama, light)
    bases = resample(panorama.wavelengths_nm, panorama.bases, WAVELENGTHS_NM, name="the panorama's basis")
    to_responses = bases @ (recovery.sensitivities * STEP_NM)
    surface = float(_numbers(entry["surface_luminance"]))
    mean, direct, confidence = np.zeros(to_responses.shape[-1]), 0.0, 0.0
    for chosen in parts():
        solid_angles, ways = solid_angles_and_ways(chosen)
        rows, columns = (places[ways[most]] for places in chosen)
        shares = solid_angles[ways[most]] / totals[most]
        responses = np.empty((len(rows), to_responses.shape[-1]))
        for start in range(0, len(rows), _AT_A_TIME):
            few = rows[start : start + _AT_A_TIME], columns[start : start + _AT_A_TIME]
            index = recovered_basis(panorama, panorama.basis_index[few])
            np.einsum(
                "nk,nkc->nc",
                panorama.weights[few],
                to_responses[index],
                out=responses[start : start + _AT_A_TIME],
            )
        luminance = responses[:, :3] @ recovery.to_luminance
        direct += float(shares @ direct_probability(luminance, surface))
        confidence += float(shares @ panorama.confidence[rows, columns])
        mean += shares @ responses
    known = posterior(recovery, mean, direct=direct)
    return known.at_least(error_of_confidence(confidence))  # the texels' own error counts their noise too


@dataclass(frozen=True)
class LightKinds:
    """Which kind of light each texel of a panorama is most probably.

    `names` are those of the kinds, `REPLACED` the last; `index` (H, W) uint8 counts in them; `probability` (H, W) float32.
    """

    names: tuple[str, ...]
    index: npt.NDArray[np.uint8]
    probability: FloatArray


def light_kinds(panorama: SpectralPanorama) -> LightKinds:
    """The likeliest kind of light of every texel of a panorama, from its own responses alone.

    Texels whose light was replaced by another lamp's are `REPLACED`. What no view saw has no kind: see `panorama.valid`.

    Raises
    ------
    FileFormatError
        If the probe does not tell how it was recovered, or its header is damaged.
    """
    entry = panorama.further.get(ENTRY)
    if entry is None:
        raise FileFormatError(
            "This panorama does not tell how its light was recovered. Build the probe from its photographs."
        )
    try:
        return _light_kinds(panorama, entry)
    except (*UNREADABLE, np.linalg.LinAlgError):
        raise FileFormatError(
            "The probe's header is damaged. Build the probe again from its capture."
        ) from None


def _light_kinds(panorama: SpectralPanorama, entry: Mapping[str, Any]) -> LightKinds:
    names = tuple(dict.fromkeys(one["name"] for light in entry["lights"] for one in light["estimates"]))
    bases = resample(panorama.wavelengths_nm, panorama.bases, WAVELENGTHS_NM, name="the panorama's basis")
    surface = float(_numbers(entry["surface_luminance"]))
    found = np.zeros(panorama.valid.shape, np.uint8)
    probability = np.zeros(panorama.valid.shape, np.float32)
    for light in entry["lights"]:
        recovery = _recovery(panorama, light)
        number_of = np.array([names.index(estimate.name) for estimate in recovery.estimates], np.uint8)
        to_responses = (bases @ (recovery.sensitivities * STEP_NM)).astype(np.float32)
        first, count = light["bases"]
        for basis in range(first, first + count):
            rows, columns = np.nonzero(recovered_index(panorama) == basis)
            for start in range(0, len(rows), _AT_A_TIME):
                few = rows[start : start + _AT_A_TIME], columns[start : start + _AT_A_TIME]
                responses = panorama.weights[few] @ to_responses[basis]
                direct = direct_probability(responses[:, :3] @ recovery.to_luminance, surface)
                likely = recovery.probabilities(responses, direct)
                found[few] = number_of[likely.argmax(-1)]
                probability[few] = likely.max(-1)
    replaced = [edit.kind == "lamp" and edit.keeps != "surfaces" for edit in panorama.edits]
    known = np.array([any(replaced[edit] for edit in stack[1:]) for stack in stacks_of(panorama)])
    changed = known[panorama.basis_index]
    found[changed], probability[changed] = len(names), 1.0
    return LightKinds((*names, REPLACED), found, probability)


def _numbers(values: Any) -> FloatArray:
    """An array of the header; ValueError where it holds what no recovery gives."""
    array = np.asarray(values, float)
    if not (np.abs(array) < _LARGEST).all():
        raise ValueError("not numbers")
    return array


def _recovery(panorama: SpectralPanorama, light: Mapping[str, Any]) -> SpectralRecovery:
    """A recovery as it was recorded; it makes no more spectra, so it needs no positive one."""
    estimates = []
    for one in light["estimates"]:
        components = _numbers(one["error_components"])
        if not 0 < float(one["share"]) <= 1:
            raise ValueError("a share is no probability")
        estimates.append(
            ClassEstimate(
                str(one["name"]),
                float(one["share"]),
                one["direct"],
                _numbers(one["operator"]),
                _numbers(one["precision"]),
                components.T @ components,
            )
        )
    first, count = light["bases"]
    sensitivities = _numbers(light["sensitivities"])
    return SpectralRecovery(
        sensitivities,
        tuple(estimates),
        panorama.bases[first : first + count],
        None,
        np.zeros((len(sensitivities), len(sensitivities))),
        str(light["method"]),
    )

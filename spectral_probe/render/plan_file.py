"""Plans as files, whole and exact, and in words."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FileFormatError
from ..files.atomic import written_whole
from ..files.json_object import UNREADABLE, read_object
from ..model import FloatArray
from ..render_model import EmissionGroup, PassPlan, SwappableLayer

_FORMAT = "spectral-probe-plan-2"
_OLD_FORMATS = ("spectral-probe-plan-1",)


def save_plan(plan: PassPlan, path: Path) -> None:
    """Write a plan as JSON, whole or not at all."""
    text = json.dumps(
        {
            "format": _FORMAT,
            "kind": plan.kind,
            "wavelengths_nm": plan.wavelengths_nm.tolist(),
            "reconstruction": plan.reconstruction.tolist(),
            "grid_nm": plan.grid_nm.tolist(),
            "sample_shares": plan.sample_shares.tolist(),
            "references": list(plan.references),
            "light_sets": list(plan.light_sets),
            "interpolation": None if plan.interpolation is None else plan.interpolation.tolist(),
            "emission": [
                {
                    "name": group.name,
                    "spectra": group.spectra.tolist(),
                    "swappable": list(group.swappable),
                }
                for group in plan.emission
            ],
            "predicted_de2000": plan.predicted_de2000,
            "predicted_cost": plan.predicted_cost,
            "swappable": [
                {
                    "name": layer.name,
                    "light_set": layer.light_set,
                    "channel": layer.channel,
                    "recovered": layer.recovered.tolist(),
                }
                for layer in plan.swappable
            ],
            "notes": list(plan.notes),
            "consecutive": plan.consecutive,
            "level": plan.level,
        }
    )
    with written_whole(path) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")


def load_plan(path: Path) -> PassPlan:
    """Read a plan that `save_plan` wrote; numbers come back exactly.

    Raises
    ------
    FileFormatError
        If the file is missing, is no plan, or was written by an earlier version.
    """
    wrong = FileFormatError(f"{path} is not a plan of passes. Give the plan.json of a spectral render.")
    if not Path(path).is_file():
        raise FileFormatError(f"{path} cannot be read. Give the plan.json of a spectral render.")
    try:
        content = read_object(Path(path))
    except UNREADABLE:
        raise wrong from None
    if content.get("format") in _OLD_FORMATS:
        raise FileFormatError(
            f"{path} is a plan of an earlier version, which lacks what a render needs now. Render again to make a new one."
        )
    if content.get("format") != _FORMAT:
        raise wrong
    try:
        plan = _plan_from(content)
    except UNREADABLE:
        raise wrong from None
    if not _consistent(plan):
        raise wrong
    return plan


def _plan_from(content: Mapping[str, Any]) -> PassPlan:
    predicted, cost = content["predicted_de2000"], content["predicted_cost"]
    interpolation = content["interpolation"]
    return PassPlan(
        kind=content["kind"],
        wavelengths_nm=_array(content["wavelengths_nm"]),
        reconstruction=_array(content["reconstruction"]),
        grid_nm=_array(content["grid_nm"]),
        sample_shares=_array(content["sample_shares"]),
        references=tuple(int(number) for number in content["references"]),
        light_sets=tuple(int(number) for number in content["light_sets"]),
        interpolation=None if interpolation is None else _array(interpolation),
        emission=tuple(
            EmissionGroup(str(group["name"]), _array(group["spectra"]), _names(group["swappable"]))
            for group in content["emission"]
        ),
        predicted_de2000=None if predicted is None else (float(predicted[0]), float(predicted[1])),
        predicted_cost=None if cost is None else float(cost),
        swappable=tuple(
            SwappableLayer(
                str(layer["name"]), int(layer["light_set"]), int(layer["channel"]), _array(layer["recovered"])
            )
            for layer in content["swappable"]
        ),
        notes=tuple(str(note) for note in content["notes"]),
        consecutive=bool(content["consecutive"]),
        level=float(content["level"]),
    )


def _array(values: Any) -> FloatArray:
    return np.array(values, float)


def _names(values: Any) -> tuple[str, str, str]:
    first, second, third = (str(value) for value in values)
    return first, second, third


def _consistent(plan: PassPlan) -> bool:
    """Shapes and numbers of passes, sets and channels agree with each other."""
    passes, grid = len(plan.sample_shares), len(plan.grid_nm)
    counts = len(plan.references), len(plan.light_sets)
    return (
        passes > 0
        and plan.kind in ("light-basis", "wavelength")
        and plan.sample_shares.shape == (passes,)
        and plan.grid_nm.shape == (grid,)
        and plan.wavelengths_nm.shape == (passes, 3)
        and plan.reconstruction.shape == (passes, 3, grid)
        and counts == (passes, passes)
        and all(0 <= number < passes for number in plan.references)
        and all(plan.references[number] == number for number in plan.references)
        and all(number >= 0 for number in plan.light_sets)
        and (plan.interpolation is None) == (plan.kind == "wavelength")
        and (plan.interpolation is None or plan.interpolation.shape == (passes, grid))
        and 0 < plan.level < np.inf
        and all(group.spectra.shape == (3, grid) for group in plan.emission)
        and all(
            layer.recovered.shape == (grid,)
            and layer.channel in range(3)
            and layer.light_set in plan.light_sets
            for layer in plan.swappable
        )
    )


def describe(plan: PassPlan) -> list[str]:
    """A plan in plain sentences: its kind, wavelengths, what it costs and how wrong it is predicted to be.

    Examples
    --------
    >>> from spectral_probe.render.plan import reference_plan
    >>> for sentence in describe(reference_plan()):
    ...     print(sentence)
    21 passes of three wavelengths each, light and materials alike: 61 wavelengths from 400 to 700 nm.
    Predicted cost: the samples of 21 RGB renders.
    """
    sentences = [*_kind(plan), *plan.notes]
    if plan.predicted_de2000 is not None:
        mean, largest = plan.predicted_de2000
        sentences.append(
            f"Predicted colour error against all 61 wavelengths: dE2000 {mean:.2f} in the mean, within "
            f"{largest:.2f} for 99 of 100 pixels."
        )
    if plan.predicted_cost is not None:
        cost = f"{plan.predicted_cost:.3g}"
        sentences.append(f"Predicted cost: the samples of {cost} RGB render{'s' if cost != '1' else ''}.")
    names = list(dict.fromkeys(name for name in swappable_names(plan) if name))
    if names:
        sentences.append(f"Lights that can be exchanged after rendering: {', '.join(names)}.")
    return sentences


def swappable_names(plan: PassPlan) -> list[str]:
    """Names of the swappable layers in the order of their storage: the world's, then those of the emission groups."""
    return [layer.name for layer in plan.swappable] + [
        name for group in plan.emission for name in group.swappable if name
    ]


def _kind(plan: PassPlan) -> list[str]:
    if plan.kind == "wavelength":
        used = np.unique(plan.wavelengths_nm)
        listed = f"{len(used)} wavelengths from {used[0]:g} to {used[-1]:g} nm"
        if len(used) < len(plan.grid_nm):
            listed = f"{', '.join(f'{nm:g}' for nm in used)} nm"
        return [f"{plan.passes} passes of three wavelengths each, light and materials alike: {listed}."]
    count = max(plan.light_sets) + 1
    sentences = [
        f"{plan.passes} passes of one wavelength each"
        + (f" in {count} sets of three light layers" if count > 1 else ", the light in three layers")
        + "."
    ]
    for number in range(count):
        own = [row for row, light_set in enumerate(plan.light_sets) if light_set == number]
        full = {plan.references[row] for row in own}
        listed = ", ".join(f"{plan.wavelengths_nm[row, 0]:g}" for row in own)
        named = ", ".join(f"{plan.wavelengths_nm[row, 0]:g}" for row in sorted(full))
        where = f"Set {number + 1}" if count > 1 else "Wavelengths"
        shared = "" if len(full) == len(own) else f", the most samples at {named} nm"
        sentences.append(f"{where}: {listed} nm{shared}.")
    return sentences

"""Stated exposures checked against the pixels of an aligned bracket."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ..model import BoolArray, Exposure, FloatArray, Photograph
from .read import srgb_to_linear
from .response import fit_response
from .samples import Cells

TOLERANCE_EV = 0.15
"""Stated and solved exposures this near each other agree: shutters and apertures are hardly better, and measured offsets of
right ones stay within 0.1 EV even through a tone curve."""

SIGNIFICANCE = 3.0
"""A disagreement counts only beyond this many of its standard errors."""

SAME_EV = 0.08
"""Photographs whose pixels are this near each other, and within a quarter of the stated step, have one exposure. Tone curves
stretch steps in mid-tones or leave them about as they are: a third of an EV never looks like this little."""

TYPICAL_EXPONENT = 0.7
"""Cameras' pictures are more contrasty than sRGB's curve says: a true EV looks like 1.2 to 1.6. It decides only where the
bracket alone cannot."""

EXPONENT_ERROR = 0.3
"""Standard deviation of its logarithm: from 0.4 (very contrasty) to 1.3 (flat profiles) within two."""

GAMMA_EXPONENT = 1.5
"""Linear pictures that need this exponent to agree with their exposures are not linear."""

LEAST_CELLS = 20
_LN2 = float(np.log(2.0))


@dataclass(frozen=True)
class ExposureCheck:
    """What the pixels say of a bracket's exposures.

    `exposures` are those to use, one per photograph; `offsets_ev` (E,) solved minus stated, NaN where a photograph shares too few
    pixels with the others, and `errors_ev` (E,) their standard errors; `warnings` one sentence each.
    """

    exposures: tuple[Exposure, ...]
    offsets_ev: tuple[float, ...]
    errors_ev: tuple[float, ...]
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class _Ratios:
    """Logarithm of the light of photograph k over that of j: `ratio` (E, E), its standard error, number of cells."""

    ratio: FloatArray
    error: FloatArray
    count: FloatArray


def check_exposures(
    photographs: Sequence[Photograph], stated: Sequence[Exposure], cells: Cells, *, solve: bool = True
) -> ExposureCheck:
    """Compare stated exposures with the pixels, and replace those that are wrong.

    The pixels' exposures follow from the ratios of all pairs of photographs, of linear pictures directly, of display-referred
    ones together with the camera's response.

    Parameters
    ----------
    photographs
        The bracket; only the names are used.
    stated
        One per photograph.
    cells
        Their common cells (`samples.chosen`).
    solve
        Whether a solved exposure takes the place of a stated one that disagrees; otherwise it is only said.

    Notes
    -----
    Ratios tell no absolute exposure, and through a tone curve not even their exponent. Both are chosen so that as many stated
    exposures as possible stay (offset 0, which then is their median); where as many speak for one choice as for another, by the
    contrast that cameras usually have, and then for the first photograph.
    """
    names = [photograph.path.name for photograph in photographs]
    logs = np.log([exposure.relative for exposure in stated])
    ratios = _pair_ratios(cells)
    rough, rough_error = _from_ratios(ratios)
    linked = np.isfinite(rough)
    if linked.sum() < 2:
        nothing = (float("nan"),) * len(names)
        return ExposureCheck(tuple(stated), nothing, nothing, ())
    warnings = _same_exposure(names, stated, logs, ratios)
    reference = logs
    if _runs_against(logs[linked], rough[linked]):
        warnings.append(_reversed(names, logs, rough, solve))
        reference = logs.copy()
        reference[linked] = np.sort(logs[linked])[np.argsort(np.argsort(rough[linked]))]
    solved, error = _solved(cells, rough, rough_error, reference, logs)
    offsets = np.where(linked, solved - reference, np.nan)
    offsets -= _agreed(offsets[linked])
    wrong = linked & (np.abs(offsets) > np.maximum(TOLERANCE_EV * _LN2, SIGNIFICANCE * error))
    exponent = _exponent(rough[linked], reference[linked])
    if not cells.encoded and linked.sum() >= 3 and exponent > GAMMA_EXPONENT:
        told = tuple(map(float, offsets / _LN2)), tuple(map(float, error / _LN2))
        return ExposureCheck(tuple(stated), *told, (*warnings, _encoded(1.0 / exponent)))
    few = int(linked.sum()) <= (3 if cells.encoded else 2)
    used = list(stated)
    for index, exposure in enumerate(stated):
        factor = float(np.exp(reference[index] + (offsets[index] if wrong[index] else 0.0) - logs[index]))
        if reference[index] != logs[index] or wrong[index]:
            used[index] = _times(exposure, factor) if solve else exposure
        if wrong[index]:
            warnings.append(_wrong(names[index], exposure, factor, solve, few))
    total = (offsets + reference - logs) / _LN2
    return ExposureCheck(
        tuple(used), tuple(map(float, total)), tuple(map(float, error / _LN2)), tuple(warnings)
    )


def _solved(
    cells: Cells, rough: FloatArray, rough_error: FloatArray, reference: FloatArray, logs: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Log exposures (E,) and their errors: those of the ratios, or through a tone curve those that fit with it."""
    linked = np.isfinite(rough)
    if not cells.encoded or np.ptp(rough[linked]) <= 2.0 * SAME_EV * _LN2:
        return rough, rough_error
    fit = fit_response(cells, np.where(linked, TYPICAL_EXPONENT * rough, logs), free=True)
    exponent = _exponent(fit.log_exposures[linked], reference[linked])
    return np.where(linked, exponent * fit.log_exposures, np.nan), exponent * fit.log_exposure_errors


def _pair_ratios(cells: Cells) -> _Ratios:
    """Median ratios of the better exposed half of the cells that two photographs share."""
    photos = len(cells.values)
    light = np.log(np.maximum(srgb_to_linear(cells.values) if cells.encoded else cells.values, 1e-12))
    ratio, error = np.full((photos, photos), np.nan), np.full((photos, photos), np.inf)
    count = np.zeros((photos, photos))
    for j, k in combinations(range(photos), 2):
        both = cells.usable[j] & cells.usable[k]
        number = int(both.sum())
        count[j, k] = count[k, j] = number
        if number < 3 * LEAST_CELLS:
            continue
        level = light[j][both] + light[k][both]
        better = level >= np.median(level)
        steps = (light[k] - light[j])[both][better]
        middle = float(np.median(steps))
        spread = 1.4826 * float(np.median(np.abs(steps - middle)))
        # Neighbours and channels err alike: a ninth of the cells counts. Nothing is known better than to a hundredth.
        scatter = float(np.hypot(1.2533 * spread / np.sqrt(len(steps) / 9.0), 0.01))
        ratio[j, k], ratio[k, j] = middle, -middle
        error[j, k] = error[k, j] = scatter
    return _Ratios(ratio, error, count)


def _from_ratios(ratios: _Ratios) -> tuple[FloatArray, FloatArray]:
    """Log exposures (E,) by robust least squares over the pairs, mean 0, and standard errors; NaN where nothing links them."""
    photos = len(ratios.ratio)
    linked = _largest_group(np.isfinite(ratios.ratio))
    solved, error = np.full(photos, np.nan), np.full(photos, np.inf)
    members = np.flatnonzero(linked)
    if len(members) < 2:
        return solved, error
    rows, aims, errors = [], [], []
    for j, k in combinations(range(len(members)), 2):
        value = ratios.ratio[members[j], members[k]]
        if np.isfinite(value):
            row = np.zeros(len(members))
            row[j], row[k] = -1.0, 1.0
            rows.append(row)
            aims.append(value)
            errors.append(ratios.error[members[j], members[k]])
    design, aim, sigma = np.array(rows), np.array(aims), np.array(errors)
    weights = 1.0 / sigma**2
    answer = np.zeros(len(members))
    normal = np.eye(len(members))
    for _ in range(10):
        normal = design.T @ (weights[:, None] * design) + np.ones((len(members), len(members)))
        answer = np.linalg.solve(normal, design.T @ (weights * aim))
        misfit = np.abs(design @ answer - aim) / sigma
        weights = np.minimum(1.0, 2.0 / np.maximum(misfit, 1e-12)) / sigma**2
    scatter = max(1.0, float(np.sqrt(np.average((design @ answer - aim) ** 2 / sigma**2))))
    solved[members] = answer
    error[members] = scatter * np.sqrt(
        np.maximum(np.diag(np.linalg.inv(normal)) - 1.0 / len(members) ** 2, 0.0)
    )
    return solved, error


def _largest_group(linked: BoolArray) -> BoolArray:
    """Photographs (E,) of the largest set that pairs link, directly or through others."""
    reach = linked | np.eye(len(linked), dtype=bool)
    for _ in range(len(linked)):
        reach = (reach.astype(int) @ reach.astype(int)) > 0
    return np.asarray(reach[int(np.argmax(reach.sum(1)))])


def _exponent(solved: FloatArray, stated: FloatArray) -> float:
    """The exponent under which most stated exposures agree with the solved ones, from those that any two imply."""
    candidates = [1.0]
    for j, k in combinations(range(len(solved)), 2):
        if abs(solved[k] - solved[j]) > 0.3 * _LN2:
            candidates.append(float((stated[k] - stated[j]) / (solved[k] - solved[j])))
    candidates = [value for value in candidates if value > 0.1]

    def cost(exponent: float) -> float:
        offsets = exponent * solved - stated
        unlikely = 0.5 * (np.log(exponent) / EXPONENT_ERROR) ** 2
        return _disagreement(offsets, _agreed(offsets)) + float(unlikely)

    best = min(candidates, key=cost)
    offsets = best * solved - stated
    agree = np.abs(offsets - _agreed(offsets)) < TOLERANCE_EV * _LN2
    spread = solved[agree] - solved[agree].mean()
    if np.abs(spread).max() < 0.3 * _LN2:
        return best
    return float(spread @ (stated[agree] - stated[agree].mean()) / (spread @ spread))


def _agreed(offsets: FloatArray) -> float:
    """The offset that most photographs share: the median of those round the best one."""
    best = min(offsets, key=lambda offset: _disagreement(offsets, offset))
    return float(np.median(offsets[np.abs(offsets - best) <= TOLERANCE_EV * _LN2]))


def _disagreement(offsets: FloatArray, common: float) -> float:
    """Sum of the deviations in units of the tolerance, each at most two."""
    return float(np.minimum(np.abs(offsets - common) / (TOLERANCE_EV * _LN2), 2.0).sum())


def _runs_against(stated: FloatArray, measured: FloatArray) -> bool:
    """Whether the longer exposure is the darker picture in nearly all pairs that differ clearly."""
    against = along = 0
    for j, k in combinations(range(len(stated)), 2):
        steps = np.array([stated[k] - stated[j], measured[k] - measured[j]])
        if (np.abs(steps) > 0.25 * _LN2).all():
            against += bool(steps[0] * steps[1] < 0.0)
            along += bool(steps[0] * steps[1] > 0.0)
    return against > 0 and against >= 4 * along


def _same_exposure(
    names: Sequence[str], stated: Sequence[Exposure], logs: FloatArray, ratios: _Ratios
) -> list[str]:
    """A sentence for each pair whose pixels are exposed alike though the stated exposures differ; no response is needed."""
    said = []
    for j, k in combinations(range(len(names)), 2):
        step = abs(logs[k] - logs[j]) / _LN2
        seen = abs(ratios.ratio[j, k]) / _LN2
        if step > TOLERANCE_EV and seen < min(SAME_EV, 0.25 * step):
            said.append(
                f"{names[j]} and {names[k]} are the same exposure ({seen:.2f} EV apart in their pixels), though "
                f"{described(stated[j])} and {described(stated[k])} are stated ({step:.2f} EV apart)."
            )
    return said


def _reversed(names: Sequence[str], logs: FloatArray, measured: FloatArray, solve: bool) -> str:
    longest = int(np.nanargmax(np.where(np.isfinite(measured), logs, np.nan)))
    darkest = " is the darkest" if longest == int(np.nanargmin(measured)) else " is among the darkest"
    used = "they are taken in reversed order" if solve else "they are kept (solve_exposures = false)"
    return (
        f"The stated exposures run opposite to the pictures' brightness ({names[longest]}, stated as the longest,"
        f"{darkest}): {used}. Check exposures_s."
    )


def _wrong(name: str, stated: Exposure, factor: float, solve: bool, few: bool) -> str:
    right = described(_times(stated, factor))
    used = "the pixels' value is used" if solve else "the stated value is kept (solve_exposures = false)"
    doubt = " With so few photographs it may be another one that is misstated." if few else ""
    return (
        f"{name}: the stated exposure, {described(stated)}, disagrees with its pixels, which say {right} "
        f"({np.log2(factor):+.2f} EV); {used}.{doubt}"
    )


def _encoded(power: float) -> str:
    return (
        f"The pictures brighten only as the power {power:.2f} of their exposures: they seem to be gamma-encoded, but are taken "
        "as linear. Export them as linear TIFF or as 8-bit JPEG."
    )


def _times(exposure: Exposure, factor: float) -> Exposure:
    return Exposure(exposure.time_s * factor, exposure.iso, exposure.f_number)


def described(exposure: Exposure) -> str:
    """An exposure's time as photographers write it.

    Examples
    --------
    >>> described(Exposure(1 / 40)), described(Exposure(0.9)), described(Exposure(2.0))
    ('1/40 s', '0.9 s', '2 s')
    """
    if exposure.time_s < 0.4:
        return f"1/{1.0 / exposure.time_s:.4g} s"
    return f"{exposure.time_s:.3g} s"

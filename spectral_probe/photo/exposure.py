"""Exposure time, ISO and f-number of every photograph of a view."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import PhotographError
from ..model import Exposure, Photograph, ViewSettings

RADIANCE_EXPOSURE = Exposure(1.0, iso=100.0, f_number=1.0)
"""EXR and HDR hold radiance already: relative exposure 1 unless the capture file says otherwise."""

PLAUSIBLE = Exposure(1e-6, 1.0, 0.4), Exposure(1e5, 1e8, 512.0)
"""Times, ISO speeds and f-numbers outside of these are errors of the file that states them."""


def resolve_exposures(photographs: Sequence[Photograph], view: ViewSettings) -> list[Exposure]:
    """Exposure of each photograph: the capture file's values win, EXIF fills in what it leaves open.

    Parameters
    ----------
    photographs
        The photographs of `view`, in its order.
    view
        Its `exposures_s`, `iso` and `f_number`, where given. A single ISO or f-number stands for all
        photographs.

    Returns
    -------
    list of Exposure
        One per photograph. A missing ISO is 100, a missing f-number 1.

    Raises
    ------
    PhotographError
        No exposure time for a photograph, or one that cannot be; a list that does not fit the photographs, or a
        value that is not positive.
    """
    count = len(photographs)
    times = _given(view.exposures_s, "exposures_s", count, one_for_all=False)
    isos = _given(view.iso, "iso", count, one_for_all=True)
    f_numbers = _given(view.f_number, "f_number", count, one_for_all=True)
    exposures = []
    for index, photograph in enumerate(photographs):
        known = photograph.exposure if plausible(photograph.exposure) else None
        if known is None and photograph.scene_referred_float:
            known = RADIANCE_EXPOSURE
        time_s = times[index] if times else known.time_s if known else None
        if time_s is None:
            raise PhotographError(_no_time(photograph))
        iso = isos[index] if isos else known.iso if known else 100.0
        f_number = f_numbers[index] if f_numbers else known.f_number if known else 1.0
        exposure = Exposure(time_s, iso, f_number)
        if not plausible(exposure):
            raise PhotographError(
                f"{photograph.path.name}: {time_s:g} s at ISO {iso:g} and f/{f_number:g} cannot be. Correct the exposure "
                "in the capture file."
            )
        exposures.append(exposure)
    return exposures


def plausible(exposure: Exposure | None) -> bool:
    """Whether a camera can have exposed so.

    Examples
    --------
    >>> plausible(Exposure(0.01)), plausible(Exposure(1e9)), plausible(Exposure(0.01, iso=0.0)), plausible(None)
    (True, False, False, False)
    """
    if exposure is None:
        return False
    least, most = PLAUSIBLE
    return (
        least.time_s <= exposure.time_s <= most.time_s
        and least.iso <= exposure.iso <= most.iso
        and least.f_number <= exposure.f_number <= most.f_number
    )


def _no_time(photograph: Photograph) -> str:
    stated = photograph.exposure
    if stated is None:
        says = "says no exposure time"
    else:
        says = f"states {stated.time_s:g} s, ISO {stated.iso:g}, f/{stated.f_number:g}, which cannot be"
    return f"{photograph.path.name} {says}. Add exposures_s to its view in the capture file."


def _given(
    values: tuple[float, ...] | None, name: str, count: int, *, one_for_all: bool
) -> list[float] | None:
    """A list of the capture file, checked and spread over the photographs; None where it is not given."""
    if values is None:
        return None
    numbers = [float(value) for value in values]
    if not all(np.isfinite(number) and number > 0.0 for number in numbers):
        raise PhotographError(f"{name} holds a value that is not positive. Correct it in the capture file.")
    if one_for_all and len(numbers) == 1:
        return numbers * count
    if len(numbers) != count:
        raise PhotographError(
            f"{name} has {len(numbers)} values for {count} photographs. "
            "Give one for each photograph of the view."
        )
    return numbers

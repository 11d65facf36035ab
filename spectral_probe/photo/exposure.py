"""Exposure time, ISO and f-number of every photograph of a view."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import PhotographError
from ..model import Exposure, Photograph, ViewSettings

RADIANCE_EXPOSURE = Exposure(1.0, iso=100.0, f_number=1.0)
"""EXR and HDR hold radiance already: relative exposure 1 unless the capture file says otherwise."""


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
        No exposure time for a photograph, a list that does not fit the photographs, or a value that is not
        positive.
    """
    count = len(photographs)
    times = _given(view.exposures_s, "exposures_s", count, one_for_all=False)
    isos = _given(view.iso, "iso", count, one_for_all=True)
    f_numbers = _given(view.f_number, "f_number", count, one_for_all=True)
    exposures = []
    for index, photograph in enumerate(photographs):
        known = photograph.exposure
        if known is None and photograph.scene_referred_float:
            known = RADIANCE_EXPOSURE
        time_s = times[index] if times else known.time_s if known else None
        if time_s is None:
            raise PhotographError(
                f"{photograph.path.name} says no exposure time. "
                "Add exposures_s to its view in the capture file."
            )
        iso = isos[index] if isos else known.iso if known else 100.0
        f_number = f_numbers[index] if f_numbers else known.f_number if known else 1.0
        exposures.append(Exposure(time_s, iso, f_number))
    return exposures


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

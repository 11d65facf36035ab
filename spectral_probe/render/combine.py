"""Passes to tristimulus values and spectra: one sum for both kinds of plan (see `PassPlan`).

Passes are read one at a time, so a farm's worth of them needs the memory of one.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..errors import RenderError
from ..model import FloatArray
from ..render_model import PassPlan
from ..spectra.colorimetry import spectra_to_xyz


def combine_xyz(plan: PassPlan, pass_images: Iterable[FloatArray]) -> FloatArray:
    """Tristimulus values of a rendered image: radiance times colour-matching functions summed over nm.

    Parameters
    ----------
    plan
        The plan the passes were rendered by.
    pass_images
        The P rendered passes in the plan's order, each (H, W, 3).

    Returns
    -------
    ndarray
        (H, W, 3) float32 X, Y, Z; not normalised, and negative where noise or a light outside the layers makes it so.

    Raises
    ------
    RenderError
        If there are not as many passes as the plan has, or their sizes differ.

    Examples
    --------
    >>> from spectral_probe.render.plan import reference_plan
    >>> xyz = combine_xyz(reference_plan(), (np.ones((1, 1, 3)) for _ in range(21)))
    >>> xyz[0, 0].astype(float).round(1).tolist()  # equal energy: the sums of the colour-matching functions
    [106.6, 106.8, 106.5]
    """
    return _combine(pass_images, spectra_to_xyz(plan.reconstruction))


def combine_spectrum(plan: PassPlan, pass_images: Iterable[FloatArray]) -> FloatArray:
    """Spectral radiance per nm of a rendered image, (H, W, L) float32 on the plan's grid; see `combine_xyz`."""
    return _combine(pass_images, plan.reconstruction)


def _combine(pass_images: Iterable[FloatArray], coefficients: FloatArray) -> FloatArray:
    """Sum over passes of (H, W, 3) images times (P, 3, N) coefficients."""
    total: FloatArray | None = None
    count = 0
    for image in pass_images:
        if count == len(coefficients):
            raise RenderError(
                f"There are more passes than the {len(coefficients)} of the plan. Render them again."
            )
        if total is not None and image.shape[:2] != total.shape[:2]:
            raise RenderError("The passes differ in size. Render them again in one resolution.")
        part = np.asarray(image, np.float32) @ coefficients[count].astype(np.float32)
        total = part if total is None else np.add(total, part, out=total)
        count += 1
    if total is None or count != len(coefficients):
        raise RenderError(f"{count} of {len(coefficients)} passes are there. Render the missing ones first.")
    return total

"""A wavelength quadrature fitted to a scene: three wavelengths a pass, light and materials alike.

The pixels' spectra, transport times light, lie near a space of few dimensions. Wavelengths are chosen one after another, and the
spectrum at all others predicted from them (best linear prediction in the span of a training picture), so that the tristimulus
values are right. Each pass costs a full render, but the light needs no layers.
"""

from __future__ import annotations

import numpy as np

from ..model import FloatArray
from ..render_model import PassPlan
from ..spectra.colorimetry import colour_matching_functions, spectra_to_xyz
from ..spectra.grid import STEP_NM, WAVELENGTHS_NM
from .interpolation import NodeChoice, lab_metric, second_moment
from .light_samples import Picture, largest_error

_CHANNELS = 3


def fitted_quadrature(
    training: Picture, held_out: Picture, max_de2000: float, most_passes: int
) -> PassPlan | None:
    """The plan of fewest passes whose largest predicted error is within the bound; None where none is.

    Parameters
    ----------
    training, held_out
        Random pixels that the reconstruction is fitted to, and others by which its error is predicted.
    max_de2000
        The bound.
    most_passes
        Not more passes than this.
    """
    spectra = training.spectra
    flat = np.ones((1, len(WAVELENGTHS_NM))) / (colour_matching_functions()[:, 1].sum() * STEP_NM)
    choice = NodeChoice(second_moment(spectra), lab_metric(flat), keep_constants=False)
    exact = held_out.spectra
    for passes in range(1, most_passes + 1):
        nodes = choice.nodes(_CHANNELS * passes)
        weights = choice.weights(_CHANNELS * passes)
        errors = held_out.errors(spectra_to_xyz(exact[:, nodes] @ weights))
        if largest_error(errors) <= max_de2000:
            return _plan(nodes, weights, (float(errors.mean()), largest_error(errors)))
    return None


def _plan(nodes: list[int], weights: FloatArray, predicted: tuple[float, float]) -> PassPlan:
    passes = len(nodes) // _CHANNELS
    index = np.arange(passes)[:, None] + passes * np.arange(_CHANNELS)  # distant wavelengths share a pass
    return PassPlan(
        kind="wavelength",
        wavelengths_nm=WAVELENGTHS_NM[np.array(nodes)][index],
        reconstruction=weights[index],
        grid_nm=WAVELENGTHS_NM.copy(),
        sample_shares=np.ones(passes),
        references=tuple(range(passes)),
        light_sets=(0,) * passes,
        predicted_de2000=predicted,
        predicted_cost=float(passes),
    )

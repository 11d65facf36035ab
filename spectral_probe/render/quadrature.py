"""A wavelength quadrature fitted to a scene: three wavelengths a pass, light and materials alike.

The pixels' spectra, transport times light, lie near a space of few dimensions. Wavelengths are chosen one after another, and the
spectrum at all others predicted from them (best linear prediction in the span of a training picture), so that the tristimulus
values are right. The light needs no layers.

The passes share the samples of one render: each takes its part of one sequence, and their sum has about the luminance noise of
an RGB render of as many samples, since every path carries three wavelengths, as in hero wavelength sampling (Wilkie, Nawaz,
Droske, Weidlich & Hanika, Hero Wavelength Spectral Sampling, EGSR 2014, doi:10.1111/cgf.12419). What noise they add to colour
is made small by what each pass is given: wavelengths whose sum has the picture's own colours (`balanced`).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..model import FloatArray
from ..render_model import PassPlan
from ..spectra.colorimetry import colour_matching_functions, spectra_to_xyz, white_xyz
from ..spectra.grid import STEP_NM, WAVELENGTHS_NM
from .interpolation import NodeChoice, lab_metric, second_moment
from .light_samples import Picture, largest_error

_CHANNELS = 3


def fitted_quadrature(
    training: Picture, held_out: Picture, max_de2000: float, most_passes: int, *, full_samples: bool = False
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
    full_samples
        Every pass takes all samples, in place of its part of them.
    """
    spectra = training.spectra
    flat = np.ones((1, len(WAVELENGTHS_NM))) / (colour_matching_functions()[:, 1].sum() * STEP_NM)
    choice = NodeChoice(second_moment(spectra), lab_metric(flat), keep_constants=False)
    exact = held_out.spectra
    for passes in range(1, min(most_passes, len(WAVELENGTHS_NM) // _CHANNELS) + 1):
        nodes = choice.nodes(_CHANNELS * passes)
        weights = choice.weights(_CHANNELS * passes)
        errors = held_out.errors(spectra_to_xyz(exact[:, nodes] @ weights))
        if largest_error(errors) <= max_de2000:
            index = balanced(spectra[:, nodes], spectra_to_xyz(weights))
            return PassPlan(
                kind="wavelength",
                wavelengths_nm=WAVELENGTHS_NM[np.array(nodes)][index],
                reconstruction=weights[index],
                grid_nm=WAVELENGTHS_NM.copy(),
                sample_shares=np.full(passes, 1.0 if full_samples else 1.0 / passes),
                references=tuple(range(passes)),
                light_sets=(0,) * passes,
                predicted_de2000=(float(errors.mean()), largest_error(errors)),
                predicted_cost=float(passes if full_samples else 1.0),
                consecutive=not full_samples,
            )
    return None


def balanced(radiance: FloatArray, coefficients: FloatArray) -> npt.NDArray[np.intp]:
    """Which wavelengths share a pass, so that the noise of single passes changes colours least.

    Parameters
    ----------
    radiance
        (N, M) radiance of training pixels at M wavelengths, a multiple of three.
    coefficients
        (M, 3) tristimulus values that radiance at each wavelength contributes.

    Returns
    -------
    ndarray
        (M / 3, 3) indices. Passes have independent noise; the expected square of what it does to the pixels' tristimulus values
        is smallest where all passes contribute alike. Pairs are exchanged until no exchange makes it smaller.

    Examples
    --------
    Two wavelengths of each of three colours are dealt out so that every pass sees all colours:

    >>> colours = np.repeat(np.eye(3), 2, axis=0)
    >>> np.sort(balanced(np.ones((1, 6)), colours) // 2, axis=1).tolist()
    [[0, 1, 2], [0, 1, 2]]
    """
    count = len(coefficients)
    passes = count // _CHANNELS
    luminance = np.maximum(np.abs(radiance @ coefficients[:, 1]), 1e-9)
    share = (radiance / luminance[:, None]).T @ (radiance / luminance[:, None])
    relative = coefficients / white_xyz()
    gram = share * (relative @ relative.T)  # of the contributions of two wavelengths to the pixels
    owner = np.arange(count) % passes  # distant wavelengths share a pass
    improved = True
    while improved:
        improved = False
        for first in range(count):
            for second in range(first + 1, count):
                if owner[first] == owner[second]:
                    continue
                ours, theirs = owner == owner[first], owner == owner[second]
                gain = gram[first] - gram[second]
                # What changes when the two trade places: their products with the others of both passes, and among themselves.
                change = gain @ (theirs.astype(float) - ours) + gram[first, first] + gram[second, second]
                if change - 2 * gram[first, second] < -1e-12 * np.trace(gram):
                    owner[first], owner[second] = owner[second], owner[first]
                    improved = True
    return np.stack([np.flatnonzero(owner == number) for number in range(passes)])

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

_MORE_PASSES = 6
"""So many more passes than the error bound needs are tried for less noise of colours."""

_NEARLY = 1.1
"""Fewer passes are taken where they have at most this many times the least noise of colours: each costs some time of its own."""


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
    most = min(most_passes, len(WAVELENGTHS_NM) // _CHANNELS)
    found: list[tuple[float, PassPlan]] = []
    for passes in range(1, most + 1):
        nodes = choice.nodes(_CHANNELS * passes)
        weights = choice.weights(_CHANNELS * passes)
        errors = held_out.errors(spectra_to_xyz(exact[:, nodes] @ weights))
        if largest_error(errors) > max_de2000:
            continue
        contributions = _contributions(spectra[:, nodes], spectra_to_xyz(weights))
        index = balanced(contributions)
        plan = PassPlan(
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
        if full_samples or passes == 1:  # nothing is gained by more
            return plan
        found.append((colour_noise(contributions, index), plan))
        if len(found) > _MORE_PASSES:
            break
    if not found:
        return None
    least = min(noise for noise, _ in found)
    return next(plan for noise, plan in found if noise <= _NEARLY * least)


def _contributions(radiance: FloatArray, coefficients: FloatArray) -> FloatArray:
    """What each of M wavelengths adds to N pixels, (N, M, 3): to luminance, and to X and Z beyond the pixel's own colour.

    `radiance` (N, M) of the pixels, `coefficients` (M, 3) tristimulus values by radiance at each wavelength. All relative to the
    pixel's luminance: the square of the first is what a pass's noise does to luminance, that of the others to colour.
    """
    parts = radiance[..., None] * (coefficients / white_xyz())
    total = parts.sum(1, keepdims=True)
    luminance = np.maximum(total[..., 1:2], 1e-9)
    colour = parts - parts[..., 1:2] * total / luminance
    return np.asarray(np.concatenate([parts[..., 1:2], colour[..., [0, 2]]], -1) / luminance)


def colour_noise(contributions: FloatArray, passes: npt.NDArray[np.intp]) -> float:
    """Noise of colours over that of luminance that passes of independent noise add; 0 where all have the picture's colours.

    Examples
    --------
    >>> parts = np.array([[[0.5, 0.1, 0.0], [0.5, -0.1, 0.0]]])
    >>> colour_noise(parts, np.array([[0, 1]])), round(colour_noise(parts, np.array([[0], [1]])), 2)
    (0.0, 0.2)
    """
    sums = contributions[:, passes].sum(2)
    luminance, colour = (sums[..., :1] ** 2).sum((1, 2)), (sums[..., 1:] ** 2).sum((1, 2))
    return float(np.sqrt(colour.mean() / luminance.mean()))


def balanced(contributions: FloatArray) -> npt.NDArray[np.intp]:
    """Which wavelengths share a pass, so that the noise of single passes changes colours least.

    Parameters
    ----------
    contributions
        (N, M, D) what each of M wavelengths, a multiple of three, adds to training pixels.

    Returns
    -------
    ndarray
        (M / 3, 3) indices. Passes have independent noise; the expected square of what it does to the pixels is smallest where
        all passes contribute alike. Pairs are exchanged until no exchange makes it smaller.

    Examples
    --------
    Two wavelengths of each of three colours are dealt out so that every pass sees all colours:

    >>> np.sort(balanced(np.repeat(np.eye(3), 2, axis=0)[None]) // 2, axis=1).tolist()
    [[0, 1, 2], [0, 1, 2]]
    """
    count = contributions.shape[1]
    gram = np.einsum("nid,njd->ij", contributions, contributions, optimize=True)
    owner = np.arange(count) % (count // _CHANNELS)  # distant wavelengths share a pass
    while (pair := _best_exchange(gram, owner)) is not None:
        owner[list(pair)] = owner[list(pair[::-1])]
    return np.stack([np.flatnonzero(owner == number) for number in range(count // _CHANNELS)])


def _best_exchange(gram: FloatArray, owner: npt.NDArray[np.intp]) -> tuple[int, int] | None:
    """The two wavelengths of different passes that had best trade places; None where no exchange makes the noise smaller."""
    own = (owner[:, None] == owner).astype(float)
    with_own, with_other = (
        (gram * own).sum(1),
        gram @ own,
    )  # (M,) and (M, M): a wavelength with its pass, with another's
    square = np.diagonal(gram)
    change = with_other + with_other.T - with_own[:, None] - with_own + square[:, None] + square - 2 * gram
    change[own > 0] = 0.0
    first, second = np.unravel_index(int(np.argmin(change)), change.shape)
    return (int(first), int(second)) if change[first, second] < -1e-12 * square.sum() else None

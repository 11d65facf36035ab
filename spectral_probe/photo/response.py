"""A camera's response from a bracket: how the codes of its converted pictures follow the light."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from .read import srgb_to_linear
from .samples import Cells

KNOTS = (np.arange(25) / 24.0) ** 1.5
"""Codes at which the curve is free: denser in the dark, where a tone curve's toe bends most. It is linear between."""

MID_GREY_CODE = 0.5
"""The code whose sRGB-decoded value every channel keeps: what is neutral there stays neutral."""

CODE_ERROR = 1.5 / 255.0
"""Standard error of a cell's mean code: coding, quantisation, and what alignment leaves."""

CODE_RELATIVE_ERROR = 0.01
"""The same as a share of the code: reflections that changed, vignetting, local processing."""

BEND = 0.04
"""How much the curve may bend away from sRGB's at a knot (natural logarithm, standard deviation)."""

TILT = 0.3
"""How much it may climb or fall against sRGB from knot to knot where the bracket says nothing."""

APART = 0.05
"""How much the channels' curves may differ in the change from knot to knot: one camera applies one tone curve, and
what differs is its colour processing."""

LEAST_SLOPE = 0.15
"""The curve rises everywhere by at least this share of sRGB's slope."""

HUBER = 2.0
_ROUNDS = 12
_MONOTONE = 1e3
_GAUGE = 1e3


@dataclass(frozen=True)
class ResponseCurve:
    """How much light a code stands for, per channel, as measured from a bracket.

    `log_gain` (3, K) at the codes `KNOTS`: natural logarithm of the light over the sRGB-decoded code. `residual_ev` (3,) is
    the RMS disagreement of the photographs about the light, per channel, in EV, `photograph_residual_ev` (E,) the same per
    photograph (NaN where one could not be compared). Beyond `codes_seen` (lowest, highest) the curve is extrapolated.
    """

    log_gain: FloatArray
    residual_ev: tuple[float, float, float]
    photograph_residual_ev: tuple[float, ...]
    codes_seen: tuple[float, float] = (0.0, 1.0)

    def linear(self, decoded: FloatArray) -> FloatArray:
        """Light of sRGB-decoded pixels (..., 3), relative: 1 stays about 1 only where the camera follows sRGB.

        Examples
        --------
        >>> curve = ResponseCurve(np.zeros((3, len(KNOTS))), (0.0, 0.0, 0.0), ())
        >>> curve.linear(np.array([[0.0, 0.5, 1.0]])).tolist()
        [[0.0, 0.5, 1.0]]
        """
        from .samples import linear_to_srgb

        codes = linear_to_srgb(decoded)
        gain = [np.interp(codes[..., c], KNOTS, self.log_gain[c]) for c in range(3)]
        return np.asarray(decoded * np.exp(np.stack(gain, axis=-1)))

    def log_slope(self, codes: FloatArray) -> FloatArray:
        """Change of the light's natural logarithm per code (0..1), of shape (3, N) at codes (N,)."""
        gain = np.stack([_slopes(codes) @ one for one in self.log_gain])
        return np.asarray(gain + srgb_log_slope(codes))


@dataclass(frozen=True)
class ResponseFit:
    """A response and the exposures that go with it, from the pixels.

    `log_gain` as in `ResponseCurve`; `log_exposures` (E,) natural logarithm, `log_exposure_errors` (E,) their standard errors
    (0 where they were known); `residuals` (E, N, 3) of the logarithm of
    the light, NaN where a cell is not usable; `weights` (E, N, 3) that they had.
    """

    log_gain: FloatArray
    log_exposures: FloatArray
    log_exposure_errors: FloatArray
    residuals: FloatArray
    weights: FloatArray
    codes_seen: tuple[float, float]

    def curve(self) -> ResponseCurve:
        """The response with its residuals in EV."""
        heard = self.weights > 0.0
        squares = np.where(heard, self.residuals, 0.0) ** 2 * self.weights
        channel = np.sqrt(squares.sum((0, 1)) / np.maximum(self.weights.sum((0, 1)), 1e-12)) / np.log(2.0)
        weight = self.weights.sum((1, 2))
        photograph = np.where(
            weight > 0.0, np.sqrt(squares.sum((1, 2)) / np.maximum(weight, 1e-12)) / np.log(2.0), np.nan
        )
        red, green, blue = (float(value) for value in channel)
        per_photograph = tuple(float(value) for value in photograph)
        return ResponseCurve(self.log_gain, (red, green, blue), per_photograph, self.codes_seen)


def fit_response(cells: Cells, log_exposures: FloatArray, *, free: bool) -> ResponseFit:
    """Fit the response to a bracket, with its exposures known or free.

    In every cell and channel the logarithm of the light, g(code) = ln sRGB(code) + d(code), must be the logarithm of the
    exposure plus that of the radiance [1]_. d is piecewise linear, smooth, alike in the three channels, and rises slowly enough
    for g to be monotone. Outliers (what moved) lose weight after Huber.

    Parameters
    ----------
    cells
        Flat cells with codes.
    log_exposures
        (E,) natural logarithm of the exposures; where they are free, only their spread counts: see Notes.
    free
        Whether the exposures are solved for together with the response.

    Returns
    -------
    ResponseFit

    Notes
    -----
    OpenCV's calibrations take the exposures as known and the samples as they fall: clipped, moved or at edges. On simulated
    brackets of three exposures and an S-shaped curve, `createCalibrateDebevec` errs by 4.1 % (steps of 2 EV) and 1.5 %
    (1 EV) in mid-tones where this fit errs by 1.2 % and 0.4 %; on a phone's bracket its curve falls in places; and
    `createCalibrateRobertson` ripples (19 % at 2 EV). The equations are small enough to write them out with a prior that
    fits, and with the exposures among the unknowns.

    Pixels alone leave the exposures' common factor and, since g may be stretched by any exponent, their common scale
    undetermined [2]_. Where they are free, their mean and their spread along the given ones are kept; `exposure_check`
    then brings them to the stated ones. With equal steps, even known exposures leave ripples of that period in g
    undetermined; smoothness keeps them out.

    References
    ----------
    .. [1] Debevec, P. E., & Malik, J. (1997). Recovering High Dynamic Range Radiance Maps from Photographs.
       SIGGRAPH 97. doi:10.1145/258734.258884
    .. [2] Grossberg, M. D., & Nayar, S. K. (2003). Determining the camera response from images: What is knowable? IEEE
       TPAMI, 25(11). doi:10.1109/TPAMI.2003.1240119
    """
    photos, count, _ = cells.values.shape
    knots = len(KNOTS)
    heard = np.nonzero(cells.usable & (cells.usable.sum(0) >= 2))
    photo, cell, channel = heard
    codes = cells.values[heard]
    group = cell * 3 + channel
    rows = len(codes)
    design = _equations(codes, photo, channel, photos)
    target = log_exposures[photo] - np.log(srgb_to_linear(codes))
    prior = _prior(log_exposures, free=free)
    solution: FloatArray = np.zeros(design.shape[1])
    residual = target - target.mean() if rows else target
    weights = np.ones(rows)
    normal: FloatArray = np.eye(design.shape[1])
    steep: BoolArray = np.zeros((3, knots - 1), bool)
    for _ in range(_ROUNDS):
        gain = solution[: 3 * knots].reshape(3, knots)
        slope = srgb_log_slope(codes) + (_slopes(codes) * gain[channel]).sum(-1)
        error = np.hypot(CODE_ERROR, CODE_RELATIVE_ERROR * codes) * np.maximum(slope, 1.0)
        weights = _huber(residual / error) / error**2
        total = np.maximum(np.bincount(group, weights, 3 * count), 1e-12)
        demeaned = design - _group_mean(design, weights, group, total)
        aim = target - (np.bincount(group, weights * target, 3 * count) / total)[group]
        normal, solution = _solve(demeaned, aim, weights, prior, steep)
        residual = demeaned @ solution - aim
        steep |= _falling(solution[: 3 * knots].reshape(3, knots))
    residuals = np.full(cells.values.shape, np.nan)
    residuals[heard] = residual
    used = np.zeros(cells.values.shape)
    used[heard] = weights / max(float(weights.mean()), 1e-12) if rows else 0.0
    gain = solution[: 3 * knots].reshape(3, knots)
    at_grey = _hats(np.array([MID_GREY_CODE]))[0]
    return ResponseFit(
        gain - (gain @ at_grey)[:, None],
        log_exposures + solution[3 * knots :],
        _errors(normal, residual, weights, rows - len(np.unique(group)))[3 * knots :],
        residuals,
        used,
        (float(codes.min()), float(codes.max())) if rows else (0.0, 1.0),
    )


def _equations(codes: FloatArray, photo: IntArray, channel: IntArray, photos: int) -> FloatArray:
    """One row for each code: its shares of the knots of its channel's curve, and -1 for its photograph's exposure."""
    index = np.arange(len(codes))
    design = np.zeros((len(codes), 3 * len(KNOTS) + photos))
    design[index[:, None], channel[:, None] * len(KNOTS) + np.arange(len(KNOTS))] = _hats(codes)
    design[index, 3 * len(KNOTS) + photo] = -1.0
    return design


def _errors(normal: FloatArray, residual: FloatArray, weights: FloatArray, freedom: int) -> FloatArray:
    """Standard errors of the solution; the three channels of a cell err alike and count as one."""
    spread = float(np.sqrt((weights * residual**2).sum() / max(freedom, 1)))
    return np.asarray(np.sqrt(3.0 * np.maximum(np.diag(np.linalg.inv(normal)), 0.0)) * max(spread, 1e-3))


def _solve(
    design: FloatArray,
    target: FloatArray,
    weights: FloatArray,
    prior: tuple[FloatArray, FloatArray],
    steep: BoolArray,
) -> tuple[FloatArray, FloatArray]:
    """The normal matrix and the solution of weighted least squares with prior rows; slopes that fell too low are held."""
    rows, aims = prior
    channels, places = np.nonzero(steep)
    held = np.zeros((len(channels), design.shape[1]))
    index = np.arange(len(channels))
    held[index, channels * len(KNOTS) + places + 1] = _MONOTONE
    held[index, channels * len(KNOTS) + places] = -_MONOTONE
    limit = -_MONOTONE * (1.0 - LEAST_SLOPE) * _srgb_steps()[places]
    normal = design.T @ (weights[:, None] * design) + rows.T @ rows + held.T @ held
    right = design.T @ (weights * target) + rows.T @ aims + held.T @ limit
    return normal, np.linalg.solve(normal, right)


def _prior(log_exposures: FloatArray, *, free: bool) -> tuple[FloatArray, FloatArray]:
    knots, photos = len(KNOTS), len(log_exposures)
    width = 3 * knots + photos
    change = np.diff(np.eye(knots), axis=0)
    bend = np.diff(change, axis=0)
    blocks = []
    for c in range(3):
        for operator, error in ((bend, BEND), (change, TILT)):
            block = np.zeros((len(operator), width))
            block[:, c * knots : (c + 1) * knots] = operator / error
            blocks.append(block)
        block = np.zeros((len(change), width))
        block[:, c * knots : (c + 1) * knots] = change / APART
        other = (c + 1) % 3
        block[:, other * knots : (other + 1) * knots] = -change / APART
        blocks.append(block)
        grey = np.zeros(
            (1, width)
        )  # a constant in g is one in the radiance: held here, and exactly at the end
        grey[0, c * knots : (c + 1) * knots] = _GAUGE * _hats(np.array([MID_GREY_CODE]))[0]
        blocks.append(grey)
    offsets = np.zeros((photos, width))
    if free:
        centred = log_exposures - log_exposures.mean()
        along = centred / max(float(np.linalg.norm(centred)), 1e-9)
        offsets = np.zeros((2, width))
        offsets[:, 3 * knots :] = _GAUGE * np.stack([np.ones(photos), along])
        weak = np.zeros((photos, width))
        weak[:, 3 * knots :] = np.eye(
            photos
        )  # a standard deviation of 1.4 EV: for photographs without common pixels
        blocks.append(weak)
    else:
        offsets[:, 3 * knots :] = _GAUGE * np.eye(photos)
    blocks.append(offsets)
    rows = np.concatenate(blocks)
    return rows, np.zeros(len(rows))


def _group_mean(design: FloatArray, weights: FloatArray, group: IntArray, total: FloatArray) -> FloatArray:
    """Weighted mean of the rows of each group, repeated for its rows: takes the unknown radiance out of the equations."""
    order = np.argsort(group, kind="stable")
    starts = np.flatnonzero(np.diff(group[order], prepend=-1))
    sums = np.add.reduceat(weights[order, None] * design[order], starts, axis=0)
    present = group[order][starts]
    place = np.zeros(len(total), int)
    place[present] = np.arange(len(present))
    return np.asarray(sums[place[group]] / total[group, None])


def _huber(ratio: FloatArray) -> FloatArray:
    return np.asarray(np.minimum(1.0, HUBER / np.maximum(np.abs(ratio), 1e-12)))


def _falling(gain: FloatArray) -> BoolArray:
    """Intervals (3, K - 1) in which the response would rise by less than the least slope."""
    return np.asarray(np.diff(gain, axis=1) < -(1.0 - LEAST_SLOPE) * _srgb_steps() - 1e-9)


def _srgb_steps() -> FloatArray:
    """Rise of ln sRGB from knot to knot; over the first, which begins at black, that of its upper half."""
    logs = np.log(srgb_to_linear(np.maximum(KNOTS, 0.5 * KNOTS[1])))
    return np.diff(logs)


def srgb_log_slope(codes: FloatArray) -> FloatArray:
    """Slope of the sRGB-decoded value's natural logarithm at codes (0..1) of any shape, bounded at black."""
    return np.asarray(
        np.where(codes <= 0.04045, 1.0 / np.maximum(codes, 1e-3), 2.4 / (np.maximum(codes, 0.0) + 0.055))
    )


def _hats(codes: FloatArray) -> FloatArray:
    """Shares (N, K) of the knots in the curve's value at codes (N,)."""
    place = np.clip(np.searchsorted(KNOTS, codes, side="right") - 1, 0, len(KNOTS) - 2)
    part = np.clip((codes - KNOTS[place]) / (KNOTS[place + 1] - KNOTS[place]), 0.0, 1.0)
    hats = np.zeros((len(codes), len(KNOTS)))
    index = np.arange(len(codes))
    hats[index, place] = 1.0 - part
    hats[index, place + 1] = part
    return hats


def _slopes(codes: FloatArray) -> FloatArray:
    """Shares (N, K) of the knots in the curve's slope at codes (N,)."""
    place = np.clip(np.searchsorted(KNOTS, codes, side="right") - 1, 0, len(KNOTS) - 2)
    width = KNOTS[place + 1] - KNOTS[place]
    slopes = np.zeros((len(codes), len(KNOTS)))
    index = np.arange(len(codes))
    slopes[index, place] = -1.0 / width
    slopes[index, place + 1] = 1.0 / width
    return slopes

"""Noise taken out of the colour of light, where the neighbourhood shows the same light.

The eye forgives noise of luminance, and a metal's reflection averages it; but a spectrum built on a noisy ratio of channels is
another spectrum. Directions a few degrees apart that look alike to the camera show the same lamp or the same lit surface, so
the ratios are averaged over them (a cross bilateral filter: Petschnigg et al., "Digital photography with flash and no-flash
image pairs", ACM TOG 23, 664, 2004, doi:10.1145/1015706.1015777), but never moved farther than the photographs' noise explains.
"""

from __future__ import annotations

import cv2
import numpy as np

from ..geometry.sphere import padded, resized
from ..large import strips, with_margin
from ..model import FloatArray

_RADIUS_RAD = 0.06
"""Radius of the neighbourhood, 3.4 degrees."""

_ALIKE = 0.1
"""Standard deviation, in logarithms of the responses, of what counts as the same light."""

_BLUR_PX = 1.0
"""Of the picture by which likeness is judged, against its own noise."""

_DEVIATIONS = 2.5
"""How many standard deviations of its noise a ratio may be moved."""

_LARGEST_WIDTH = 1024
"""Width of the panorama on which the neighbourhoods are averaged; a finer one takes over what is alike."""

_MARGIN = 8
"""Rows beyond others that their shares and their guide depend on: two, and the four of the blur."""

_DARK = np.float32(0.02)
"""Least response that counts, relative to the sum of the channels round it."""


def without_chromaticity_noise(
    responses: FloatArray, variance: FloatArray, *, in_place: bool = False
) -> FloatArray:
    """Responses whose ratios between the channels are filtered; their sum stays as it is.

    Parameters
    ----------
    responses
        (H, W, 3) of a panorama.
    variance
        (H, W, 3) of the responses.
    in_place
        Change `responses` themselves, which are float32.

    Returns
    -------
    ndarray
        (H, W, 3) float32.

    Examples
    --------
    >>> even = np.ones((64, 128, 3), np.float32)
    >>> bool(np.allclose(without_chromaticity_noise(even, 0.01 * even), even))
    True
    """
    responses = np.asarray(responses, np.float32)
    height, full = responses.shape[:2]
    width = min(full, _LARGEST_WIDTH)
    mean, guide = _averaged(resized(responses, width))
    result = responses if in_place else np.empty_like(responses)
    above = responses[:0]  # rows before those at hand, as they were
    for rows in strips(height, full) if width < full else [slice(0, height)]:
        around, inside = with_margin(rows, _MARGIN, height)
        seen = np.concatenate([above[len(above) - inside.start :], responses[rows.start : around.stop]])
        above = responses[max(rows.stop - _MARGIN, 0) : rows.stop].copy()
        own = mean[rows], guide[rows]
        if width < full:
            own = resized(mean, full, rows), resized(guide, full, rows)
        result[rows] = _filtered(seen, inside, variance[rows], *own, taken_over=width < full)
    return result


def _filtered(
    around: FloatArray,
    inside: slice,
    variance: FloatArray,
    mean: FloatArray,
    guide: FloatArray,
    *,
    taken_over: bool,
) -> FloatArray:
    """Responses (h, W, 3) of some rows, which lie `inside` more, with the mean shares and the guide of those rows.

    Where both are `taken_over` from a smaller panorama, they count as far as the texel looks like them.
    """
    shares, total = (values[inside] for values in _shares(around))
    responses = around[inside]
    noise = np.sqrt(variance + shares**2 * variance.sum(-1, keepdims=True)) / total
    if taken_over:
        apart = ((_guide(around)[inside] - guide) ** 2).sum(-1, keepdims=True)
        mean = shares + np.exp(-apart / (2 * _ALIKE**2)) * (mean - shares)
    most = _DEVIATIONS * noise
    change = np.clip(mean - shares, -most, most)
    change -= shares * change.sum(-1, keepdims=True)
    return np.asarray(responses + total * change, np.float32)


def _shares(responses: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Each channel over the sum of all, and that sum (H, W, 1), not below a share of its surroundings."""
    total = responses.sum(-1)
    around = cv2.blur(padded(np.abs(responses).sum(-1), 2, 2), (5, 5))[2:-2, 2:-2]
    floor = np.maximum(_DARK * around, np.float32(1e-18))  # its square is still a number
    total = np.maximum(total, floor)[..., None]
    return responses / total, total


def _guide(responses: FloatArray) -> FloatArray:
    """Logarithms of the responses, blurred a little."""
    _, total = _shares(responses)
    blurred = cv2.GaussianBlur(np.log(np.maximum(responses, _DARK * total)), (0, 0), _BLUR_PX)
    return np.asarray(blurred, np.float32)


def _averaged(responses: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean shares of what looks alike round each direction, and the guide by which that was judged."""
    radius = max(1, round(_RADIUS_RAD * len(responses) / np.pi))
    edge = 2 * radius + 1
    guide, (shares, _) = _guide(responses), _shares(responses)
    mean = cv2.ximgproc.jointBilateralFilter(
        padded(guide, edge, edge), padded(shares, edge, edge), edge, _ALIKE, radius / 1.5
    )
    return np.asarray(mean[edge:-edge, edge:-edge]), guide

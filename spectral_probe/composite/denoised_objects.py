"""Virtual objects without their noise, as a denoised render has them, in a camera's own colours.

A denoised render leaves tristimulus values without noise, in image.exr; xyz.exr and the passes keep theirs. A camera's
colours follow from tristimulus values by a matrix up to a remainder, which is small and, since the noise of both is of the same
light paths, nearly without noise.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from ..composite_model import ObjectCoverage
from ..files.image_exr import read_channels
from ..model import FloatArray
from ..render.outputs import DENOISED_NOTE
from .picture import picture_xyz

REMAINDER_PX = 9
"""Side of the square mean, applied twice, that takes the noise out of the remainder."""

_FIRM = 1e-4
"""Weight of the general matrix against an object's own pixels, which may all be of one colour and so leave a matrix open."""


def denoised_xyz(render_dir: Path) -> FloatArray | None:
    """Tristimulus values (H, W, 3) of a render without noise; None where it was not denoised."""
    path = Path(render_dir) / "image.exr"
    if not path.is_file():
        return None
    channels, header = read_channels(path)
    if DENOISED_NOTE not in str(header.get("comments", "")):
        return None
    return picture_xyz(channels, header, path)


def denoised_in_camera(
    denoised: FloatArray, xyz: FloatArray, rgb: FloatArray, coverage: ObjectCoverage, to_camera: FloatArray
) -> FloatArray:
    """Denoised tristimulus values of objects as a camera's RGB.

    Each object gets the matrix that fits its own pixels best, and on top of it what of the camera's colours no matrix gives,
    as a mean over its neighbourhood on the object.

    Parameters
    ----------
    denoised, xyz
        (H, W, 3) tristimulus values, premultiplied, without noise and as rendered.
    rgb
        (H, W, 3) the render in the camera's RGB, with its noise.
    coverage
        What each pixel shows.
    to_camera
        (3, 3) ``rgb = xyz @ to_camera.T`` for things in general.

    Returns
    -------
    ndarray
        (H, W, 3) float32, of meaning where objects are.

    Examples
    --------
    A grey object under noise, and a camera whose colours are no sums of tristimulus values by the matrix given:

    >>> noise = np.random.default_rng(1).uniform(0.5, 1.5, (24, 24, 1)).astype(np.float32)
    >>> one, cover = np.ones((24, 24, 3), np.float32), np.ones((24, 24), np.float32)
    >>> grey = ObjectCoverage({"grey": cover}, cover, 0 * cover)
    >>> seen = denoised_in_camera(one, one * noise, one * noise * (0.5, 1.1, 0.8), grey, np.eye(3))
    >>> bool(np.abs(seen - (0.5, 1.1, 0.8)).max() < 1e-3)
    True
    """
    matrix = np.asarray(to_camera.T, np.float32)
    seen = np.asarray(denoised @ matrix, np.float32)
    remainder = np.asarray(rgb - xyz @ matrix, np.float32)
    planes = [np.asarray(plane, np.float32) for plane in coverage.objects.values()] or [coverage.coverage]
    total = np.maximum(np.sum(planes, axis=0), np.float32(1e-6))
    for plane in planes:
        left, top, width, height = cv2.boundingRect((plane > 0).astype(np.uint8))
        if not width:
            continue
        part = np.s_[top : top + height, left : left + width]
        own = _own_matrix(xyz[part], remainder[part], plane[part])
        rest = _mean_on(remainder[part] - xyz[part] @ own, plane[part])
        share = (plane / total)[part][..., None]
        seen[part] += share * (denoised[part] @ own) + plane[part][..., None] * rest
    return seen


def _own_matrix(xyz: FloatArray, remainder: FloatArray, plane: FloatArray) -> FloatArray:
    """(3, 3) what an object's own pixels add to the matrix, ``remainder = xyz @ matrix``; dark pixels count as bright ones do."""
    bright = xyz[..., 1]
    weight = plane / np.maximum(bright, 0.1 * max(float(np.average(bright, weights=plane)), 1e-12))
    known = (xyz * weight[..., None]).reshape(-1, 3).astype(float)
    wanted = (remainder * weight[..., None]).reshape(-1, 3).astype(float)
    squares = known.T @ known
    firm = _FIRM * np.trace(squares) / 3 * np.eye(3)
    return np.asarray(np.linalg.solve(squares + firm + 1e-30 * np.eye(3), known.T @ wanted), np.float32)


def _mean_on(remainder: FloatArray, plane: FloatArray) -> FloatArray:
    """The remainder (H, W, 3) of a pixel that the object covers wholly, as a mean over its surroundings on the object."""

    def box(values: FloatArray) -> FloatArray:
        side = (REMAINDER_PX, REMAINDER_PX)
        border = cv2.BORDER_CONSTANT
        return np.asarray(cv2.blur(cv2.blur(values, side, borderType=border), side, borderType=border))

    cover = plane[..., None]
    return np.asarray(
        box(np.ascontiguousarray(remainder * cover)) / np.maximum(box(plane * plane), 1e-6)[..., None]
    )

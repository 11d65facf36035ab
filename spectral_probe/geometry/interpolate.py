"""Reading images and tables between their samples, at any number of places."""

from __future__ import annotations

import cv2
import numpy as np

from ..model import FloatArray

_LONGEST_SIDE, _COLUMNS = 32766, 4096
"""OpenCV's remap takes no longer side; places of other shapes are laid out in rows of this many."""


def bilinear(image: FloatArray, column: FloatArray, row: FloatArray) -> FloatArray:
    """Values of an image between its pixels, the edge repeated outside.

    Parameters
    ----------
    image
        (H, W) or (H, W, C) float32, C up to 4.
    column, row
        (...) float32 places, counted from the centre of the first pixel.

    Returns
    -------
    ndarray
        (...) or (..., C) float32.

    Examples
    --------
    >>> image = np.array([[0.0, 1.0], [2.0, 3.0]], np.float32)
    >>> bilinear(image, np.array([0.5, 7.0]), np.array([0.5, 0.0])).tolist()
    [1.5, 1.0]
    """
    shape, size = (*column.shape, *image.shape[2:]), column.size
    if size == 0:
        return np.zeros(shape, np.float32)
    if column.ndim != 2 or max(column.shape) > _LONGEST_SIDE:
        columns = min(size, _COLUMNS)
        padded = np.zeros((2, -(-size // columns), columns), np.float32)
        for plane, values in zip(padded.reshape(2, -1), (column, row), strict=True):
            plane[:size] = values.reshape(-1)
        column, row = padded
    column, row = np.asarray(column, np.float32), np.asarray(row, np.float32)
    read = cv2.remap(image, column, row, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(read.reshape(-1, *image.shape[2:])[:size].reshape(shape))

"""ICC profiles of 16-bit pictures: whether their values are linear, and if not, how to make them so.

Only what such pictures carry: a curve for each channel and a matrix to XYZ (ICC.1:2010, sections 8.3 and 10.5, 10.15, 10.27).
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from ..model import FloatArray

# Linear Rec.709 from XYZ relative to D50, the space that profiles connect to (Bradford adaptation to D65).
_REC709_FROM_D50 = np.array(
    [
        [3.1338561, -1.6168667, -0.4906146],
        [-0.9787684, 1.9161415, 0.0334540],
        [0.0719453, -0.2289914, 1.4052427],
    ]
)
_LINEAR_WITHIN = 0.002
_ROWS = 256  # turned at once: the whole picture would need indices of eight bytes a value


@dataclass(frozen=True)
class ColourProfile:
    """`curves` (3, 65536) from codes to linear values in 0..1, and `matrix` (3, 3) from these to linear Rec.709."""

    curves: FloatArray
    matrix: FloatArray

    @property
    def linear(self) -> bool:
        """Whether the values are linear as they are."""
        return bool(np.abs(self.curves - np.linspace(0.0, 1.0, 65536)).max() < _LINEAR_WITHIN)

    def to_rec709(self, codes: npt.NDArray[np.uint16]) -> FloatArray:
        """Linear Rec.709 (H, W, 3) of 16-bit codes."""
        pixels = np.empty(codes.shape, np.float32)
        curves, matrix = self.curves.astype(np.float32), self.matrix.astype(np.float32)
        for top in range(0, len(codes), _ROWS):
            block = pixels[top : top + _ROWS]
            for channel in range(3):
                block[..., channel] = curves[channel][codes[top : top + _ROWS, :, channel]]
            block[...] = cv2.transform(block, matrix)
        return pixels


def gamma_profile(gamma: float | None) -> ColourProfile:
    """The profile of a PNG that only names a power (its gAMA chunk, 0.45455 for 2.2), or sRGB (None): Rec.709's primaries.

    Examples
    --------
    >>> gamma_profile(1.0).linear, gamma_profile(None).linear
    (True, False)
    """
    codes = np.linspace(0.0, 1.0, 65536)
    if gamma is None:
        curve = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
    else:
        curve = codes ** (1.0 / gamma)
    return ColourProfile(np.stack([curve] * 3), np.eye(3))


def read_profile(data: bytes) -> ColourProfile | None:
    """The profile in some bytes; None where it is broken or built of tables rather than curves and a matrix."""
    try:
        if data[16:20] != b"RGB ":
            return None
        (count,) = struct.unpack_from(">I", data, 128)
        tags = {}
        for index in range(min(count, 100)):
            name, start, size = struct.unpack_from(">4sII", data, 132 + 12 * index)
            tags[name] = data[start : start + size]
        columns = [
            np.array(struct.unpack_from(">3i", tags[name], 8)) / 65536.0
            for name in (b"rXYZ", b"gXYZ", b"bXYZ")
        ]
        curves = np.stack([_curve(tags[name]) for name in (b"rTRC", b"gTRC", b"bTRC")])
    except (KeyError, struct.error, ValueError, IndexError):
        return None
    if not np.isfinite(curves).all():
        return None
    return ColourProfile(curves, _REC709_FROM_D50 @ np.stack(columns, axis=-1))


def _curve(tag: bytes) -> FloatArray:
    codes = np.linspace(0.0, 1.0, 65536)
    if tag[:4] == b"para":
        (kind,) = struct.unpack_from(">H", tag, 8)
        parameters = np.array(struct.unpack_from(f">{_PARAMETERS[kind][0]}i", tag, 12)) / 65536.0
        with np.errstate(all="ignore"):  # what is not finite is refused by whoever reads the profile
            return np.asarray(_PARAMETERS[kind][1](codes, *parameters))
    if tag[:4] != b"curv":
        raise ValueError
    (count,) = struct.unpack_from(">I", tag, 8)
    if count == 0:
        return codes
    values = np.frombuffer(tag, ">u2", count, 12)
    if count == 1:
        return np.asarray(codes ** (float(values[0]) / 256.0))
    return np.asarray(np.interp(codes, np.linspace(0.0, 1.0, count), values / 65535.0))


def _power(x: FloatArray, g: float, a: float, b: float, c: float = 0.0) -> FloatArray:
    return np.asarray(np.maximum(a * x + b, 0.0) ** g + c)


_PARAMETERS: dict[int, tuple[int, Callable[..., FloatArray]]] = {
    0: (1, lambda x, g: x**g),
    1: (3, lambda x, g, a, b: np.where(x >= -b / a, _power(x, g, a, b), 0.0)),
    2: (4, lambda x, g, a, b, c: np.where(x >= -b / a, _power(x, g, a, b, c), c)),
    3: (5, lambda x, g, a, b, c, d: np.where(x >= d, _power(x, g, a, b), c * x)),
    4: (7, lambda x, g, a, b, c, d, e, f: np.where(x >= d, _power(x, g, a, b, e), c * x + f)),
}
"""Parametric curves by their number: how many parameters, and the function."""

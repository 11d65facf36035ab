"""How uncertain a photograph's values are: the sensor's noise, or what is left of a camera's tone curve."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..model import Exposure, FloatArray, Photograph
from .read import srgb_to_linear
from .response import ResponseCurve, srgb_log_slope
from .samples import DARKEST_CODE, linear_to_srgb

FULL_WELL_ELECTRONS = 30000.0
"""Electrons at saturation and ISO 100; ISO 200 saturates at half. Cameras lie between 15,000 and 80,000."""

READ_NOISE = 2.0e-4
"""Read noise (standard deviation) as a share of saturation: some 3 levels of 14 bits, 6 electrons at ISO
100."""

TONE_CURVE_ERROR = 0.05
"""Relative error of a display-referred value in mid-tones, where sRGB is close to an in-camera tone curve."""

CODE_NOISE = 1.0 / 255.0
"""Standard deviation of a code: a whole step of 8 bits, twelve times the ideal variance, for JPEG's own losses."""

EXTRAPOLATION_ERROR = 0.2
"""Error of an estimated curve beyond the codes that it was measured at, as a share of the logarithm of the light."""

RADIANCE_ERROR = 0.01
"""Radiance has no known noise: a relative error, so that equal pictures count equally."""

INDEX_SCALE = 8192.0
"""Tables are entered with this times the square root of a value: 32 entries a code of 8 bits in the light, 2.6 in the dark."""

TABLE_SIZE = 12290
"""Entries up to the value 2.25: interpolation swings beyond 1."""

BLACK_ENTRY = 102
"""The entry of half a code of 8 bits, for what lies below it."""

_LEAST_SLOPE = 1.0 / 12.92

type Table = npt.NDArray[np.float32]


@dataclass(frozen=True)
class SensorNoise:
    """A sensor's constants: electrons at saturation at ISO 100, and read noise as a share of saturation."""

    full_well_electrons: float = FULL_WELL_ELECTRONS
    read_noise: float = READ_NOISE


def noise_polynomial(
    photograph: Photograph, exposure: Exposure, sensor: SensorNoise
) -> tuple[float, float, float]:
    """Variance of a linear photograph's values as a polynomial of the level: constant, linear, square.

    Examples
    --------
    >>> raw = Photograph(__import__("pathlib").Path("a.dng"), np.zeros((1, 1, 3)), np.zeros((1, 1), bool))
    >>> noise_polynomial(raw, Exposure(0.01, iso=200.0), SensorNoise(20000.0, 0.001))
    (1e-06, 0.0001, 0.0)
    """
    if photograph.scene_referred_float:
        return sensor.read_noise**2, 0.0, RADIANCE_ERROR**2
    return sensor.read_noise**2, exposure.iso / (100.0 * sensor.full_well_electrons), 0.0


def code_index(decoded: FloatArray, scratch: Table) -> npt.NDArray[np.uint16]:
    """Where sRGB-decoded values (h, w, 3), 0 to 4, are looked up in a table: from 1 on, since entry 0 stands for nothing."""
    np.maximum(decoded, np.float32(0.0), out=scratch)  # interpolation may have swung below black
    np.sqrt(scratch, out=scratch)
    scratch *= np.float32(INDEX_SCALE)
    scratch += np.float32(1.5)
    return scratch.astype(np.uint16)


def table_values() -> FloatArray:
    """sRGB-decoded values (N,) of the entries of a table."""
    return np.asarray(((np.maximum(np.arange(TABLE_SIZE), 1) - 1.0) / INDEX_SCALE) ** 2)


def code_table(values: FloatArray) -> Table:
    """Values (N, 3) at `table_values` as a table (1, 65536, 3) for cv2.LUT, 0 at entry 0."""
    table = np.zeros((1, 65536, 3), np.float32)
    table[0, :TABLE_SIZE] = values
    table[0, TABLE_SIZE:] = values[-1]
    table[0, 0] = 0.0
    return table


def display_light(response: ResponseCurve | None) -> FloatArray:
    """The light (N, 3) that sRGB-decoded values stand for, at `table_values`."""
    decoded = np.repeat(table_values()[:, None], 3, axis=1)
    return decoded if response is None else response.linear(decoded)


def display_variance(
    response: ResponseCurve | None, light: FloatArray, exposure: Exposure, sensor: SensorNoise
) -> FloatArray:
    """Variance (N, 3) of a display-referred photograph's light, at `table_values`.

    It is that of the codes, through the curve's slope, and the error of the curve itself: of an estimated one its residual,
    growing beyond the codes that it was measured at; of sRGB in place of an unknown curve `TONE_CURVE_ERROR`, growing towards
    both ends, since in-camera curves lift or crush shadows (below about 5 %) and roll off highlights (above about 60 %).
    """
    codes = linear_to_srgb(table_values())
    if response is None:
        level = np.minimum(light, 1.0)
        slope = light * srgb_log_slope(codes)[:, None]
        error = TONE_CURVE_ERROR * (level + 0.05 + 4.0 * level * np.maximum(level - 0.6, 0.0))
    else:
        slope = light * response.log_slope(codes).T
        lowest, highest = response.codes_seen
        ends = response.linear(np.repeat(srgb_to_linear(np.array([[lowest], [highest]])), 3, axis=1))
        known = np.maximum(light, 1e-9)
        beyond = np.log(known / np.clip(known, ends[0], np.maximum(ends[1], ends[0])))
        relative = np.log(2.0) * np.array(response.residual_ev) + EXTRAPOLATION_ERROR * np.abs(beyond)
        error = relative * light
    # A code near black only says that there was little light: black is clipped, and where one channel of a saturated
    # colour is cut off, wrongly so.
    darkest = np.interp(DARKEST_CODE, codes, np.arange(len(codes)))
    lost = light[round(float(darkest))] * np.clip(2.0 - codes / DARKEST_CODE, 0.0, 1.0)[:, None]
    error = np.hypot(error, lost)
    shot = exposure.iso / (100.0 * sensor.full_well_electrons)
    # In the dark the slope of a code's light may vanish; a code's own width there is at least the first step's.
    return np.asarray((CODE_NOISE * np.maximum(slope, _LEAST_SLOPE)) ** 2 + error**2 + shot * light)

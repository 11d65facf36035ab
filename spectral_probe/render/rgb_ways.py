"""Four ways of rendering a surface in RGB beside its spectral colour, under any light (fig. 13 of the paper).

The paper does not say what its RGB renderer was. These are the four that it may have been, each for one reflection of the light
E by a reflectance R at normal incidence, relative to a perfect diffuser in the same light:

- **A0**: the colour-matching functions sampled at 460, 530 and 600 nm, with equal weights: sum of R E x̄ over three wavelengths
  (ȳ and z̄ alike), over the same sum of a perfect diffuser's Y. White is not kept: that of D65 falls at x 0.2921, y 0.3099.
- **A**: the same with one weight for each wavelength, chosen so that a perfect diffuser has exactly the colour of the light.
- **B**: R at 600, 530 and 460 nm multiplies the light's linear sRGB: a renderer whose three channels are wavelengths.
- **D**: the base colour as artists use it, the surface's linear sRGB over that of a perfect diffuser (measured under equal
  energy), multiplies the light's linear sRGB.

The spectral colour is the sum over 400-700 nm in 5 nm steps. Linear sRGB has Rec.709's primaries and the white that D65 has when
it is summed on that grid (x 0.3127, y 0.3293), so that D65 is exactly (1, 1, 1). Nothing is clipped: base colours above 1, and
negative channels of a light beyond sRGB, stay.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from typing import Any

import numpy as np

from ..errors import SpectralDataError
from ..model import FloatArray
from ..spectra.colorimetry import (
    chromaticity,
    colour_matching_functions,
    delta_e_2000,
    spectra_to_xyz,
    white_xyz,
)
from ..spectra.colour_science import colour
from ..spectra.grid import WAVELENGTHS_NM
from ..spectra.metals import METAL_NAMES, metal_page, metal_reflectance

SAMPLED_NM = (460.0, 530.0, 600.0)
"""Wavelengths at which the ways A0, A and B know a surface."""

WAYS: Mapping[str, str] = {
    "A0": "CIE functions at 460, 530, 600 nm, equal weights",
    "A": "the same, weighted so that white is kept",
    "B": "reflectance at 600, 530, 460 nm as linear sRGB",
    "D": "base colour relit in linear sRGB",
}
"""The ways by name, and what each is in a few words."""

_SAMPLED = [int(np.flatnonzero(nm == WAVELENGTHS_NM)[0]) for nm in SAMPLED_NM]
_LEAST_Z = 1e-6  # of a white whose Y is 1, so that L*a*b* is defined in light without blue


@dataclass(frozen=True)
class WayColour:
    """A surface's colour by one way: XYZ relative to a perfect diffuser, x and y, and how far it is from the spectral one.

    `xy_shift` is from the spectral colour to this one; `delta_e` is CIEDE2000 relative to the white of the light.
    """

    way: str
    xyz: tuple[float, float, float]
    xy: tuple[float, float]
    xy_shift: tuple[float, float]
    delta_e: float


@dataclass(frozen=True)
class SurfaceColours:
    """The colour of one surface spectrally and by the ways that are defined in the light, in the order of `WAYS`."""

    name: str
    xyz_spectral: tuple[float, float, float]
    xy_spectral: tuple[float, float]
    ways: tuple[WayColour, ...]

    def way(self, name: str) -> WayColour | None:
        """The colour by one way; None where that way sees nothing of the light."""
        return next((found for found in self.ways if found.way == name), None)


@dataclass(frozen=True)
class RgbWays:
    """Surfaces under one light, spectrally and by the four ways.

    Parameters
    ----------
    light
        What the light is called.
    white_xyz, white_xy
        A perfect diffuser in it, Y = 1.
    surfaces
        Their colours.
    remarks
        Sentences on what the light does to the ways.
    """

    light: str
    white_xyz: tuple[float, float, float]
    white_xy: tuple[float, float]
    surfaces: tuple[SurfaceColours, ...]
    remarks: tuple[str, ...] = ()


def metal_reflectances(metals: Sequence[str]) -> dict[str, FloatArray]:
    """Reflectance (61,) at normal incidence of metals by name; a metal goes by its English name where it has one.

    Raises
    ------
    SpectralDataError
        If a metal is unknown, or none is given.

    Examples
    --------
    >>> {name: float(curve[30].round(2)) for name, curve in metal_reflectances(["Au", "copper"]).items()}
    {'Gold': 0.79, 'Copper': 0.62}
    """
    if not metals:
        raise SpectralDataError("Name at least one metal, such as gold.")
    return {_english(metal): metal_reflectance(metal, np.array(1.0)) for metal in metals}


def _english(metal: str) -> str:
    """A symbol's or a name's English name, capitals or not; a page of refractiveindex.info stays what it is."""
    page = metal_page(metal)
    if metal.rpartition(": ")[2].count("/") == 2:
        return metal
    return next(name for symbol, name in METAL_NAMES.items() if metal_page(symbol) == page)


def compare_rgb_ways(
    reflectances: Mapping[str, FloatArray], light: FloatArray, light_name: str = "D65"
) -> RgbWays:
    """The colours of surfaces under a light, spectrally and by the four ways of RGB.

    Parameters
    ----------
    reflectances
        (61,) of each surface by name.
    light
        (61,) relative spectral power.
    light_name
        What to call it.

    Raises
    ------
    SpectralDataError
        If the light is black or not finite.

    Examples
    --------
    >>> from ..spectra.colorimetry import illuminant
    >>> gold, = compare_rgb_ways(metal_reflectances(["gold"]), illuminant("D65")).surfaces
    >>> [round(value, 4) for value in gold.xy_spectral], gold.way("A").way, round(gold.way("D").delta_e, 1)
    ([0.382, 0.3895], 'A', 1.4)
    """
    light = np.asarray(light, float)
    luminance = float(spectra_to_xyz(light)[1])
    if not (np.isfinite(light).all() and luminance > 0):
        raise SpectralDataError(f'The light "{light_name}" is black, or not a number. Choose another.')
    light = light / luminance
    white = spectra_to_xyz(light)
    lab_white = np.maximum(white, _LEAST_Z)
    surfaces = []
    for name, reflectance in reflectances.items():
        spectral = spectra_to_xyz(reflectance * light)
        xy = chromaticity(spectral)
        ways = tuple(
            WayColour(
                way,
                _floats(xyz),
                _floats(chromaticity(xyz)),
                _floats(chromaticity(xyz) - xy),
                float(delta_e_2000(spectral, xyz, lab_white)),
            )
            for way, xyz in way_colours(reflectance, light)
        )
        surfaces.append(SurfaceColours(name, _floats(spectral), _floats(xy), ways))
    remarks = tuple(_remarks(light, white))
    return RgbWays(light_name, _floats(white), _floats(chromaticity(white)), tuple(surfaces), remarks)


def way_colours(reflectance: FloatArray, light: FloatArray) -> Iterator[tuple[str, FloatArray]]:
    """The ways of `WAYS` that are defined in a light (61,), and XYZ (..., 3) of reflectances (..., 61) by each.

    A perfect diffuser has the light's own XYZ by A, B and D; by A0, that light's sampled at three wavelengths at its Y.
    """
    functions, white = colour_matching_functions()[_SAMPLED], spectra_to_xyz(light)
    sampled, at_sampled = reflectance[..., _SAMPLED], light[_SAMPLED]
    luminance = float(at_sampled @ functions[:, 1])
    if luminance > 0:
        yield "A0", sampled * at_sampled @ functions * (white[1] / luminance)
    yield "A", sampled * _weights(white) @ functions
    light_rgb = _to_srgb(white)
    yield "B", _from_srgb(sampled[..., ::-1] * light_rgb)
    equal_energy = spectra_to_xyz(np.ones(len(WAVELENGTHS_NM)))
    base_colour = _to_srgb(spectra_to_xyz(reflectance)) / _to_srgb(equal_energy)
    yield "D", _from_srgb(base_colour * light_rgb)


def ways_report(ways: RgbWays) -> dict[str, Any]:
    """The numbers as plain data for JSON: by surface, and in each by way."""
    surfaces = {
        surface.name: {
            "xyz_spectral": surface.xyz_spectral,
            "xy_spectral": surface.xy_spectral,
            **{
                way.way: {key: value for key, value in asdict(way).items() if key != "way"}
                for way in surface.ways
            },
        }
        for surface in ways.surfaces
    }
    return {
        "light": ways.light,
        "white_xyz": ways.white_xyz,
        "white_xy": ways.white_xy,
        "ways": dict(WAYS),
        "metals": surfaces,
        "remarks": list(ways.remarks),
    }


def _remarks(light: FloatArray, white: FloatArray) -> Iterator[str]:
    """What is odd about the ways in this light."""
    if not light[_SAMPLED].any():
        yield "A0 is left out: the light has nothing at 460, 530 and 600 nm."
    if (_weights(white) < 0).any():
        yield "A weighs a wavelength negatively: no mixture of 460, 530 and 600 nm has the colour of this light."
    if (_to_srgb(white) < 0).any():
        yield "B and D have a negative channel: the colour of this light is beyond sRGB."


def _weights(white: FloatArray) -> FloatArray:
    """Weights (3,) of the sampled wavelengths with which a perfect diffuser has XYZ (3,)."""
    return np.linalg.solve(colour_matching_functions()[_SAMPLED].T, white)


@cache
def _srgb_matrix() -> FloatArray:
    """(3, 3) from linear sRGB to XYZ; its white is D65 as summed on our grid."""
    primaries = colour.RGB_COLOURSPACES["sRGB"].primaries
    matrix = np.asarray(colour.normalised_primary_matrix(primaries, chromaticity(white_xyz("D65"))))
    matrix.flags.writeable = False
    return matrix


def _from_srgb(rgb: FloatArray) -> FloatArray:
    return rgb @ _srgb_matrix().T


def _to_srgb(xyz: FloatArray) -> FloatArray:
    return xyz @ np.linalg.inv(_srgb_matrix()).T


def _floats(values: FloatArray) -> Any:
    """A tuple of Python's own numbers."""
    return tuple(float(value) for value in values)

"""Tristimulus values and colour differences: colour-science on our wavelength grid.

Spectra are spectral radiance per nm on `grid.WAVELENGTHS_NM`; XYZ are sums of radiance times the CIE 1931
2 degree colour-matching functions over nm, not normalised: an image's white is stated where it matters.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from ..errors import SpectralDataError
from ..large import let_go, strips
from ..model import FloatArray, SpectralPanorama
from .colour_science import colour
from .grid import STEP_NM, WAVELENGTHS_NM, resample

_OBSERVER = "CIE 1931 2 Degree Standard Observer"


def on_grid(distribution: Any) -> FloatArray:
    """Values of a colour-science (multi-)spectral distribution at `WAVELENGTHS_NM`.

    Linear between samples and constant beyond its ends (tabulated lights often start at 405 or 410 nm).
    """
    known = np.asarray(distribution.wavelengths, float)
    values = np.asarray(distribution.values, float)
    if values.ndim == 1:
        return np.interp(WAVELENGTHS_NM, known, values)
    return np.stack([np.interp(WAVELENGTHS_NM, known, column) for column in values.T], axis=-1)


@cache
def colour_matching_functions() -> FloatArray:
    """CIE 1931 2 degree colour-matching functions, (61, 3).

    Examples
    --------
    >>> colour_matching_functions()[31].round(4).tolist()  # 555 nm
    [0.5121, 1.0, 0.0057]
    """
    return _read_only(on_grid(colour.MSDS_CMFS[_OBSERVER]))


@cache
def illuminant(name: str) -> FloatArray:
    """Relative spectral power of a CIE illuminant or light source of colour-science, (61,).

    Raises
    ------
    SpectralDataError
        If there is no light of that name.
    """
    for lights in (colour.SDS_ILLUMINANTS, colour.SDS_LIGHT_SOURCES):
        if name in lights:
            return _read_only(on_grid(lights[name]))
    raise SpectralDataError(f'There is no light called "{name}" in the library.')


def spectra_to_xyz(spectra: FloatArray) -> FloatArray:
    """Tristimulus values of spectral radiance: the sum over nm of radiance times colour-matching functions.

    Parameters
    ----------
    spectra
        (..., 61) per nm.

    Returns
    -------
    ndarray
        (..., 3).
    """
    return spectra @ (colour_matching_functions() * STEP_NM).astype(spectra.dtype)


def panorama_xyz(panorama: SpectralPanorama, rows: slice | None = None) -> FloatArray:
    """Tristimulus values of every direction of a panorama, (H, W, 3) float32: the weights times the bases' own XYZ.

    Of some rows (h, W, 3) where they are given.
    """
    bases_xyz = spectra_to_xyz(resample(panorama.wavelengths_nm, panorama.bases, name="the panorama"))
    wanted = slice(0, len(panorama.valid)) if rows is None else rows
    xyz = np.zeros((wanted.stop - wanted.start, panorama.valid.shape[1], 3), np.float32)
    for part in strips(*xyz.shape[:2]):
        own = slice(wanted.start + part.start, wanted.start + part.stop)
        for index, basis_xyz in enumerate(bases_xyz.astype(np.float32)):
            uses = panorama.basis_index[own] == index
            xyz[part][uses] = panorama.weights[own][uses] @ basis_xyz
        let_go(panorama.weights)
    return xyz


@cache
def white_xyz(light: str = "D65") -> FloatArray:
    """Tristimulus values of a perfect diffuser under a light, Y = 1, (3,), by summation on our grid."""
    xyz = spectra_to_xyz(illuminant(light))
    return _read_only(xyz / xyz[1])


@cache
def _rec709_matrix() -> FloatArray:
    return _read_only(np.asarray(colour.RGB_COLOURSPACES["ITU-R BT.709"].matrix_XYZ_to_RGB, float))


def xyz_to_rec709(xyz: FloatArray) -> FloatArray:
    """Scene-linear Rec.709 (D65 white) of tristimulus values, (..., 3) -> (..., 3); negative where out of gamut."""
    return xyz @ _rec709_matrix().T.astype(np.asarray(xyz).dtype)


def panorama_rec709(panorama: SpectralPanorama, rows: slice | None = None) -> FloatArray:
    """A panorama, or some rows of it, in scene-linear Rec.709, (H, W, 3) float32; colours out of gamut are cut at zero."""
    return np.maximum(xyz_to_rec709(panorama_xyz(panorama, rows)), 0.0)


def rec709_to_xyz(rgb: FloatArray) -> FloatArray:
    """Tristimulus values of scene-linear Rec.709, (..., 3) -> (..., 3); the inverse of `xyz_to_rec709`.

    Examples
    --------
    >>> rec709_to_xyz(np.array([1.0, 1.0, 1.0])).round(4).tolist()
    [0.9505, 1.0, 1.0891]
    """
    return rgb @ np.linalg.inv(_rec709_matrix()).T.astype(np.asarray(rgb).dtype)


def adapted_to_d65(xyz: FloatArray, white: FloatArray) -> FloatArray:
    """Tristimulus values (..., 3) as an eye adapted to a white (3,) sees them, for a display whose white is D65 (CAT16).

    For showing pictures of scenes under coloured light; luminance of the white stays. Differences are computed without it.

    Examples
    --------
    >>> lamp = spectra_to_xyz(illuminant("A"))
    >>> chromaticity(adapted_to_d65(lamp, lamp)).round(3).tolist()
    [0.313, 0.329]
    """
    white = np.asarray(white, float)
    matrix = colour.adaptation.matrix_chromatic_adaptation_VonKries(
        white / white[1], white_xyz(), transform="CAT16"
    )
    return np.asarray(xyz @ np.asarray(matrix).T.astype(np.asarray(xyz).dtype))


def chromaticity(xyz: FloatArray) -> FloatArray:
    """Chromaticity coordinates (x, y) of tristimulus values, (..., 3) -> (..., 2); black gives the white of D65.

    Examples
    --------
    >>> chromaticity(np.array([0.9505, 1.0, 1.0891])).round(4).tolist()
    [0.3127, 0.329]
    """
    total = xyz.sum(-1, keepdims=True)
    white = colour.CCS_ILLUMINANTS[_OBSERVER]["D65"]
    return np.where(total > 0, xyz[..., :2] / np.where(total > 0, total, 1.0), white)


def xyz_to_lab(xyz: FloatArray, white: FloatArray) -> FloatArray:
    """CIE 1976 L*a*b*, (..., 3), of tristimulus values relative to a white (3,)."""
    white = np.asarray(white, float)
    xy = white[:2] / white.sum()
    return np.asarray(colour.XYZ_to_Lab(np.asarray(xyz, float) / white[1], xy))


def delta_e_2000(xyz_a: FloatArray, xyz_b: FloatArray, white: FloatArray) -> FloatArray:
    """CIEDE2000 colour difference of two sets of tristimulus values, (..., 3) x (..., 3) -> (...).

    Both are taken relative to the same white (3,), whose Y is the luminance of a perfect diffuser.
    """
    return np.asarray(colour.delta_E(xyz_to_lab(xyz_a, white), xyz_to_lab(xyz_b, white), method="CIE 2000"))


def _read_only(array: FloatArray) -> FloatArray:
    array.flags.writeable = False
    return array

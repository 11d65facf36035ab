"""The reflectance of a ball as somebody measured it: the best there is, since platings and patina differ.

A file has wavelengths and the reflectance at normal incidence. Further columns may give it at other angles of incidence,
in degrees by their names: `wavelength_nm,0,30,45deg,R_60deg`.
"""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import numpy as np

from ..errors import SpectralDataError
from ..files.spectrum_file import first_columns, read_samples
from ..model import FloatArray
from .curves import REFLECTANCE, SampledCurves, on_grid
from .grid import WAVELENGTHS_NM

_ANGLE = re.compile(r"(\d+(?:\.\d+)?)|(?:.*?[\s_-])?(\d+(?:\.\d+)?)\s*(?:°|deg\w*)", re.IGNORECASE)


def measured_ball_reflectance(
    path: Path, cos_incidence: FloatArray, wavelengths_nm: FloatArray = WAVELENGTHS_NM
) -> FloatArray:
    """Reflectance of a measured ball at any incidence, (..., L) for cosines of any shape (...).

    Parameters
    ----------
    path
        A file of `spectrum_file.read_samples` with fractions 0..1.
    cos_incidence
        (...) cosine of the incidence angle.
    wavelengths_nm
        (L,) within 400-700 nm.

    Raises
    ------
    SpectralDataError
        If the file cannot be read or used, or its angles do not ascend from 0 to below 90.

    Notes
    -----
    Towards grazing incidence reflectance rises to 1 as `grazing_growth` has it. What was measured at further angles
    corrects that; between angles the correction is linear, beyond the last it fades to nothing at 90 degrees.
    """
    samples, angles_deg = _by_angle(read_samples(path))
    measured = np.stack(
        [np.interp(wavelengths_nm, WAVELENGTHS_NM, row) for row in on_grid(samples, REFLECTANCE)]
    )
    incidence_deg = np.degrees(np.arccos(np.clip(np.asarray(cos_incidence, float), 0.0, 1.0)))
    normal = measured[0]

    def modelled(deg: FloatArray) -> FloatArray:
        growth = grazing_growth(np.cos(np.radians(deg)), normal, wavelengths_nm)
        return np.asarray(normal + (1.0 - normal) * growth)

    correction = measured - modelled(angles_deg)
    correction[0] = (
        0.0  # the first column stands for normal incidence, whether taken at 0 or, as often, at 8 degrees
    )
    nodes = np.append(angles_deg, 90.0)
    shares = np.stack([np.interp(incidence_deg, nodes, node) for node in np.eye(len(nodes))[:-1]], axis=-1)
    return np.asarray(np.clip(modelled(incidence_deg) + shares @ correction, 0.0, 1.0))


def grazing_growth(
    cos_incidence: FloatArray, normal_reflectance: FloatArray, wavelengths_nm: FloatArray = WAVELENGTHS_NM
) -> FloatArray:
    """How far a metal's reflectance has risen from its value at normal incidence (0) to 1 at grazing (1).

    Parameters
    ----------
    cos_incidence
        (...).
    normal_reflectance
        (L,) what it reflects at normal incidence.
    wavelengths_nm
        (L,).

    Returns
    -------
    ndarray
        (..., L) in about 0..1; below 0 where metals dip before they rise.

    Notes
    -----
    Taken from exact Fresnel reflectance of two kinds of mirror and mixed between them by the normal reflectance: steel
    after eq. 11 (about 0.53) and aluminium (about 0.92). Schlick's power of five is meant for glass and misses chrome at 80
    degrees by 0.18; measured against exact Fresnel curves, this misses chrome, nickel, measured steel, silver and
    aluminium by at most 0.010 to 60 and 0.07 to 80 degrees (chrome 0.013).
    """
    from .metals import metal_reflectance  # which knows this module

    cosine = np.asarray(cos_incidence, float)

    def growth(fractions: dict[str, float]) -> tuple[FloatArray, FloatArray]:
        def mixed(at: FloatArray) -> FloatArray:
            parts = [
                share * metal_reflectance(metal, at, wavelengths_nm) for metal, share in fractions.items()
            ]
            return np.asarray(sum(parts))

        normal = mixed(np.array(1.0))
        return normal, (mixed(cosine) - normal) / (1.0 - normal)

    steel_normal, steel = growth({"Fe": 0.74, "Cr": 0.18, "Ni": 0.08})
    aluminium_normal, aluminium = growth({"Al": 1.0})
    towards_aluminium = np.clip(
        (normal_reflectance - steel_normal) / (aluminium_normal - steel_normal), 0.0, 1.0
    )
    return steel + towards_aluminium * (aluminium - steel)


def _by_angle(samples: SampledCurves) -> tuple[SampledCurves, FloatArray]:
    """The columns that are reflectances at an angle, and the angles in degrees; the first alone where it names none."""
    angles: list[float] = []
    for column in samples.columns:
        match = _ANGLE.fullmatch(column.strip())
        if match is None:
            break
        angles.append(float(match[1] or match[2]))
    angles = angles or [0.0]
    if angles[0] > 10.0 or any(later <= earlier for earlier, later in pairwise(angles)):
        raise SpectralDataError(
            f"The angles of incidence of {samples.name} are {', '.join(f'{angle:g}' for angle in angles)} degrees. "
            "Let its columns ascend from 0 (10 at most)."
        )
    if angles[-1] >= 90.0:
        raise SpectralDataError(
            f"{samples.name} has a reflectance at {angles[-1]:g} degrees. Angles end below 90."
        )
    return first_columns(samples, len(angles)), np.array(angles)

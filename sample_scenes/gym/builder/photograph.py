"""The camera: spectral radiance to a 14-bit Bayer mosaic with photon and read noise, written as DNG."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import numpy.typing as npt

from .layout import BALL_RADIUS_M, CAMERA_DISTANCE_M, FOCAL_MM, FOCAL_PX, PICTURE_PX, PRINCIPAL_PX
from .spectra import (
    CAMERA,
    NODES_NM,
    WAVELENGTHS_NM,
    Array,
    ball_reflectance,
    camera_sensitivities,
    colour_matching_functions,
    colour_science,
    lamp_radiance,
    node_interpolation,
    reflectances,
    spline,
    window_radiance,
)

EXPOSURES_S = (Fraction(1, 800), Fraction(1, 100), Fraction(2, 25))
BLACK_LEVEL, WHITE_LEVEL = 600, 15892
FULL_WELL_ELECTRONS, READ_NOISE_ELECTRONS = 36000.0, 3.5
LAMP_LEVEL = 0.70
EMITTER_LEVEL, EMITTER_SPREAD = 0.2, 0.08
F_NUMBER, ISO = 16, 100


def incidence_cosines() -> Array:
    """(H, W) cosine of the angle of incidence on the ball at pixel centres, the same in every view; NaN beside the ball."""
    y, x = (np.mgrid[:PICTURE_PX, :PICTURE_PX] + 0.5) - np.array(PRINCIPAL_PX[::-1])[:, None, None]
    rays = np.stack([x / FOCAL_PX, y / FOCAL_PX, np.ones_like(x)], -1)
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    to_ball = rays[..., 2] * CAMERA_DISTANCE_M
    below = to_ball**2 - CAMERA_DISTANCE_M**2 + BALL_RADIUS_M**2
    root = np.sqrt(np.where(below > 0, below, np.nan))
    return np.asarray(root / BALL_RADIUS_M)


def restore_emitters(layers: Array) -> Array:
    """Layers (2, N, H, W) of a view, with the ball's reflectance as the exact shape of each mirrored lamp and window.

    A layer's own emitter has radiance 1 (windows 0.7 to 1) at every node, so its image in the ball is the ball's
    reflectance times one number. The denoiser keeps that only to some 2 percent: it treats the channels R, G, B differently.
    """
    cosines = incidence_cosines()
    on_ball = np.isfinite(cosines)
    reflectance = spline(WAVELENGTHS_NM, ball_reflectance(cosines[on_ball]).T, NODES_NM)
    restored = layers.copy()
    for layer in restored:
        factors = layer[:, on_ball] / reflectance
        level, spread = factors.mean(0), factors.std(0)
        emitter = (level > EMITTER_LEVEL) & (spread < EMITTER_SPREAD * level)
        layer[:, on_ball] = np.where(emitter, level * reflectance, layer[:, on_ball])
    return np.asarray(restored)


def layers_to_spectra(layers: Array) -> Array:
    """(..., L) spectral radiance in W m-2 sr-1 nm-1 from layers (2, N, ...) of unit radiance at the nodes."""
    light = np.stack([lamp_radiance(), window_radiance()])
    return np.asarray(np.einsum("al,ln,an...->...l", light, node_interpolation(), layers, optimize=True))


def layers_to_sensor(layers: Array, responses: Array) -> Array:
    """(..., C) what `responses` (L, C) make of the light: the sum over nm, from layers (2, N, ...)."""
    light = np.stack([lamp_radiance(), window_radiance()])
    per_node = np.einsum("al,ln,lc->anc", light, node_interpolation(), responses * 5.0)
    return np.asarray(np.einsum("anc,an...->...c", per_node, layers, optimize=True))


def saturation_radiance(camera_rgb_of_lamp: Array) -> float:
    """The camera signal times seconds that fills a pixel: the lamp in the ball reaches `LAMP_LEVEL` in the shortest exposure."""
    return float(camera_rgb_of_lamp.max() * float(EXPOSURES_S[0]) / LAMP_LEVEL)


def expose(
    camera_rgb: Array, exposure_s: float, saturation: float, random: np.random.Generator
) -> npt.NDArray[np.uint16]:
    """(H, W) RGGB mosaic of linear camera RGB (H, W, 3), with photon and read noise."""
    height, width = camera_rgb.shape[:2]
    rows, columns = np.mgrid[:height, :width]
    seen = np.take_along_axis(camera_rgb, (rows % 2 + columns % 2)[..., None], axis=2)[..., 0]
    electrons = random.poisson(np.clip(seen, 0, None) * exposure_s / saturation * FULL_WELL_ELECTRONS)
    noisy = electrons + random.normal(0.0, READ_NOISE_ELECTRONS, seen.shape)
    levels = BLACK_LEVEL + noisy / FULL_WELL_ELECTRONS * (WHITE_LEVEL - BLACK_LEVEL)
    return np.clip(np.rint(levels), 0, WHITE_LEVEL).astype(np.uint16)


def colour_matrix() -> Array:
    """(3, 3) XYZ to camera RGB under D65, fitted to the ColorChecker: for raw developers; Spectral Probe does not use it."""
    d65 = colour_science().SDS_ILLUMINANTS["D65"]
    light = np.interp(WAVELENGTHS_NM, d65.wavelengths, d65.values)
    paints = np.stack(list(reflectances().values()))
    xyz = (paints * light) @ colour_matching_functions() / (light @ colour_matching_functions()[:, 1])
    rgb = (paints * light) @ camera_sensitivities() / (light @ camera_sensitivities()).max()
    return np.asarray(np.linalg.lstsq(xyz, rgb, rcond=None)[0].T)


def _rationals(values: Array, denominator: int = 10000) -> tuple[int, ...]:
    return tuple(int(v) for x in np.ravel(values) for v in (round(float(x) * denominator), denominator))


def write_dng(path: Path, mosaic: npt.NDArray[np.uint16], exposure_s: Fraction, neutral: Array) -> None:
    """Write an uncompressed DNG 1.4; `neutral` (3,) is the camera RGB of the light's white, green 1."""
    from tifffile import TiffWriter

    ascii_, byte, short, rational, signed_rational = 2, 1, 3, 5, 10
    tags = [
        (271, ascii_, 0, "Spectral Probe", True),
        (272, ascii_, 0, CAMERA, True),
        (274, short, 1, 1, True),
        (33421, short, 2, (2, 2), True),
        (33422, byte, 4, b"\x00\x01\x01\x02", True),
        (33434, rational, 1, (exposure_s.numerator, exposure_s.denominator), True),
        (33437, rational, 1, (F_NUMBER, 1), True),
        (34855, short, 1, ISO, True),
        (37386, rational, 1, (int(FOCAL_MM), 1), True),
        (50706, byte, 4, b"\x01\x04\x00\x00", True),
        (50707, byte, 4, b"\x01\x01\x00\x00", True),
        (50708, ascii_, 0, f"Spectral Probe {CAMERA}", True),
        (50710, byte, 3, b"\x00\x01\x02", True),
        (50711, short, 1, 1, True),
        (50714, short, 1, BLACK_LEVEL, True),
        (50717, short, 1, WHITE_LEVEL, True),
        (50721, signed_rational, 9, _rationals(colour_matrix()), True),
        (50728, rational, 3, _rationals(neutral), True),
        (50778, short, 1, 21, True),
    ]
    with TiffWriter(path, byteorder="<") as file:
        file.write(mosaic, photometric="cfa", software="sample_scenes/gym/build.py", metadata=None, extratags=tags,
                   rowsperstrip=mosaic.shape[0], subfiletype=0)  # fmt: skip

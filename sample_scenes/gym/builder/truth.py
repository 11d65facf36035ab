"""The truth of the sample: the spectra of the light, where it comes from, and the panorama that a probe should find."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from .layout import (
    AZIMUTHS_DEG,
    BALL_AT,
    BALL_RADIUS_M,
    CAMERA_DISTANCE_M,
    LAMP_RADIUS_M,
    LAMPS_AT,
    WINDOW_SIZE_M,
    WINDOWS_AT,
)
from .spectra import BALL_FRACTIONS, CAMERA, WAVELENGTHS_NM, Array, lamp_radiance, luminance, window_radiance

COMPONENTS = 12
QUANTUM = 1e-3
EMITTER_LUMINANCE_CD_M2 = 1500.0
RECOMMENDED_LAMP, RECOMMENDED_WINDOW = 8, 3
MILLIWATTS = 1000.0


def write_spectrum(path: Path, radiance: Array, comment: str) -> None:
    """One spectrum (L,) as CSV."""
    rows = [f"# {comment}", "wavelength_nm,radiance_W_m2_sr_nm"]
    rows += [f"{nm:g},{value:.7g}" for nm, value in zip(WAVELENGTHS_NM, radiance, strict=True)]
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")


def _direction(at: Any) -> dict[str, float]:
    x, y, z = np.asarray(at, float) - BALL_AT
    return {
        "bearing_deg": round(float(np.degrees(np.arctan2(x, y)) % 360.0), 3),
        "elevation_deg": round(float(np.degrees(np.arctan2(z, np.hypot(x, y)))), 3),
        "distance_m": round(float(np.sqrt(x * x + y * y + z * z)), 3),
    }


def scene_description() -> dict[str, Any]:
    """Where lamps and windows are, as directions from the ball's centre: compass bearing (0 = +Y, clockwise) and elevation."""
    lower_pane_m = -0.35 * WINDOW_SIZE_M[1] / 2
    lamps = [
        {"name": f"lamp {i}", "at_m": list(map(float, at)), **_direction(at)} for i, at in enumerate(LAMPS_AT)
    ]
    windows = [
        {
            "name": f"window {i}",
            "at_m": [round(float(x), 3), float(y), float(z)],
            **_direction((x, y, z + lower_pane_m)),
        }
        for i, (x, y, z) in enumerate(WINDOWS_AT)
    ]
    return {
        "frame": "world: metres, z up, +Y towards the windows; bearing 0 = +Y, clockwise from above",
        "ball_at_m": list(BALL_AT),
        "lamp_radius_m": LAMP_RADIUS_M,
        "window_size_m": list(WINDOW_SIZE_M),
        "window_direction": "of the middle lower pane, clear of mullions",
        "recommended": {"lamp": lamps[RECOMMENDED_LAMP], "window": windows[RECOMMENDED_WINDOW]},
        "lamps": lamps,
        "windows": windows,
    }


def case_description() -> dict[str, Any]:
    """What a scorer of probes needs: geometry, lamps, and how to tell emitters (lamps are warm) from the rest."""
    return {
        "ball_at": list(BALL_AT),
        "ball_radius": BALL_RADIUS_M,
        "ball": BALL_FRACTIONS,
        "distance": CAMERA_DISTANCE_M,
        "views": [{"azimuth_deg": azimuth} for azimuth in AZIMUTHS_DEG],
        "camera": CAMERA,
        "lamps": [{"at": list(map(float, at)), "search_deg": 7} for at in LAMPS_AT],
        "region_thresholds": [MILLIWATTS * EMITTER_LUMINANCE_CD_M2 / 683.0 / 5.0],
        "warm_ratio": 2.0,
    }


def compress_panorama(path: Path, spectra: Array) -> float:
    """Write spectra (H, W, L) as level, quantised weights and basis; return the largest relative error of a pixel.

    The basis starts with the lamps and the windows, so that these are exact, and goes on with principal components.
    """
    level = luminance(spectra)
    shapes = (spectra / level[..., None]).reshape(-1, spectra.shape[-1])
    mean = shapes.mean(0)
    scale = float(np.linalg.norm(mean))
    emitters = np.stack(
        [radiance / luminance(radiance) - mean for radiance in (lamp_radiance(), window_radiance())]
    )
    exact = np.linalg.qr(emitters.T)[0].T
    rest = (shapes - mean) - (shapes - mean) @ exact.T @ exact
    principal = np.linalg.svd(rest, full_matrices=False)[2][: COMPONENTS - len(exact)]
    components = np.concatenate([exact, principal])
    weights = np.rint((shapes - mean) @ components.T / (QUANTUM * scale)).astype(np.int16)
    np.savez_compressed(
        path,
        wavelengths_nm=WAVELENGTHS_NM,
        luminance_cd_m2=level.astype(np.float16),
        weights=weights.reshape(*level.shape, COMPONENTS).transpose(2, 0, 1),
        mean=mean,
        components=components * QUANTUM * scale,
    )
    restored = expand_panorama(path)
    error = np.linalg.norm(restored - spectra, axis=-1) / np.linalg.norm(spectra, axis=-1)
    return float(error.max())


def expand_panorama(path: Path) -> Array:
    """(H, W, L) spectral radiance in W m-2 sr-1 nm-1; column centre is +Y, +X right of it, row 0 is up."""
    with np.load(path) as stored:
        shapes = stored["mean"] + np.einsum(
            "khw,kl->hwl", stored["weights"].astype(float), stored["components"]
        )
        return np.asarray(shapes * stored["luminance_cd_m2"].astype(float)[..., None])


def write_truth(folder: Path, panorama: Array) -> float:
    """Write lamp.csv, window.csv, scene.json, case.json and panorama.npz; return the panorama's largest relative error."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, radiance, comment in (
        (
            "lamp.csv",
            lamp_radiance(),
            'the lamps: colour-science "60 A/W (Soft White)" (BSD-3-Clause), scaled',
        ),
        (
            "window.csv",
            window_radiance(),
            "the windows at their brightest: CIE daylight of 6100 K through float glass",
        ),
    ):
        write_spectrum(folder / name, radiance, comment)
    for name, content in (("scene.json", scene_description()), ("case.json", case_description())):
        (folder / name).write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    return compress_panorama(folder / "panorama.npz", panorama)


def write_for_scoring(truth: Path, folder: Path) -> None:
    """Expand the truth into `folder` as truth.npz (wavelengths; panorama in mW m-2 sr-1 nm-1, float16) and case.json."""
    folder.mkdir(parents=True, exist_ok=True)
    panorama = (expand_panorama(truth / "panorama.npz") * MILLIWATTS).astype(np.float16)
    np.savez_compressed(folder / "truth.npz", wavelengths=WAVELENGTHS_NM, panorama=panorama)
    (folder / "case.json").write_text((truth / "case.json").read_text(encoding="utf-8"), encoding="utf-8")

"""The metals scene in Mitsuba 3, in a process and a Python of its own; `mitsuba.py` runs it.

    PYTHON -I benchmarks/mitsuba_render.py scene.json out.npz (--samples 64 | --seconds 12.5)

The light is made of real spectra: a constant emitter for the room, and for each patch a disc so far away that it stands in the
same direction from everywhere in the scene; it hides the room behind it. Wavelengths are sampled by Mitsuba in 360-830 nm, where
there is no light beyond 400-700 nm. XYZ in the unit of the reference: radiance times colour-matching functions, summed over nm.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

FAR = 1e4
"""Distance of the patches; the visible floor, a few units wide, sees them shifted by less than 0.05 degrees."""

MATCHING_SUM = 106.8566
"""Sum over nm of y-bar, by which Mitsuba divides tristimulus values."""

PADDED_NM = (360.0, 830.0)


def spectrum(values: list[float], *, light: bool) -> dict[str, Any]:
    """A spectrum of samples at 400-700 nm: dark beyond if it is light, else constant."""
    padded = np.asarray(values, float)
    first, last = 400.0, 700.0
    if not light:
        step = (last - first) / (len(padded) - 1)
        before, after = round((first - PADDED_NM[0]) / step), round((PADDED_NM[1] - last) / step)
        padded = np.pad(padded, (before, after), mode="edge")
        first, last = PADDED_NM
    text = ", ".join(f"{value:.9g}" for value in padded)
    return {"type": "regular", "wavelength_min": first, "wavelength_max": last, "values": text}


def direction(azimuth_deg: float, elevation_deg: float) -> list[float]:
    """Unit vector of a compass bearing (clockwise from +Y seen from above) and an elevation."""
    azimuth, elevation = math.radians(azimuth_deg), math.radians(elevation_deg)
    level = math.cos(elevation)
    return [math.sin(azimuth) * level, math.cos(azimuth) * level, math.sin(elevation)]


def scene_of(description: dict[str, Any]) -> Any:
    """The described scene."""
    to_world, camera = mi.ScalarTransform4f, description["camera"]
    width, height = description["size"]
    parts: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 13, "rr_depth": 100},
        "sensor": {
            "type": "perspective",
            "fov": camera["fov_x_deg"],
            "fov_axis": "x",
            "to_world": to_world().look_at(origin=camera["at"], target=camera["target"], up=[0, 0, 1]),
            "film": {
                "type": "hdrfilm",
                "width": width,
                "height": height,
                "pixel_format": "xyz",
                "component_format": "float32",
                "rfilter": {"type": "box"},
            },
        },
        "room": {"type": "constant", "radiance": spectrum(description["ambient"], light=True)},
        "floor": {
            "type": "rectangle",
            "to_world": to_world().scale(description["floor_half_size"]),
            "bsdf": {
                "type": "twosided",
                "nested": {
                    "type": "diffuse",
                    "reflectance": spectrum(description["floor_reflectance"], light=False),
                },
            },
        },
    }
    for number, patch in enumerate(description["patches"]):
        towards = direction(patch["azimuth_deg"], patch["elevation_deg"])
        radius = FAR * math.tan(math.radians(patch["angular_radius_deg"]))
        place = to_world().look_at(origin=[FAR * c for c in towards], target=[0, 0, 0], up=[0, 0, 1])
        parts[f"patch_{number}"] = {
            "type": "disk",
            "to_world": place @ to_world().scale(radius),
            "emitter": {"type": "area", "radiance": spectrum(patch["radiance"], light=True)},
        }
    for number, ball in enumerate(description["balls"]):
        metal: dict[str, Any] = {
            "type": "roughconductor" if ball["ggx_alpha"] else "conductor",
            "eta": spectrum(ball["n"], light=False),
            "k": spectrum(ball["k"], light=False),
        }
        if ball["ggx_alpha"]:
            metal |= {"distribution": "ggx", "alpha": ball["ggx_alpha"]}
        parts[f"ball_{number}"] = {
            "type": "sphere",
            "center": ball["at"],
            "radius": ball["radius"],
            "bsdf": metal,
        }
    return mi.load_dict(parts)


def rendered(scene: Any, samples: int, seed: int) -> tuple[np.ndarray[Any, Any], float]:
    """XYZ image (H, W, 3) and the seconds it took."""
    start = time.perf_counter()
    image = mi.render(scene, spp=samples, seed=seed)
    xyz = np.array(image)[..., :3] * MATCHING_SUM
    return xyz, time.perf_counter() - start


def main() -> None:
    """Render with the samples, or for the seconds, asked for."""
    parser = argparse.ArgumentParser()
    parser.add_argument("scene", type=Path)
    parser.add_argument("output", type=Path)
    parser.add_argument("--samples", type=int)
    parser.add_argument("--seconds", type=float)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    mi.set_variant("scalar_spectral")
    scene = scene_of(json.loads(options.scene.read_text()))
    samples = options.samples
    if samples is None:
        rendered(scene, 1, seed=100)  # what the first render alone has to do
        _, trial = rendered(scene, 4, seed=101)
        _, longer = rendered(scene, max(8, round(2.0 / trial)), seed=102)
        samples = max(1, round(options.seconds / longer * max(8, round(2.0 / trial))))
    xyz, seconds = rendered(scene, samples, options.seed)
    np.savez(options.output, xyz=xyz, seconds=seconds, samples=samples, version=mi.__version__)


if __name__ == "__main__":
    main()

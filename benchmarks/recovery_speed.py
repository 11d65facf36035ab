"""Time of recovering the spectra of a 4096 x 2048 panorama of camera responses, method by method.

    python benchmarks/recovery_speed.py [--repeat 2] [--width 4096]

The responses are those of a Nikon D5100 (and of the same camera through a green glass, for six channels) to mixtures of the
library's lights, half of them reflected by surfaces, at levels over four decades and with the noise of a good photograph. Ours is
what `light.recover_light` does with them: spectra, expected errors and non-negativity in blocks of rows on all processors.
Beside it stands the least there is to do, a bare product of the same array with a 3 x 3 matrix. Each time is the best of the
repetitions.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from spectral_probe.parallel import in_parallel, processors, row_blocks
from spectral_probe.spectra.camera import camera_sensitivities
from spectral_probe.spectra.emitters import direct_probability
from spectral_probe.spectra.glass import glass_transmittance
from spectral_probe.spectra.grid import STEP_NM
from spectral_probe.spectra.library import AUTOMATIC, surface_reflectances, training_lights
from spectral_probe.spectra.recovery import SpectralRecovery, spectral_recovery

CAMERA = "Nikon 5100 (NPL)"
FAMILIES = ("incandescent", "daylight")
RELATIVE_NOISE = 0.005


def spectra(random: np.random.Generator, count: int) -> np.ndarray:
    """Mixtures (count, 61) of two lights of the library each, every other one reflected by a surface."""
    lights = training_lights([AUTOMATIC])
    lights = lights / lights.mean(-1, keepdims=True)
    share = random.random((count, 1))
    mixed = share * lights[random.integers(len(lights), size=count)]
    mixed += (1 - share) * lights[random.integers(len(lights), size=count)]
    surfaces = surface_reflectances()
    mixed[::2] *= surfaces[random.integers(len(surfaces), size=len(mixed[::2]))]
    return np.asarray(mixed * 10 ** random.uniform(-3, 1, (count, 1)))


def panorama(sensitivities: np.ndarray, width: int) -> tuple[np.ndarray, np.ndarray]:
    """Responses (H, W, C) with their noise, and its variance."""
    random = np.random.default_rng(0)
    kinds = (spectra(random, 1 << 14) @ sensitivities * STEP_NM).astype(np.float32)
    responses = kinds[random.integers(len(kinds), size=(width // 2, width))]
    error = np.float32(RELATIVE_NOISE) * responses.max(-1, keepdims=True)
    responses += error * random.standard_normal(responses.shape, np.float32)
    return responses, np.broadcast_to(error**2, responses.shape).copy()


def recovered(recovery: SpectralRecovery, responses: np.ndarray, variance: np.ndarray) -> float:
    """Seconds that the recovery takes, block by block as in `light.recover_light`."""
    height, width = responses.shape[:2]
    weights = np.zeros((height, width, recovery.bases.shape[1]), np.float32)
    index = np.zeros((height, width), np.uint8)
    error = np.zeros((height, width), np.float32)

    def recover(rows: slice) -> None:
        direct = direct_probability(responses[rows][..., :3] @ recovery.to_luminance, 1.0)
        found = recovery.recover(responses[rows], variance[rows], direct)
        weights[rows], index[rows], error[rows] = found.weights, found.basis_index, found.relative_error

    start = time.perf_counter()
    in_parallel(recover, row_blocks(width))
    return time.perf_counter() - start


def bare(responses: np.ndarray) -> float:
    """Seconds of the product with a 3 x 3 matrix."""
    matrix = np.random.default_rng(1).random((3, 3)).astype(np.float32)
    three = np.ascontiguousarray(responses[..., :3]).reshape(-1, 3)
    start = time.perf_counter()
    three @ matrix
    return time.perf_counter() - start


def main() -> None:
    """Print the seconds of every method, and how many bare products they are."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeat", type=int, default=2)
    parser.add_argument("--width", type=int, default=4096)
    arguments = parser.parse_args()
    camera = camera_sensitivities(CAMERA)
    through = camera * glass_transmittance("green")[:, None]
    sys.stdout.write(f"{arguments.width} x {arguments.width // 2}, {processors()} processors\n")
    for sensitivities in (camera, np.concatenate([camera, through], axis=-1)):
        responses, variance = panorama(sensitivities, arguments.width)
        least = min(bare(responses) for _ in range(arguments.repeat))
        sys.stdout.write(f"{responses.shape[-1]} channels: 3 x 3 product {least:.3f} s\n")
        for method in ("paper", "family", "automatic"):
            recovery = spectral_recovery(sensitivities, FAMILIES, method)
            taken = min(recovered(recovery, responses, variance) for _ in range(arguments.repeat))
            sys.stdout.write(f"  {method:10s} {taken:7.2f} s   {taken / least:6.1f} products\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main()

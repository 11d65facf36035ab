"""Time and memory of one ball of 2048 pixels becoming a 4096 x 2048 panorama of spectral weights.

    python benchmarks/unwrap_speed.py [--repeat 5] [--skylibs PYTHON]

Ours is the whole way from a merged radiance image with its variance and mask: places on the ball, unwrapping by area, masks,
noise, sampling density, and the weights of the `paper` method with the ball's reflectance at every incidence angle. Beside it
a bare `cv2.remap` of the same image through the same places, and, where a Python is named in which skylibs is installed
(`pip install skylibs`, in an environment of its own), its `convertTo('latlong')`. All in memory, alternating, the best of
the repetitions; memory is the peak of what numpy and OpenCV's results take during our run,
over the size of the result.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from spectral_probe.geometry.frames import camera_to_world
from spectral_probe.geometry.panorama import Unwrapping
from spectral_probe.model import BallFit, Camera, RadianceImage
from spectral_probe.parallel import in_parallel, row_blocks
from spectral_probe.spectra.camera import camera_sensitivities
from spectral_probe.spectra.incidence import incidence_cosines
from spectral_probe.spectra.metals import ball_reflectance
from spectral_probe.spectra.recovery import spectral_recovery

RADIUS_PX, DISTANCE, WIDTH = 1020.0, 10.0, 4096
SIZE_PX = 2048
SKYLIBS = """
import sys, time, numpy as np
from envmap import EnvironmentMap
picture = np.random.default_rng(0).random((2048, 2048, 3)).astype(np.float32)
best = float("inf")
for _ in range(int(sys.argv[1])):
    ball = EnvironmentMap(picture.copy(), "sphere")
    start = time.perf_counter()
    ball.convertTo("latlong", 2048)
    best = min(best, time.perf_counter() - start)
print(best)
"""


def seconds(work: Callable[[], object]) -> float:
    """Wall time of one run."""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def main() -> None:
    """Print the times, their ratios and the memory."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--skylibs", metavar="PYTHON", help="a Python in which skylibs is installed")
    arguments = parser.parse_args()
    focal_px = RADIUS_PX * np.sqrt(DISTANCE**2 - 1)
    camera = Camera((focal_px, focal_px), (SIZE_PX / 2, SIZE_PX / 2), (SIZE_PX, SIZE_PX))
    ball = BallFit(np.array([0.0, 0.0, 0.05 * DISTANCE]), 0.05, float(np.arcsin(1 / DISTANCE)), 0.0)
    radiance = np.random.default_rng(0).random((SIZE_PX, SIZE_PX, 3)).astype(np.float32)
    image = RadianceImage(radiance, radiance * np.float32(1e-4), np.ones((SIZE_PX, SIZE_PX), bool))
    rotation = camera_to_world(20.0, 5.0)
    recovery = spectral_recovery(
        camera_sensitivities("Nikon 5100 (NPL)"), ["incandescent", "daylight"], "paper"
    )
    correction = recovery.incidence_correction(ball_reflectance("SUS304", incidence_cosines()))
    finder = Unwrapping.of(image, camera, ball, rotation, WIDTH).finder
    column, row, *_ = finder.places(slice(0, WIDTH // 2))

    def ours() -> np.ndarray:
        weights = np.empty((WIDTH // 2, WIDTH, 3), np.float32)
        unwrapping = Unwrapping.of(image, camera, ball, rotation, WIDTH)

        def fill(rows: slice) -> None:
            view = unwrapping.rows(rows)
            responses = correction.light_responses(view.responses, view.cos_incidence)
            variance = correction.light_variance(view.variance, view.cos_incidence)
            weights[rows] = recovery.recover(responses, variance).weights

        in_parallel(fill, row_blocks(WIDTH))
        return weights

    tracemalloc.start()
    size = ours().nbytes
    peak = tracemalloc.get_traced_memory()[1] / size
    tracemalloc.stop()
    times = {"spectral weights": [], "cv2.remap": []}
    for _ in range(arguments.repeat):
        times["spectral weights"].append(seconds(ours))
        times["cv2.remap"].append(seconds(lambda: cv2.remap(radiance, column, row, cv2.INTER_LINEAR)))
    if arguments.skylibs:
        command = [arguments.skylibs, "-c", SKYLIBS, str(arguments.repeat)]
        told = subprocess.run(command, check=True, capture_output=True, text=True)  # noqa: S603 (the user's own Python)
        times["skylibs convertTo"] = [float(told.stdout)]
    best = {name: min(taken) for name, taken in times.items()}
    for name, taken in best.items():
        sys.stdout.write(f"{name:20s} {taken:7.3f} s   {taken / best['spectral weights']:6.2f} of ours\n")
    sys.stdout.write(
        f"ours over cv2.remap: {best['spectral weights'] / best['cv2.remap']:.1f}; "
        f"peak memory {peak:.1f} times the result; {cv2.getNumThreads()} threads\n"
    )


if __name__ == "__main__":
    main()

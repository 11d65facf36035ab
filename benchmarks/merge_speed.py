"""Time of merging five 6-megapixel photographs, beside OpenCV's MergeDebevec of the same five pictures.

    python benchmarks/merge_speed.py [--repeat 3]

Everything is in memory, files are neither read nor written. OpenCV gets the five 8-bit pictures, their times and a
response of 256 values per channel, and returns radiance. Ours gets the same pictures as `read_photograph` returns them
(float32, decoded), their exposures and an estimated response, and returns radiance, its variance and the mask of valid
pixels; "linear" is the same for camera raw, with the sensor's noise model. The search for moved areas, which OpenCV does
not make, is timed by itself. Each time is the best of the repetitions; the memory is the peak of what numpy allocates on
top of the pictures (what OpenCV holds inside is not seen).
"""

from __future__ import annotations

import argparse
import sys
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from spectral_probe.model import Exposure, Photograph
from spectral_probe.photo.merge import merge
from spectral_probe.photo.moved import moved_areas
from spectral_probe.photo.read import SRGB_CLIP_CODE, srgb_to_linear
from spectral_probe.photo.response import KNOTS, ResponseCurve

SIZE = 2000, 3000
TIMES_S = (1 / 1000, 1 / 250, 1 / 60, 1 / 15, 1 / 4)


def pictures() -> list[np.ndarray]:
    """Five exposures of one smooth scene over some twelve EV, 8 bits, with noise of one code."""
    random = np.random.default_rng(0)
    detail = cv2.GaussianBlur(random.normal(size=(*SIZE, 3)).astype(np.float32), (0, 0), 20)
    radiance = np.exp(detail * 60)
    taken = []
    for time_s in TIMES_S:
        codes = 255 * np.clip(radiance * np.float32(3 * time_s), 0, 1) ** np.float32(1 / 2.2)
        taken.append(np.clip(codes + random.normal(0, 1, codes.shape), 0, 255).astype(np.uint8))
    return taken


def measured(work: Callable[[], object], repeat: int) -> tuple[float, float]:
    """Best wall time in seconds, and the peak of numpy's memory on top of what there was, in MB."""
    best = float("inf")
    for _ in range(repeat):
        start = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - start)
    tracemalloc.start()
    work()
    peak = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    return best, peak


def main() -> None:
    """Print both times and their ratio."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeat", type=int, default=3)
    repeat = parser.parse_args().repeat
    codes = pictures()
    decode = srgb_to_linear(np.arange(256) / 255.0).astype(np.float32)
    exposures = [Exposure(time_s) for time_s in TIMES_S]
    display = [
        Photograph(Path(f"{n}.jpg"), decode[one], one.max(-1) >= SRGB_CLIP_CODE, display_referred=True)
        for n, one in enumerate(codes)
    ]
    linear = [Photograph(one.path, one.pixels, one.clipped) for one in display]
    response = ResponseCurve(np.zeros((3, len(KNOTS))), (0.05, 0.05, 0.05), ())
    times = np.array(TIMES_S, np.float32)
    table = np.repeat(np.maximum(decode, 1e-4)[:, None, None], 3, axis=2)
    debevec = cv2.createMergeDebevec()
    everywhere = np.ones(SIZE, bool)
    rows = {
        "OpenCV MergeDebevec, 8 bits": lambda: debevec.process(codes, times, table),
        "merge, display-referred": lambda: merge(display, exposures, response),
        "merge, linear": lambda: merge(linear, exposures),
        "search for moved areas": lambda: moved_areas(display, exposures, everywhere, response),
    }
    results = {name: measured(work, repeat) for name, work in rows.items()}
    reference = results["OpenCV MergeDebevec, 8 bits"][0]
    write = sys.stdout.write
    write(f"{len(codes)} photographs of {SIZE[1]} x {SIZE[0]}; {cv2.getNumThreads()} threads\n")
    for name, (seconds, peak) in results.items():
        write(f"{name:30s} {seconds:6.3f} s   {reference / seconds:5.2f} x   peak {peak:5.0f} MB\n")


if __name__ == "__main__":
    main()

"""Make the sample capture of the gym again: photographs, truth and plate.

Run it in the project's environment: ``python sample_scenes/gym/build.py``. It takes about 20 minutes of processor time,
10 on two free cores. ``--renders FOLDER`` keeps the renders, so that a second run starts from them; ``--expand FOLDER``
only writes the truth in full (truth.npz, case.json) for scoring a probe; ``--previews FOLDER`` writes PNGs to look at.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from builder import truth

HERE = Path(__file__).resolve().parent
VIEW_SAMPLES, PLATE_SAMPLES, PANORAMA_SAMPLES = 16, 8, 256
NOISE_SEED = 20040614
XYZ_TO_SRGB = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])
D65_XYZ = np.array([0.9505, 1.0, 1.0891])


def tell(text: str) -> None:
    """One line of progress."""
    sys.stdout.write(f"{time.strftime('%H:%M:%S')} {text}\n")
    sys.stdout.flush()


def render_all(folder: Path) -> None:
    """Render whatever is not in `folder` yet: view0-2.npy, plate.npy, panorama.npy, layers (2, N, H, W) float32."""
    from builder import rendering

    def view(azimuth_deg: float) -> Any:
        return lambda gym: rendering.view_from(gym, azimuth_deg)

    jobs = [(f"view{i}", view(azimuth), VIEW_SAMPLES, True) for i, azimuth in enumerate(truth.AZIMUTHS_DEG)]
    jobs.append(("panorama", rendering.view_all_round, PANORAMA_SAMPLES, False))
    jobs.append(("plate", rendering.view_plate, PLATE_SAMPLES, True))
    jobs = [job for job in jobs if not (folder / f"{job[0]}.npy").exists()]
    if not jobs:
        return
    gym = rendering.build_scene()
    for name, aim, samples, denoise in jobs:
        aim(gym)
        layers = rendering.render_layers(
            gym, samples, lambda text, name=name: tell(f"{name}: {text}"), denoise=denoise
        )
        np.save(folder / f"{name}.npy", layers.astype(np.float32))


def take_photographs(renders: Path) -> None:
    """Expose the three views into DNG files."""
    from builder import photograph, spectra

    sensitivities = spectra.camera_sensitivities()
    layers = [photograph.restore_emitters(np.load(renders / f"view{i}.npy")) for i in range(3)]
    views = [photograph.layers_to_sensor(view, sensitivities) for view in layers]
    lamp = (spectra.ball_reflectance(np.array(0.7)) * spectra.lamp_radiance()) @ sensitivities * 5.0
    saturation = photograph.saturation_radiance(lamp)
    lights = [spectra.lamp_radiance(), spectra.window_radiance()]
    neutral = np.sum([light / spectra.luminance(light) for light in lights], axis=0) @ sensitivities
    random = np.random.default_rng(NOISE_SEED)
    for i, view in enumerate(views):
        for j, exposure_s in enumerate(photograph.EXPOSURES_S):
            mosaic = photograph.expose(view, float(exposure_s), saturation, random)
            photograph.write_dng(HERE / f"view{i}_{j}.dng", mosaic, exposure_s, neutral / neutral[1])
            clipped = float((mosaic >= photograph.WHITE_LEVEL).mean())
            tell(
                f"view{i}_{j}.dng: {Fraction(exposure_s)} s, {clipped:.1%} clipped, median level {np.median(mosaic):.0f}"
            )


def developed(layers: Any, exposure: float | None = None) -> Any:
    """(H, W, 3) uint8 sRGB of layers (2, N, H, W), balanced to the mean of lamp and window."""
    from builder import photograph, spectra

    functions = spectra.colour_matching_functions()
    light = [spectra.lamp_radiance(), spectra.window_radiance()]
    white = np.mean([radiance @ functions / (radiance @ functions[:, 1]) for radiance in light], axis=0)
    xyz = photograph.layers_to_sensor(layers, functions)
    scale = exposure if exposure is not None else 0.42 / np.median(xyz[..., 1])
    linear = np.clip((xyz / white * D65_XYZ) @ XYZ_TO_SRGB.T * scale, 0.0, None)
    linear = np.clip(linear * (1.0 + linear / 16.0) / (1.0 + 0.35 * linear), 0.0, 1.0)
    coded = np.where(linear < 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.rint(coded * 255.0).astype(np.uint8)


def write_pictures(renders: Path, previews: Path | None) -> None:
    """The plate as JPEG and, where asked for, PNGs of everything."""
    from PIL import Image

    Image.fromarray(developed(np.load(renders / "plate.npy"))).save(HERE / "plate.jpg", quality=88)
    if previews is not None:
        previews.mkdir(parents=True, exist_ok=True)
        for path in sorted(renders.glob("*.npy")):
            Image.fromarray(developed(np.load(path))).save(previews / f"{path.stem}.png")


def build(renders: Path, previews: Path | None) -> None:
    """Render, photograph, and write the truth."""
    from builder import photograph

    started = time.perf_counter()
    render_all(renders)
    tell(f"rendered in {time.perf_counter() - started:.0f} s")
    take_photographs(renders)
    write_pictures(renders, previews)
    error = truth.write_truth(HERE / "truth", photograph.layers_to_spectra(np.load(renders / "panorama.npy")))
    tell(f"truth written; the stored panorama's largest relative error is {error:.2%}")


def main() -> None:
    """Read the options and build."""
    options = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    options.add_argument(
        "--renders", type=Path, help="keep the renders here and start from those already there"
    )
    options.add_argument("--previews", type=Path, help="write PNGs here")
    options.add_argument(
        "--expand", type=Path, metavar="FOLDER", help="only write truth.npz and case.json for scoring"
    )
    chosen = options.parse_args()
    if chosen.expand is not None:
        truth.write_for_scoring(HERE / "truth", chosen.expand)
        return
    if chosen.renders is not None:
        chosen.renders.mkdir(parents=True, exist_ok=True)
        build(chosen.renders, chosen.previews)
        return
    with tempfile.TemporaryDirectory() as folder:
        build(Path(folder), chosen.previews)


if __name__ == "__main__":
    main()

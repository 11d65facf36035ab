"""The main job on the bundled sample: photographs of a ball in a gym to a spectral render of gold, silver and copper."""

import json
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ..spectral_probe.model import Job, Progress, SpectralPanorama, part

type Numbers = dict[str, Any]

_WIDTH = 1024
_SIZE_PX = (540, 360)
_SAMPLES = 48
_BLUR_PX = 3.0
_BEARING_DEG = 18.0  # towards the windows


def demo(directory: Path) -> Job[Numbers]:
    """Recover the sample's light, render metals in it behind stained glass, compare with RGB, and put them into the plate.

    Leaves in the folder: probe/ (the panorama), spectra/ (a lamp and a window against the truth), stained/ (the panorama with
    red, yellow and green glass before its windows), render/ (the spectral image in it, and its RGB twin), plate/ (the metals in
    the gym's own light, rendered for the plate), composite/ (in the plate), comparison/ (dE2000 map, xy diagram, numbers), and
    sheet.png with all of it.
    """
    from ..spectral_probe.files.lock import folder_lock

    with folder_lock(directory):
        return (yield from _demo(directory))


def _demo(directory: Path) -> Job[Numbers]:
    from ..spectral_probe.commands import probe
    from ..spectral_probe.files.probe_exr import read_probe
    from ..spectral_probe.sample import GYM, gym_truth, stained_gym
    from .demo_plate import compose_metals

    truth = gym_truth()
    recovered = yield from part(probe(GYM / "capture.toml", directory / "probe", _WIDTH), 0.0, 0.2)
    panorama = read_probe(directory / "probe" / "probe.exr")
    spectra = yield from part(_spectra(directory, truth), 0.2, 0.25)
    yield Progress(0.25, "Stained glass before the windows")
    stained = stained_gym(panorama)
    _write_light(directory / "stained", stained)
    rendered, masks = yield from part(_render(directory / "render", stained), 0.27, 0.6)
    composed = yield from part(compose_metals(directory, panorama), 0.6, 0.95)
    comparing = _compare(directory, stained, spectra, rendered, masks)
    compared = yield from part(comparing, 0.95, 1.0)
    return {
        "blind fraction": recovered["blind_fraction"],
        **{f"{name}, GFC against the truth": numbers["gfc"] for name, numbers in spectra.items()},
        **{f"{name}, relative RMSE": numbers["relative_rmse"] for name, numbers in spectra.items()},
        "spectral render, seconds": rendered["seconds"]["spectral"],
        "RGB render, seconds": rendered["seconds"]["rgb"],
        "passes": rendered["passes"],
        "colour difference": compared,
        "share of the plate changed": composed["changed_fraction"],
        "written": str(directory),
    }


def _write_light(directory: Path, light: SpectralPanorama) -> None:
    from ..spectral_probe.figures.panorama import panorama_preview, write_png
    from ..spectral_probe.files.probe_exr import write_probe

    directory.mkdir(parents=True, exist_ok=True)
    write_probe(directory / "probe.exr", light)
    write_png(directory / "preview.png", panorama_preview(light))


def _spectra(directory: Path, truth: dict[str, Any]) -> Job[dict[str, Numbers]]:
    """The spectrum of one lamp and one window beside the true one (figs. 10 and 11)."""
    from ..spectral_probe.sample import GYM
    from ..spectral_probe.spectrum_command import spectrum

    found: dict[str, Numbers] = {}
    for index, name in enumerate(("lamp", "window")):
        light = truth["recommended"][name]
        at = (light["bearing_deg"], light["elevation_deg"])
        measured = GYM / "truth" / f"{name}.csv"
        job = spectrum(directory / "probe" / "probe.exr", at, measured, directory / "spectra", 0.5)
        found[name] = yield from part(job, index / 2, (index + 1) / 2)
    return found


def _render(directory: Path, panorama: SpectralPanorama) -> Job[tuple[Numbers, dict[str, Any]]]:
    """Gold pedestal, silver ball and copper ball in the recovered light, spectrally and in RGB (fig. 12)."""
    from ..spectral_probe.composite_model import OBJECTS_NAME
    from ..spectral_probe.files.objects_exr import read_objects
    from .bridge.cycles import spectral_render
    from .bridge.objects import demo_scene
    from .bridge.saving import save_scene

    yield Progress(0.0, "Setting up the scene")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    demo_scene(scene, _BEARING_DEG)
    scene.render.resolution_x, scene.render.resolution_y = _SIZE_PX
    objects = [thing for thing in scene.objects if thing.type == "MESH" and _is_metal(thing)]
    yield from part(spectral_render(scene, panorama, None, directory, samples=_SAMPLES), 0.02, 0.98)
    shares = read_objects(directory / OBJECTS_NAME).objects
    masks = {thing.name: shares[thing.name] > 0.5 for thing in objects}
    save_scene(directory / "demo.blend", copy=True)
    return json.loads((directory / "report.json").read_text("utf-8")), masks


def _is_metal(thing: bpy.types.Object) -> bool:
    return any(
        slot.material is not None and slot.material.spectral_probe.kind == "METAL"
        for slot in thing.material_slots
    )


def _compare(
    directory: Path,
    panorama: SpectralPanorama,
    spectra: dict[str, Numbers],
    rendered: Numbers,
    masks: dict[str, Any],
) -> Job[Numbers]:
    from ..spectral_probe.commands import read_xyz
    from ..spectral_probe.compare_command import DEFAULT_METALS, draw_comparison
    from ..spectral_probe.figures.display import read_png
    from ..spectral_probe.figures.panorama import panorama_preview
    from ..spectral_probe.figures.sheet import SheetContent
    from ..spectral_probe.files.atomic import written_together
    from ..spectral_probe.light_choice import mean_light
    from ..spectral_probe.render.compare import compare_images, write_comparison
    from ..spectral_probe.render.rgb_ways import compare_rgb_ways, metal_reflectances, ways_report
    from ..spectral_probe.sample import GYM
    from ..spectral_probe.spectra.colorimetry import panorama_xyz

    spectral, rgb = read_xyz(directory / "render" / "xyz.exr"), read_xyz(directory / "render" / "rgb.exr")
    # White by the metals: the windows behind them are far brighter, and would leave them dark.
    metals = np.logical_or.reduce(list(masks.values()))
    white = float(np.percentile(spectral[metals, 1], 95))
    comparison = compare_images(spectral, rgb, white_luminance=white, object_masks=masks, blur_px=_BLUR_PX)
    light = mean_light(panorama)
    ways = compare_rgb_ways(metal_reflectances(DEFAULT_METALS), light, "the mean light")
    content = SheetContent(
        comparison,
        spectral,
        rgb,
        ways,
        title="Gold, silver and copper under stained glass",
        subtitle="Light of a gym, recovered from photographs of a mirrored ball, behind red, yellow and green glass; "
        "rendered by Cycles spectrally and in RGB",
        panorama=panorama_preview(panorama),
        spectra=[_plot(name, numbers) for name, numbers in spectra.items()],
        adapted_white=panorama_xyz(panorama).mean((0, 1)),
        composed=(read_png(GYM / "plate.jpg"), read_png(directory / "composite" / "composite.png")),
        numbers={
            "spectral render": f"{rendered['seconds']['spectral']:.1f} s, {rendered['passes']} passes",
            "RGB render": f"{rendered['seconds']['rgb']:.1f} s",
            "in photograph": f"{_seconds(directory / 'plate'):.1f} s, {_seconds(directory / 'plate' / 'without'):.1f} s without",
            "samples": str(rendered["samples"]),
        },
    )
    folder = directory / "comparison"
    with written_together(folder, last="compare.json") as staging:
        write_comparison(staging / "compare.json", comparison, {"rgb_ways": ways_report(ways)})
        yield from draw_comparison(staging, content)
    for suffix in (".png", ".svg"):
        (folder / f"sheet{suffix}").replace(directory / f"sheet{suffix}")
    return {
        region.name: {"mean dE2000": region.differences.mean, "p95 dE2000": region.differences.p95}
        for region in (comparison.image, *comparison.objects)
    }


def _seconds(directory: Path) -> float:
    """Of the spectral render in a folder."""
    return float(json.loads((directory / "report.json").read_text("utf-8"))["seconds"]["spectral"])


def _plot(name: str, numbers: Numbers) -> Any:
    from ..spectral_probe.figures.spectrum import SpectrumPlot

    table = np.genfromtxt(numbers["csv"], delimiter=",", names=True)
    return SpectrumPlot(
        "Lamp" if name == "lamp" else "Window, without the glass",
        table["wavelength_nm"],
        table["radiance"],
        table["measured"],
        np.stack([table["lower_95"], table["upper_95"]]),
        bearing_deg=(numbers["azimuth_deg"], numbers["elevation_deg"]),
        measured_label="true",
        band_label="95 % band",
    )

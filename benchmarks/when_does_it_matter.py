"""Three metals and the ColorChecker under eight families of lamps: how far an RGB render is from the spectral one.

Balls of gold, silver and copper and the 24 patches (Ohta's reflectances), in light of one spectrum from everywhere, brighter
from above; rendered by Cycles spectrally and in RGB, whose materials and lights are what an artist would choose: their colours
under D65, and the lamp's own colour. Usage, from the repository:

    .venv/bin/python benchmarks/when_does_it_matter.py [-o out/] [--samples 32] [--docs]

Prints the table, and writes when_it_matters.json, .md (the table) and .png; `--docs` puts table and figure into docs/.
dE2000 is between mean colours of an object, relative to the lamp's own white. Beside the two lamps rendered of every family
stand means over all its lamps, computed for one reflection at normal incidence.
"""

import argparse
import json
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from extension import ROOT, core, load_extension

LAMPS: Mapping[str, tuple[str, ...]] = {
    "daylight": ("D65", "D50"),
    "incandescent": ("A", "Planck 2000 K"),
    "fluorescent-broadband": ("FL8", "FL3.13"),
    "fluorescent-triband": ("FL11", "FL12"),
    "fluorescent-halophosphate": ("FL2", "F34T12WW/RS/EW (Warm White FL)"),
    "led-phosphor": ("LED-B3", "LED-B1"),
    "led-rgb": ("LED-RGB1", "3-LED-1 (457/540/605)"),
    "discharge": ("HP5", "HP1"),
}
"""Two lamps of each family: a usual one and one that is farther from daylight."""

METALS: Mapping[str, str] = {"gold": "Au", "silver": "Ag", "copper": "Cu"}
CHART = "ColorChecker N Ohta"
DOCS_TABLE = ("<!-- table: benchmarks/when_does_it_matter.py -->", "<!-- end of table -->")
_PATCH, _PITCH = 0.88, 1.0  # side of a patch, and from one to the next
_WHITE_PATCH = "white 9.5 (.05 D)"

type Array = np.ndarray[Any, Any]


@dataclass(frozen=True)
class UnderLamp:
    """One lamp's result.

    `delta_e` is dE2000 by object, `xyz_spectral` and `xyz_rgb` mean tristimulus values by object relative to the lamp's white.
    """

    family: str
    lamp: str
    white_xy: tuple[float, float]
    passes: int
    seconds_spectral: float
    seconds_rgb: float
    delta_e: Mapping[str, float]
    xyz_spectral: Mapping[str, list[float]]
    xyz_rgb: Mapping[str, list[float]]

    @property
    def patches(self) -> dict[str, float]:
        """The patches of the chart alone."""
        return {name: value for name, value in self.delta_e.items() if name not in METALS}

    @property
    def worst_patch(self) -> str:
        """The patch that differs most."""
        return max(self.patches, key=lambda name: self.patches[name])

    @property
    def chart_mean(self) -> float:
        """Mean over the patches."""
        return float(np.mean(list(self.patches.values())))


# ---------------------------------------------------------------- scene and light


def patch_names() -> list[str]:
    """The 24 patches in their order."""
    catalogue = core("spectral_probe.spectra.catalogue").catalogue
    names = [
        entry.name.partition(": ")[2] for entry in catalogue("reflectance") if entry.name.startswith(CHART)
    ]
    return names[:24]


def build_scene(size: Sequence[int]) -> bpy.types.Scene:
    """Three balls above the chart, seen straight from the front, in an empty file."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.cycles.use_denoising = False
    metal_material = core("operators.bridge.objects").metal_material
    for index, (name, symbol) in enumerate(METALS.items()):
        bpy.ops.mesh.primitive_uv_sphere_add(
            segments=64, ring_count=32, radius=0.85, location=((index - 1) * 2.0, 0.0, 3.0)
        )
        bpy.ops.object.shade_smooth()
        bpy.context.object.name = name
        bpy.context.object.data.materials.append(metal_material(name, symbol, roughness=0.2))
    for index, name in enumerate(patch_names()):
        row, column = divmod(index, 6)
        _card(name, ((column - 2.5) * _PITCH, 0.0, 1.5 - row * _PITCH))
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 6.2
    camera.location, camera.rotation_euler = (0.0, -10.0, 1.0), (math.pi / 2, 0.0, 0.0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    return scene


def _card(name: str, middle: tuple[float, float, float]) -> None:
    """A square with a patch's reflectance, facing the camera."""
    x, y, z, half = *middle, _PATCH / 2
    mesh = bpy.data.meshes.new(name)
    corners = [
        (x - half, y, z - half),
        (x + half, y, z - half),
        (x + half, y, z + half),
        (x - half, y, z + half),
    ]
    mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
    material = bpy.data.materials.new(name)
    tree = material.node_tree
    tree.nodes.clear()
    shader, output = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    material.spectral_probe.kind = "REFLECTANCE"
    material.spectral_probe.reflectance_path = f"{CHART}: {name}"
    mesh.materials.append(material)
    bpy.context.scene.collection.objects.link(bpy.data.objects.new(name, mesh))


def panorama(spectrum: Array, height: int = 32) -> Any:
    """Light of one spectrum from everywhere, three times as bright from above as from below."""
    elevation = np.pi * (0.5 - (np.arange(height) + 0.5) / height)
    weights = np.repeat((1.0 + 0.5 * np.sin(elevation))[:, None, None], 2 * height, axis=1)
    return core("spectral_probe.model").SpectralPanorama(
        weights=weights.astype(np.float32),
        bases=np.asarray(spectrum, float)[None, None],
        basis_index=np.zeros((height, 2 * height), np.uint8),
        wavelengths_nm=np.arange(400.0, 701.0, 5.0),
        valid=np.ones((height, 2 * height), bool),
        confidence=np.ones((height, 2 * height), np.float32),
    )


# ---------------------------------------------------------------- measurement


def under_lamp(scene: bpy.types.Scene, family: str, lamp: str, folder: Path, samples: int) -> UnderLamp:
    """Render the scene under a lamp, spectrally and in RGB, and compare the objects' mean colours."""
    cycles, colorimetry = core("operators.bridge.cycles"), core("spectral_probe.spectra.colorimetry")
    read_rgb = core("spectral_probe.files.image_exr").read_rgb
    spectrum = core("spectral_probe.spectra.library").lamp_spectrum(lamp)
    spectrum = spectrum / colorimetry.spectra_to_xyz(spectrum)[1]
    white = colorimetry.spectra_to_xyz(spectrum)
    job = cycles.spectral_render(scene, panorama(spectrum), None, folder, samples=samples)
    result = core("spectral_probe.model").finish(job)
    found = core("spectral_probe.files.objects_exr").read_objects(folder / "objects.exr").objects
    images = {
        "spectral": read_rgb(result.xyz, ("X", "Y", "Z")),
        "rgb": colorimetry.rec709_to_xyz(read_rgb(result.rgb)),
    }
    means = {
        kind: {name: image[covered > 0.99].mean(0, dtype=float) for name, covered in found.items()}
        for kind, image in images.items()
    }
    reflectances = reflectances_by_name()
    level = (
        means["spectral"][_WHITE_PATCH][1]
        / colorimetry.spectra_to_xyz(reflectances[_WHITE_PATCH] * spectrum)[1]
    )
    relative = {kind: {name: xyz / level for name, xyz in by_name.items()} for kind, by_name in means.items()}
    differences = {
        name: float(colorimetry.delta_e_2000(relative["spectral"][name], relative["rgb"][name], white))
        for name in reflectances
    }
    xy = colorimetry.chromaticity(white)
    return UnderLamp(
        family,
        lamp,
        (float(xy[0]), float(xy[1])),
        result.plan.passes,
        result.seconds_spectral,
        result.seconds_rgb,
        differences,
        *({name: relative[kind][name].tolist() for name in reflectances} for kind in ("spectral", "rgb")),
    )


def reflectances_by_name() -> dict[str, Array]:
    """Reflectances (61,) of metals, at normal incidence, and patches."""
    metals = core("spectral_probe.spectra.metals").metal_reflectance
    charts = core("spectral_probe.spectra.library").surface_reflectances()
    return {name: metals(symbol, np.array(1.0)) for name, symbol in METALS.items()} | dict(
        zip(patch_names(), charts, strict=True)
    )


def computed(family: str) -> tuple[int, float, float]:
    """Number of lamps of a family, and mean dE2000 over them of the metals and of the chart, for one reflection."""
    colorimetry, library = core("spectral_probe.spectra.colorimetry"), core("spectral_probe.spectra.library")
    under_d65 = core("operators.bridge.rgb_twin").under_d65
    reflectances = np.stack(list(reflectances_by_name().values()))
    base_colours = np.clip(under_d65(reflectances), 0.0, 1.0)
    lights = library.training_lights([family])
    differences = []
    for light in lights:
        white = colorimetry.spectra_to_xyz(light)
        rgb = np.maximum(colorimetry.xyz_to_rec709(white), 0.0) * base_colours
        spectral = colorimetry.spectra_to_xyz(reflectances * light)
        differences.append(colorimetry.delta_e_2000(spectral, colorimetry.rec709_to_xyz(rgb), white))
    mean = np.mean(differences, axis=0)
    return len(lights), float(mean[: len(METALS)].mean()), float(mean[len(METALS) :].mean())


# ---------------------------------------------------------------- table and figure


def table(results: Sequence[UnderLamp]) -> str:
    """The results as a table in Markdown."""
    head = "| Family | Lamp | gold | silver | copper | 24 patches, mean | worst patch | all lamps: metals | patches |"
    lines = [head, "|---|---|---|---|---|---|---|---|---|"]
    told: set[str] = set()
    for result in results:
        count, metals, patches = computed(result.family)
        first = result.family not in told
        told.add(result.family)
        worst = result.worst_patch
        lines.append(
            f"| {result.family if first else ''} | {short(result.lamp)} | "
            + " | ".join(f"{result.delta_e[name]:.1f}" for name in METALS)
            + f" | {result.chart_mean:.1f} | {result.delta_e[worst]:.1f} {worst.partition(' (')[0]} | "
            + (f"{metals:.1f} ({count} lamps) | {patches:.1f} |" if first else " | |")
        )
    return "\n".join(lines) + "\n"


def short(lamp: str) -> str:
    """A lamp's name without its catalogue number."""
    return "Warm White FL" if "Warm White" in lamp else lamp


def figure(results: Sequence[UnderLamp]) -> Any:
    """Every object's two colours under every lamp, white-balanced to it, and the differences beside them."""
    style = core("spectral_probe.figures.style")
    with style.house_style():
        made = style.new_figure(12.0, 1.5 + 0.36 * len(results))
        height_in = 0.36 * len(results)
        made.text(
            0.04,
            1 - 0.32 / (1.5 + height_in),
            "When does spectral rendering matter?",
            fontsize=13,
            fontweight="bold",
        )
        made.text(
            0.04,
            1 - 0.56 / (1.5 + height_in),
            "Upper half: spectral render. Lower half: Cycles RGB. White-balanced to each lamp.",
            color=style.SOFT_INK,
        )
        _draw_swatches(style.axes_at(made, 2.95, 0.95, 5.3, height_in), results)
        _draw_differences(style.axes_at(made, 8.5, 0.95, 3.1, height_in), results)
    return made


def _draw_swatches(axes: Any, results: Sequence[UnderLamp]) -> None:
    """One row a lamp, one column an object: the spectral colour above the RGB colour."""
    colorimetry, display = core("spectral_probe.spectra.colorimetry"), core("spectral_probe.figures.display")
    style = core("spectral_probe.figures.style")
    names = list(results[0].delta_e)
    rows = np.full((len(results) * 12, len(names) * 12, 3), 255, np.uint8)
    for row, result in enumerate(results):
        x, y = result.white_xy
        white = np.array([x / y, 1.0, (1 - x - y) / y])
        for column, name in enumerate(names):
            pair = np.array([result.xyz_spectral[name], result.xyz_rgb[name]])
            shown = display.tone_map(colorimetry.adapted_to_d65(pair, white), 0.8)
            top, left = row * 12 + 1, column * 12 + 1 + 4 * (column >= len(METALS))
            rows[top : top + 5, left : left + 10] = shown[0]
            rows[top + 5 : top + 10, left : left + 10] = shown[1]
    axes.imshow(rows, aspect="auto", extent=(0, len(names), len(results), 0), interpolation="nearest")
    axes.set_yticks(np.arange(len(results)) + 0.5, [short(result.lamp) for result in results])
    axes.set_xticks([0.5, 1.5, 2.5, 15.2], ["Au", "Ag", "Cu", "the 24 patches of the ColorChecker"])
    axes.xaxis.tick_top()
    axes.tick_params(length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)
    for row, result in enumerate(results):
        if row == 0 or results[row - 1].family != result.family:
            axes.axhline(row, color=style.RULE, linewidth=0.6, xmin=-0.475, clip_on=False)
            axes.text(
                -0.47, 1 - (row + 0.5) / len(results), result.family.replace("fluorescent-", "fl. "),
                transform=axes.transAxes, va="center", fontweight="bold", fontsize=7.0,
            )  # fmt: skip


def _draw_differences(axes: Any, results: Sequence[UnderLamp]) -> None:
    """DE2000 of each metal and of the chart, mean and worst patch, on one logarithmic scale."""
    style = core("spectral_probe.figures.style")
    colours = {"gold": "#b8860b", "silver": "#7d8791", "copper": "#b4552d"}
    axes.set_xscale("log")
    axes.set_xlim(0.03, 60)
    axes.set_ylim(len(results), 0)
    for row, result in enumerate(results):
        y = row + 0.5
        patches = [max(value, 0.03) for value in result.patches.values()]
        axes.plot(
            [min(patches), max(patches)],
            [y, y],
            color=style.RULE,
            linewidth=4,
            solid_capstyle="round",
            zorder=1,
        )
        axes.plot(result.chart_mean, y, "|", color=style.INK, markersize=8, markeredgewidth=1.6, zorder=3)
        for name, colour in colours.items():
            axes.plot(max(result.delta_e[name], 0.03), y, "o", color=colour, markersize=5, zorder=2)
        if row and results[row - 1].family != result.family:
            axes.axhline(row, color=style.RULE, linewidth=0.6)
    for name, colour in colours.items():
        axes.plot([], [], "o", color=colour, markersize=5, label=name)
    axes.plot([], [], "|", color=style.INK, markersize=8, markeredgewidth=1.6, label="patches: mean, range")
    axes.axvline(1.0, color=style.SOFT_INK, linewidth=0.7, linestyle=(0, (3, 3)), zorder=0)
    axes.set_xticks([0.1, 1, 2, 5, 10, 20], ["0.1", "1", "2", "5", "10", "20"])
    axes.set_yticks([])
    axes.minorticks_off()
    axes.set_xlabel("ΔE₀₀, RGB against spectral (1: just seen side by side)")
    axes.legend(loc="lower left", bbox_to_anchor=(-0.03, 1.0), ncols=4, handletextpad=0.1, columnspacing=0.7)


def write_docs(text: str, picture: Path) -> None:
    """Put the table between its marks in docs/when_it_matters.md, and the figure beside it."""
    page = ROOT / "docs" / "when_it_matters.md"
    before, _, rest = page.read_text("utf-8").partition(DOCS_TABLE[0])
    _, _, after = rest.partition(DOCS_TABLE[1])
    page.write_text(f"{before}{DOCS_TABLE[0]}\n{text}{DOCS_TABLE[1]}{after}", encoding="utf-8")
    (ROOT / "docs" / picture.name).write_bytes(picture.read_bytes())


def main() -> None:
    """Run and print the results."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "out" / "when_it_matters")
    parser.add_argument("--size", type=int, nargs=2, default=(186, 192), metavar=("WIDTH", "HEIGHT"))
    parser.add_argument("--samples", type=int, default=32)
    parser.add_argument("--docs", action="store_true", help="put table and figure into docs/")
    options = parser.parse_args()
    load_extension()
    scene = build_scene(options.size)
    results = []
    for family, lamps in LAMPS.items():
        for lamp in lamps:
            folder = options.output / lamp.replace("/", "_").replace(" ", "_")
            results.append(under_lamp(scene, family, lamp, folder, options.samples))
            sys.stderr.write(f"{family}: {lamp}\n")
    told = {
        "rendered": [asdict(result) for result in results],
        "computed": {
            family: dict(zip(("lamps", "metals", "patches"), computed(family), strict=True))
            for family in LAMPS
        },
    }
    (options.output / "when_it_matters.json").write_text(json.dumps(told, indent=1) + "\n")
    text = table(results)
    (options.output / "when_it_matters.md").write_text(text, encoding="utf-8")
    picture = options.output / "when_it_matters.png"
    core("spectral_probe.figures.style").save_figure(figure(results), picture)
    if options.docs:
        write_docs(text, picture)
    sys.stdout.write(text)


if __name__ == "__main__":
    main()

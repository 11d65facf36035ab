"""Damaged files given to the operators in Blender: one sentence as its error report, and the scene as it was."""

import importlib
import importlib.util
import os
import shutil
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from random import Random
from types import ModuleType

import pytest

from tests.faults.mutations import mutations_of
from tests.faults.seeds import KINDS

pytestmark = pytest.mark.long

SEED = 20_27
SHARE = 8
"""Of the mutated inputs of the command line, one in so many is given to Blender, too."""

_resources = tempfile.TemporaryDirectory(prefix="spectral_probe_blender_")
if "bpy" not in sys.modules:
    os.environ["BLENDER_USER_RESOURCES"] = _resources.name

import bpy  # noqa: E402  (not before its folders are set)

NAME = "spectral_probe_extension"


@pytest.fixture(scope="module")
def fingerprint(project_root):
    """The extension registered; gives a scene's fingerprint and what data there is."""
    spec = importlib.util.spec_from_file_location(
        NAME, project_root / "__init__.py", submodule_search_locations=[str(project_root)]
    )
    sys.modules[NAME] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sys.modules[NAME])
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    sys.modules[NAME].register()
    of_scene = importlib.import_module(f"{NAME}.operators.bridge.fingerprint").scene_fingerprint

    def of_all():
        counts = {
            name: len(getattr(bpy.data, name))
            for name in ("images", "worlds", "objects", "materials", "texts")
        }
        settings = bpy.context.scene.spectral_probe
        lists = len(settings.views), len(settings.known_light.own_lights), settings.probe_directory
        return of_scene(bpy.context.scene), counts, lists

    yield of_all
    sys.modules[NAME].unregister()


def chosen(folder: Path, name: str) -> dict[str, object]:
    return {"directory": str(folder), "files": [{"name": name}]}


def light_world(folder: Path, _name: str) -> None:
    settings = bpy.context.scene.spectral_probe
    before, settings.probe_directory = settings.probe_directory, str(folder)
    try:
        bpy.ops.spectral_probe.light_world()
    finally:
        settings.probe_directory = before


PRESET = '[preset]\nkind = "render"\nformat = 1\n'

CASES: dict[str, tuple[str, str, Callable[[Path, str], object]]] = {
    "capture": ("capture", "", lambda f, n: bpy.ops.spectral_probe.import_capture(filepath=str(f / n))),
    "dropped capture": ("capture", "", lambda f, n: bpy.ops.spectral_probe.import_photographs(filepath=str(f / n))),
    "raw photograph": ("photograph .dng", "", lambda f, n: bpy.ops.spectral_probe.import_photographs(**chosen(f, n))),
    "photograph": ("photograph .jpg", "", lambda f, n: bpy.ops.spectral_probe.import_photographs(**chosen(f, n))),
    "TIFF": ("photograph .tif", "", lambda f, n: bpy.ops.spectral_probe.import_photographs(**chosen(f, n))),
    "EXR": ("photograph .exr", "", lambda f, n: bpy.ops.spectral_probe.import_photographs(**chosen(f, n))),
    "lamp": ("table", "", lambda f, n: bpy.ops.spectral_probe.add_own_light(**chosen(f, n))),
    "world": ("panorama", "world.exr", light_world),
    "preset": ("preset", "", lambda f, n: bpy.ops.spectral_probe.load_preset(filepath=str(f / n))),
}  # fmt: skip
"""Where the sound file comes from, what it is called, and what reads it."""


def sound(case: str, project_root: Path, folder: Path) -> Path:
    kind, name, _ = CASES[case]
    folder.mkdir()
    if kind == "preset":
        source = next((project_root / "presets").rglob("*.toml"))
        return Path(shutil.copy(source, folder / source.name))
    KINDS[kind].make(folder)
    target = next(path for path in sorted(folder.iterdir()) if path.name.startswith(KINDS[kind].target))
    return target.rename(folder / name) if name else target


def ours(name: str) -> ModuleType:
    return importlib.import_module(f"{NAME}.{name}")


def rendered(folder: Path) -> Path:
    """A finished frame of the start-up scene, 24 x 16 pixels, lit by a probe."""
    KINDS["probe.exr"].make(folder)
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.use_denoising = "CYCLES", False
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 24, 16, 100
    probe = ours("spectral_probe.files.probe_exr").read_probe(folder / "probe.exr")
    planning = ours("operators.bridge.planning")
    planner = planning.Planner(probe, planning.PlanRequest(passes=2), 4)
    render = ours("operators.bridge.cycles").spectral_render
    ours("spectral_probe.model").finish(
        render(scene, probe, None, folder / "render", samples=4, planner=planner)
    )
    return folder / "render"


@pytest.mark.usefixtures("fingerprint")
def test_damaged_frames_are_not_put_together(tmp_path, mutations):
    """Plan, index, manifests and passes of a finished frame; the pictures of an earlier time stay where it fails."""
    whole = rendered(tmp_path)
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    combine, finish = ours("operators.bridge.combining").combine, ours("spectral_probe.model").finish
    targets = [path for path in sorted((whole / "passes").iterdir()) if path.suffix in (".json", ".exr")]
    targets.append(whole / "plan.json")
    random, wrong, refused, count = Random(SEED), [], 0, max(20, mutations // SHARE)
    for number in range(count):
        folder = Path(shutil.copytree(whole, tmp_path / f"{number}"))
        path = folder / random.choice(targets).relative_to(whole)
        mutation = random.choice(mutations_of(path))
        path.write_bytes(mutation(random, path.read_bytes()))
        pictures = {each: each.read_bytes() for each in folder.glob("*.exr")}
        try:
            finish(combine(folder))
        except ours("spectral_probe.errors").SpectralProbeError as told:
            refused += 1
            spoiled = [each.name for each, content in pictures.items() if each.read_bytes() != content]
            if "\n" in str(told) or not str(told) or spoiled or list(folder.glob("**/.writing-*")):
                wrong.append((number, path.name, mutation.__name__, str(told)[:300], spoiled))
        shutil.rmtree(folder)
    assert not wrong
    assert refused > count // 4, "hardly anything was damaged enough to be refused"


def test_damaged_files_are_one_sentence_and_the_scene_stays(fingerprint, project_root, tmp_path, mutations):
    random = Random(SEED)
    seeds = {case: sound(case, project_root, tmp_path / case.replace(" ", "-")) for case in CASES}
    wrong, refused, count = [], 0, max(len(CASES), mutations // SHARE)
    for number in range(count):
        case = list(CASES)[number % len(CASES)]
        folder = tmp_path / f"{number}"
        shutil.copytree(seeds[case].parent, folder)
        path = folder / seeds[case].name
        mutation = random.choice(mutations_of(path))
        path.write_bytes(mutation(random, path.read_bytes()))
        before = fingerprint()
        try:
            CASES[case][2](folder, path.name)
        except RuntimeError as report:
            refused += 1
            text = str(report).removeprefix("Error: ").strip("\n")
            if "\n" in text or "Traceback" in text or not text:
                wrong.append((number, case, mutation.__name__, text[:300]))
            if fingerprint() != before:
                wrong.append((number, case, mutation.__name__, "the scene changed"))
        else:  # still sound
            bpy.ops.wm.read_homefile(use_factory_startup=True)
        shutil.rmtree(folder)
    assert not wrong
    assert refused > count // 4, "hardly anything was damaged enough to be refused"

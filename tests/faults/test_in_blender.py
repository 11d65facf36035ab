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

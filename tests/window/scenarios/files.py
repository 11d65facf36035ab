"""A file of the first version in a window: upgraded for good, what is missing told and found, the probe packed and unpacked."""

import importlib
import shutil
from pathlib import Path

import bpy

MODULE = "bl_ext.user_default.spectral_probe"


def write_probe(folder):
    """A probe of even daylight."""
    import numpy as np

    core = lambda name: importlib.import_module(f"{MODULE}.spectral_probe.{name}")  # noqa: E731  (short)
    whole = np.ones((16, 32), bool)
    panorama = core("model").SpectralPanorama(
        np.ones((16, 32, 1), np.float32),
        core("spectra.library").daylight(6500.0)[None, None],
        np.zeros((16, 32), np.uint8),
        core("spectra.grid").WAVELENGTHS_NM,
        whole,
        whole.astype(np.float32),
    )
    core("model").finish(core("editing")._write_light(panorama, folder))


def steps(ui):
    """Open, find, pack, lose, unpack."""
    work = Path(ui.words[1])
    shutil.copy(ui.words[0], work / "scene.blend")
    bpy.ops.wm.open_mainfile(filepath=str(work / "scene.blend"))
    yield 0.5
    settings = ui.scene.spectral_probe
    ui.results["method"] = settings.method
    ui.operator("spectral_probe.add_region_light")
    ui.operator("ed.undo")
    yield 0.2
    settings = ui.scene.spectral_probe
    ui.results["after undo"] = [settings.method, settings.version, len(settings.known_light.regions)]
    yield from ui.properties("WORLD")
    ui.open_panels()
    yield 0.5
    ui.shot("missing")
    ui.results["missing"] = len(bpy.context.window_manager.spectral_probe_files.missing.splitlines())
    ui.results["grey"] = not ui.polls("spectral_probe.build_probe")

    found = work / "archive" / "photos"
    found.mkdir(parents=True)
    for photo in settings.views[0].photos:
        (found / Path(photo.path).name).touch()
    (work / "archive" / "red.csv").touch()
    write_probe(work / "archive" / "room probe")
    (work / "archive" / "room render").mkdir()
    (work / "archive" / "room render" / "xyz.exr").touch()
    with ui.step("find"):
        ui.operator("spectral_probe.find_files")
        yield from ui.choose_folder(work / "archive")
        yield from ui.wait_job()
    ui.results["still missing"] = bpy.context.window_manager.spectral_probe_files.missing
    ui.results["found"] = [settings.views[0].photos[0].path, settings.probe_directory]

    ui.operator("spectral_probe.light_world", normalise=False)
    region = ui.region("VIEW_3D")
    yield from ui.move(region.x + region.width // 2, region.y + region.height // 2)
    ui.operator("spectral_probe.pack_probe")
    yield 0.5
    ui.shot("pack")
    ui.results["asked first"] = len(settings.packed.files) == 0
    yield from ui.key("RET")
    yield from ui.wait(lambda: settings.packed.files, 20, "the probe to be packed")
    ui.operator("wm.save_mainfile", "EXEC_DEFAULT")
    shutil.rmtree(work / "archive" / "room probe")
    bpy.ops.wm.open_mainfile(filepath=str(work / "scene.blend"))
    yield 0.5
    ui.shot("packed")
    ui.operator("spectral_probe.light_world", normalise=False)
    ui.results["folder made by itself"] = (work / "archive" / "room probe").exists()
    ui.operator("spectral_probe.unpack_probe")
    ui.results["unpacked"] = sorted(path.name for path in (work / "archive" / "room probe").iterdir())
    with ui.context():
        bpy.ops.wm.call_menu(name="TOPBAR_MT_file_external_data")
    yield 0.5
    ui.shot("menu")
    yield from ui.key("ESC")

    (work / "farm").mkdir()
    with ui.context("VIEW_3D"):
        bpy.ops.object.camera_add(location=(0.0, -8.0, 1.0), rotation=(1.5, 0.0, 0.0))
    ui.scene.camera = bpy.context.object
    ui.operator("spectral_probe.use_cycles")
    ui.operator("wm.save_mainfile", "EXEC_DEFAULT")
    with ui.step("farm"):
        ui.operator("spectral_probe.export_farm_job")
        yield from ui.choose_folder(work / "farm")
        yield from ui.wait_job()
    ui.results["farm"] = sorted(path.name for path in (work / "farm").iterdir())
    ui.redraw()
    ui.shot("farm")

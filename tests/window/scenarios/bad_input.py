"""What a user should not do while a job runs, and does: every case ends in one sentence, and leaves nothing behind."""

import importlib
from pathlib import Path

import bpy

EXTENSION = "bl_ext.user_default.spectral_probe"
TEMPORARY = ("materials", "worlds", "lights", "node_groups", "images", "scenes", "meshes", "objects")
NOT_OURS = {"Render Result", "Viewer Node"}


def module(name):
    return importlib.import_module(f"{EXTENSION}.{name}")


def steps(ui):
    """Play the cases named by the words after the capture and the folder; without any those of the test.

    At the end a job is left running: Blender is quit with it.
    """
    names = ui.words[2:] or LASTING
    for name in names:
        yield from fresh(ui)
        before = ui.reports()
        with ui.step(name):
            yield from CASES[name](ui)
            yield from ui.wait_job(120)
        yield 0.3
        after = ui.reports()
        told = after[len(before) :] if after[: len(before)] == before else after
        ui.results[name] = {"told": told, **ui.results.get(name, {})}
        ui.results[name]["left"] = left_behind(ui)
    yield from fresh(ui)
    yield from started(ui)
    ui.results["quit during"] = ui.job


def fresh(ui):
    """Blender's own new file, small, in Cycles."""
    with ui.context(None):
        bpy.ops.wm.read_homefile(use_empty=False, use_factory_startup=True)
    yield 0.3
    scene = ui.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = 96, 64
    scene.spectral_probe.samples = 64
    bpy.context.preferences.view.show_splash = False
    ui.state = state()


def state():
    """What must be the same after a job that was stopped."""
    return {
        "data": {kind: {each.name for each in getattr(bpy.data, kind)} - NOT_OURS for kind in TEMPORARY},
        "handlers": {
            name: [f"{one.__module__}.{one.__qualname__}" for one in getattr(bpy.app.handlers, name)]
            for name in dir(bpy.app.handlers)
            if isinstance(getattr(bpy.app.handlers, name), list)
        },
        "display": bpy.context.preferences.view.render_display_type,
        "lock": [scene.render.use_lock_interface for scene in bpy.data.scenes],
        "cycles": [(scene.cycles.samples, scene.render.use_persistent_data) for scene in bpy.data.scenes],
        "compositor": [str(scene.compositing_node_group) for scene in bpy.data.scenes],
        "modal": [
            one.bl_idname
            for window in bpy.context.window_manager.windows
            for one in window.modal_operators
            if one is not None  # whose class is gone: Blender drops it at the next event
        ],
    }


def left_behind(ui):
    """What is there that was not before."""
    after = state()
    found = {}
    for kind, names in after["data"].items():
        new = sorted(names - ui.state["data"][kind])
        if new:
            found[kind] = new
    for key in after:
        if key != "data" and after[key] != ui.state[key]:
            found[key] = (
                {k: v for k, v in after[key].items() if v != ui.state[key].get(k)}
                if key == "handlers"
                else after[key]
            )
    return found


# ---------------------------------------------------------------- jobs


def detect(ui):
    ui.operator("spectral_probe.import_capture", "EXEC_DEFAULT", filepath=ui.words[0])
    ui.operator("spectral_probe.detect_ball")
    yield 0.05


def build(ui):
    ui.operator("spectral_probe.import_capture", "EXEC_DEFAULT", filepath=ui.words[0])
    ui.scene.spectral_probe.probe_width = 64
    ui.scene.spectral_probe.probe_directory = str(Path(ui.words[1], "built"))
    ui.operator("spectral_probe.build_probe")
    yield 0.05


def started(ui):
    small_probe(ui)
    settings = ui.scene.spectral_probe
    folder = Path(ui.words[1], f"render_{len(list(Path(ui.words[1]).glob('render_*')))}")
    folder.mkdir()
    settings.render_directory, settings.plan, settings.passes = str(folder), "NUMBER", 3
    ui.passes = folder / "passes"
    ui.operator("spectral_probe.render_spectral")
    yield 0.0


def render(ui):
    """Between two passes, when the window answers."""
    yield from started(ui)
    yield from ui.wait(lambda: any(ui.passes.glob("*.exr")) or not ui.job, 60, "the first pass")
    while ui.job and bpy.app.is_job_running("RENDER"):
        yield 0.01


def rendering(ui):
    """Within a pass."""
    yield from started(ui)
    while ui.job and not bpy.app.is_job_running("RENDER"):
        yield 0.01
    yield 0.1


def small_probe(ui):
    """A probe of 32 x 16 lights the scene."""
    import numpy as np

    folder = Path(ui.words[1], "probe")
    if not (folder / "probe.exr").is_file():
        level = np.full((16, 32, 1), 0.05, np.float32)
        level[4:7, 13:19] = 1
        whole = np.ones((16, 32), bool)
        panorama = module("spectral_probe.model").SpectralPanorama(
            level,
            module("spectral_probe.spectra.library").daylight(6500.0)[None, None],
            np.zeros((16, 32), np.uint8),
            module("spectral_probe.spectra.grid").WAVELENGTHS_NM,
            whole,
            whole.astype(np.float32),
        )
        module("spectral_probe.model").finish(module("spectral_probe.editing")._write_light(panorama, folder))
    ui.scene.spectral_probe.probe_directory = str(folder)


# ---------------------------------------------------------------- what happens meanwhile


def remove_images(_ui):
    for image in list(bpy.data.images):
        if image.name not in NOT_OURS:
            bpy.data.images.remove(image)


def remove_world(_ui):
    for world in list(bpy.data.worlds):
        bpy.data.worlds.remove(world)


def remove_camera(ui):
    bpy.data.objects.remove(ui.scene.camera)


def remove_objects(_ui):
    for thing in list(bpy.data.objects):
        if thing.type != "CAMERA":
            bpy.data.objects.remove(thing)


def remove_materials(_ui):
    for material in list(bpy.data.materials):
        bpy.data.materials.remove(material)


def remove_scene(ui):
    old = ui.scene
    ui.window.scene = bpy.data.scenes.new("Other")
    bpy.data.scenes.remove(old)


def switch_scene(ui):
    ui.window.scene = bpy.data.scenes.new("Other")


def switch_workspace(ui):
    ui.window.workspace = bpy.data.workspaces["Shading"]


def change_layout(ui):
    with ui.context("VIEW_3D"):
        bpy.ops.screen.screen_full_area()


def split(ui):
    with ui.context("VIEW_3D"):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.5)


def undo(ui):
    with ui.context(None):
        if bpy.ops.ed.undo.poll():
            bpy.ops.ed.undo()


def second_job(ui):
    ui.results.setdefault("second", []).append(ui.error_of("spectral_probe.detect_ball"))
    ui.results["second"].append(ui.error_of("spectral_probe.import_photographs", filepath=ui.words[0]))


def clear_views(ui):
    ui.scene.spectral_probe.views.clear()


def other_file(ui):
    with ui.context(None):
        bpy.ops.wm.read_homefile(use_empty=False, use_factory_startup=True)


def save(ui):
    path = str(Path(ui.words[1], "saved.blend"))
    ui.operator("wm.save_as_mainfile", "EXEC_DEFAULT", at=None, filepath=path, copy=True)
    with bpy.data.libraries.load(path) as (there, _):
        ui.results["saved"] = {
            kind: list(getattr(there, kind)) for kind in ("materials", "worlds", "node_groups")
        }


def disable(ui):
    with ui.context(None):
        bpy.ops.preferences.addon_disable(module=EXTENSION)


ACTIONS = (
    remove_images, remove_world, remove_camera, remove_objects, remove_materials, remove_scene, switch_scene,
    switch_workspace, change_layout, split, undo, second_job, clear_views, other_file, save,
)  # fmt: skip


def pair(start, action):
    def case(ui):
        yield from start(ui)
        if not ui.job:
            ui.results[f"{start.__name__}+{action.__name__}"] = {"note": "the job had ended already"}
        action(ui)
        yield 0.2

    return case


CASES = {
    f"{start.__name__}+{action.__name__}": pair(start, action)
    for start in (detect, build, render)
    for action in ACTIONS
}


# ---------------------------------------------------------------- the extension switched off


def switched(ui, on):
    with ui.context(None):
        (bpy.ops.preferences.addon_enable if on else bpy.ops.preferences.addon_disable)(module=EXTENSION)


def off_during(start):
    def case(ui):
        name = f"off+{start.__name__}"
        yield from start(ui)
        switched(ui, False)
        yield 0.3
        ui.results[name] = {"off": off_state(), "data": left_behind(ui)}
        ui.shot(name)
        yield from ui.key("ESC", "PROPERTIES")
        switched(ui, True)
        yield 0.3

    return case


def off_state():
    """What of ours Blender still knows."""
    handlers = state()["handlers"]
    return {
        "handlers": [one for each in handlers.values() for one in each if EXTENSION in one],
        "types": [name for name in dir(bpy.types) if name.startswith("SPECTRAL_PROBE_")],
        "modal": state()["modal"],
        "menus": [
            f"{kind}: {one.__module__}"
            for kind in dir(bpy.types)
            for one in getattr(getattr(getattr(bpy.types, kind), "draw", None), "_draw_funcs", ())
            if EXTENSION in one.__module__
        ],
        "keymaps": [
            item.idname
            for keymap in bpy.context.window_manager.keyconfigs.addon.keymaps
            for item in keymap.keymap_items
            if item.idname.startswith("spectral_probe")
        ],
        "properties": [
            owner.__name__
            for owner in (bpy.types.Scene, bpy.types.Material, bpy.types.Light, bpy.types.WindowManager)
            if any("spectral_probe" in prop.identifier for prop in owner.bl_rna.properties)
        ],
    }


def off_and_on(ui):
    seen = []
    for _ in range(3):
        switched(ui, False)
        yield 0.3
        seen.append(off_state())
        switched(ui, True)
        yield 0.3
    ui.results["off_and_on"] = {"off": seen}


CASES |= {f"off+{start.__name__}": off_during(start) for start in (detect, build, render, rendering)}
CASES["off_and_on"] = off_and_on


def drag_handle(ui):
    """The outline's centre, held by the mouse."""
    yield from ui.show("IMAGE_EDITOR", "VIEW_3D")
    ui.operator("spectral_probe.import_capture", "EXEC_DEFAULT", at=None, filepath=ui.words[0])
    ui.operator("spectral_probe.detect_ball", at="IMAGE_EDITOR")
    yield from ui.wait_job()
    yield 0.5
    region, view = ui.region("IMAGE_EDITOR"), ui.scene.spectral_probe.views[0]
    x, y = module("operators.edit_outline").space_of(region, view).to_region(80.0, 60.0)
    x, y = int(region.x + x), int(region.y + y)
    yield from ui.move(x, y)
    yield 0.2
    ui.window.event_simulate(type="LEFTMOUSE", value="PRESS", x=x, y=y)
    yield 0.1
    for step in (10, 20):
        yield from ui.move(x + step, y)
    ui.results["dragged"] = state()["modal"], list(view.outline_px)
    ui.state = {**state(), "modal": []}


def draw_region(ui):
    """Two corners of a polygon."""
    yield from ui.show("IMAGE_EDITOR", "VIEW_3D")
    small_probe(ui)
    ui.scene.spectral_probe.region.kind, ui.scene.spectral_probe.region.polygon = (
        "POLYGON",
        "0 0, 20 0, 20 20",
    )
    ui.operator("spectral_probe.show_panorama", at="IMAGE_EDITOR")
    yield from ui.wait_job()
    yield 0.5
    ui.operator("spectral_probe.draw_region", at="IMAGE_EDITOR")
    region = ui.region("IMAGE_EDITOR")
    for share in (0.45, 0.55):
        yield from ui.click(region.x + int(share * region.width), region.y + region.height // 2)
    ui.results["drawn"] = state()["modal"], ui.scene.spectral_probe.region.polygon
    ui.state = {**state(), "modal": []}


def off_during_drag(ui):
    yield from off_during(drag_handle)(ui)
    ui.results["after the drag"] = list(ui.scene.spectral_probe.views[0].outline_px)


def off_during_drawing(ui):
    yield from off_during(draw_region)(ui)
    ui.results["after drawing"] = ui.scene.spectral_probe.region.polygon


CASES |= {"off_during_drag": off_during_drag, "off_during_drawing": off_during_drawing}


# ---------------------------------------------------------------- what is dropped


def drops(ui):
    """Things that are no photographs, among such that are."""
    folder = Path(ui.words[1], "dropped")
    photograph = (Path(ui.words[0]).parent / "view_0.exr").read_bytes()
    (folder / "many").mkdir(parents=True)
    (folder / "empty").mkdir()
    for number in range(200):
        (folder / "many" / f"photo_{number:03}.exr").write_bytes(photograph)
    for name, content in {
        "video.mp4": b"\0\0\0\x18ftypmp42", "text.txt": b"no photograph", "text.jpg": b"no photograph",
        "broken.dng": b"II*\0\x08\0\0\0", "cut.exr": photograph[:500], "empty.png": b"", "good.exr": photograph,
    }.items():  # fmt: skip
        (folder / name).write_bytes(content)
    told = ui.results.setdefault("drops", {})
    for names in (
        ["many"], ["empty"], ["video.mp4"], ["text.txt"], ["text.jpg"], ["broken.dng"], ["cut.exr"], ["empty.png"],
        ["good.exr", "text.jpg", "broken.dng"], ["good.exr"],
    ):  # fmt: skip
        before = len(ui.reports())
        try:
            answer = ui.drop([folder / name for name in names], "VIEW_3D")
        except RuntimeError as problem:
            answer = {str(problem)}
        yield from ui.wait_job()
        views = [len(view.photos) for view in ui.scene.spectral_probe.views]
        told[", ".join(names)] = [
            sorted(answer),
            ui.reports()[before:],
            views if len(views) < 9 else len(views),
        ]
    files = [folder / "many" / f"photo_{number:03}.exr" for number in range(200)]
    before = len(ui.reports())
    ui.drop(files, "VIEW_3D")
    yield from ui.wait_job()
    told["200 files"] = [ui.reports()[before:], len(ui.scene.spectral_probe.views)]


CASES["drops"] = drops


LASTING = (
    "detect+remove_scene",
    "detect+second_job",
    "off+detect",
    "off_during_drag",
    "off_during_drawing",
)
"""What the test plays: no renders, which take seconds each."""
